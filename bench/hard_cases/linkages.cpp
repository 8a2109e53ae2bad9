// Closed loops: rows that repeat others, a singular start, starts that do not close.
#include "bench/hard_cases/cases.hpp"
#include "bench/hard_cases/truths.hpp"
#include "models/builders.hpp"

#include <Eigen/QR>
#include <fmt/format.h>

namespace gudgeon::hard {

namespace {

constexpr double g = 9.81;

Vec3 direction(const Circulation::Now& a) { return {a.sine, 0, a.cosine}; }

/// In-plane forces of A0, B0, C1, A1 on their second bodies (x, z), from Newton's and Euler's equations of
/// the three bars in the plane: nine equations for eight unknowns.
VecX plane_reactions(const Circulation::Now& a) {
    const double s = a.sine, c = a.cosine, w2 = a.rate * a.rate;
    const Eigen::Vector2d half(s / 2, c / 2), weight(0, -g);
    const Eigen::Vector2d top(a.acceleration * c - w2 * s, -a.acceleration * s - w2 * c);
    MatX m = MatX::Zero(9, 8);
    VecX rhs(9);
    // force number `joint` with this sign on a body at this arm; moment about Y: z fx - x fz
    const auto act = [&](int body, int joint, double sign, const Eigen::Vector2d& arm) {
        m(3 * body, 2 * joint) += sign;
        m(3 * body + 1, 2 * joint + 1) += sign;
        m(3 * body + 2, 2 * joint) += sign * arm[1];
        m(3 * body + 2, 2 * joint + 1) -= sign * arm[0];
    };
    const Eigen::Vector2d right(0.5, 0);
    act(0, 0, 1, -half); // crank0: A0 at its foot, B0 at its top
    act(0, 1, -1, half);
    act(1, 1, 1, -right); // coupler
    act(1, 2, -1, right);
    act(2, 2, 1, half); // crank1
    act(2, 3, 1, -half);
    rhs << top / 2 - weight, a.acceleration / 12, top - weight, 0, top / 2 - weight, a.acceleration / 12;
    return m.colPivHouseholderQr().solve(rhs);
}

/// Rows named as repeated that hold something in the plane, or no such count as three in each loop.
double wrongly_named(const Simulation& sim, int loops) {
    int wrong = std::abs(static_cast<int>(sim.redundancy().dependent.size()) - 3 * loops);
    for (const auto& dependence : sim.redundancy().dependent)
        for (const auto& [row, coefficient] : dependence.combination) {
            const std::string_view d = sim.system().rows[row].direction;
            wrong += d == "displacement along h" || d == "displacement along t";
        }
    wrong += std::abs(sim.redundancy().dof - 1);
    return wrong;
}

// Upright, errors grow as the motion itself does, by cosh(sqrt(pull) t). Forces follow by pull times the mass
// and the three bars that may stand behind one joint.
void planar_four_bar(Trial& trial) {
    const double tolerance = 1e-6, end = 0.5;
    const auto scene = [](int loops) {
        return build_mechanism("four-bar", {{"loops", std::to_string(loops)}});
    };
    double wrong = 0, moved = 0, reaction = 0, across = 0;
    for (const int loops : {1, 3}) {
        const Circulation truth{crank_pull(loops), 1};
        trial.run(scene(loops), tolerance, {end, 0.05}, [&](const Simulation& sim, const Sample& sample) {
            const Circulation::Now a = truth.at(sample.state.t);
            wrong = std::max(wrong, wrongly_named(sim, loops));
            for (int k = 0; k <= loops; ++k) {
                const int crank = sim.system().body_index(fmt::format("crank{}", k));
                const Vec3 off = sample.motion[crank].r - Vec3(k, 0, 0) - 0.5 * direction(a);
                moved = std::max(moved, off.norm());
            }
            for (const Wrench& wrench : sample.joint)
                across = std::max({across, std::abs(wrench.force.y()), wrench.moment.norm()});
            if (loops > 1)
                return;
            const VecX exact = plane_reactions(a);
            for (const auto& [name, j] : {std::pair("A0", 0), {"B0", 1}, {"C1", 2}, {"A1", 3}}) {
                const Vec3& force = sample.joint[sim.system().joint_index(name)].force;
                reaction = std::max(
                    {reaction, std::abs(force.x() - exact[2 * j]), std::abs(force.z() - exact[2 * j + 1])});
            }
        });
    }
    const double growth = std::cosh(std::sqrt(crank_pull(1)) * end);
    const double bound = allowance(tolerance, end * std::sqrt(crank_pull(1)) / (2 * pi), 1, growth);
    trial.hold("rows wrongly named", wrong, 0);
    trial.hold("off the exact branch, m", moved, bound);
    trial.hold("reactions in the plane, N", reaction, 3 * crank_pull(1) * bound);
    trial.hold("reactions across it, N, N m", across, 1e-10 * 3 * g);
}

/// The ready four-bar turned by an angle about the feet of its cranks, these turning at a speed.
Model turned_four_bar(double angle, double speed) {
    Model model = build_mechanism("four-bar");
    const Vec3 arm(std::sin(angle), 0, std::cos(angle)), rate(0, speed, 0);
    const Vec3 feet[]{Vec3::Zero(), Vec3::UnitX()};
    const Vec4 turn{std::cos(angle / 2), 0, std::sin(angle / 2), 0};
    for (Body& body : model.bodies) {
        const bool coupler = body.name == "coupler1";
        const Vec3 foot = coupler ? Vec3(0.5, 0, 0) : feet[body.name == "crank1"];
        body.position = foot + (coupler ? 1 : 0.5) * arm;
        body.velocity = rate.cross(body.position - foot);
        if (coupler)
            continue;
        const Mat3 axes = rotation(turn) * rotation(body.orientation);
        body.orientation = euler_parameters(axes);
        body.angular_velocity = axes.transpose() * rate;
    }
    for (Joint& joint : model.joints) {
        const Vec3 foot = feet[joint.name == "A1" || joint.name == "C1"];
        joint.points[0] = joint.points[1] = joint.name[0] == 'A' ? foot : foot + arm;
    }
    model.markers.clear();
    return model;
}

// Once with the speed of the exact motion from the upright position (flat again on the way), once from rest,
// to just before it stands still and flat on the other side.
void flat_from_the_start(Trial& trial) {
    const double tolerance = 1e-7, pull = crank_pull(1);
    const Circulation over{pull, 1};
    const double flat = over.time_at(pi / 2);
    double moving = 0, resting = 0, rows = 0;
    trial.run(turned_four_bar(pi / 2, over.at(flat).rate), tolerance, {0.6, 0.02},
              [&](const Simulation& sim, const Sample& sample) {
                  rows = std::max(rows, std::abs(static_cast<double>(sim.redundancy().dependent.size()) - 4));
                  const Vec3 arm = direction(over.at(flat + sample.state.t));
                  const int second = sim.system().body_index("crank1");
                  moving = std::max({moving, (sample.motion[0].r - 0.5 * arm).norm(),
                                     (sample.motion[second].r - Vec3::UnitX() - 0.5 * arm).norm()});
              });
    const Swing swing{pull, pi / 2};
    const double end = 0.45 * swing.period();
    trial.run(turned_four_bar(pi / 2, 0), tolerance, {end, end / 20},
              [&](const Simulation& sim, const Sample& sample) {
                  const double theta = swing.at(sample.state.t).theta;
                  const Vec3 arm(std::sin(theta), 0, -std::cos(theta));
                  const int second = sim.system().body_index("crank1");
                  resting = std::max({resting, (sample.motion[0].r - 0.5 * arm).norm(),
                                      (sample.motion[second].r - Vec3::UnitX() - 0.5 * arm).norm()});
              });
    trial.hold("repeated rows at the start, other than 4", rows, 0);
    trial.hold("started with speed, m", moving, allowance(tolerance, 1, 1));
    trial.hold("started from rest, m", resting, allowance(tolerance, 1, 1));
}

/// Two free bodies of 1 and 3 kg, joined at their mass centres, which are 1e-2 m apart.
Model apart() {
    Model model;
    model.gravity = Vec3::Zero();
    model.bodies = {make_body("light", 1, Vec3::Constant(0.1), Vec3::Zero()),
                    make_body("heavy", 3, Vec3::Constant(0.1), {0, 0, 1e-2})};
    Joint joint = make_joint("J", JointKind::spherical, "light", "heavy", Vec3::Zero());
    joint.body_frame = true;
    model.joints = {joint};
    return model;
}

// Least movement in the mass norm: a gap between two mass centres closes in the inverse ratio of the masses;
// a bob off its circle moves along its rod; a coupler beside its plane returns to it. What follows is the
// motion of the exact start.
void open_at_the_start(Trial& trial) {
    const double tolerance = 1e-7;
    double shared = 0, bob = 0, beside = 0, open = 0;
    trial.run(apart(), tolerance, {1}, [&](const Simulation&, const Sample& sample) {
        for (const int body : {0, 1})
            shared = std::max(shared, (sample.motion[body].r - Vec3(0, 0, 7.5e-3)).norm());
    });
    Model pendulum = build_mechanism("pendulum");
    pendulum.bodies[0].start_position = Vec3(-1.01, 0, 0);
    pendulum.bodies[0].velocity = {0.01, 0, 0}; // along the rod as well
    const Swing swing{g, pi / 2};
    trial.run(pendulum, tolerance, {2, 0.1}, [&](const Simulation& sim, const Sample& sample) {
        open = std::abs(sim.assembly().position_before - 1e-2);
        const double theta = swing.at(sample.state.t).theta;
        bob = std::max(bob, (sample.motion[0].r + Vec3(std::sin(theta), 0, std::cos(theta))).norm());
    });
    Model bars = build_mechanism("four-bar");
    bars.bodies[2].start_position = bars.bodies[2].position + Vec3(0, 1e-2, 0);
    const Circulation truth{crank_pull(1), 1};
    trial.run(bars, tolerance, {0.5, 0.05}, [&](const Simulation&, const Sample& sample) {
        const Vec3 arm = direction(truth.at(sample.state.t));
        beside = std::max({beside, (sample.motion[0].r - 0.5 * arm).norm(),
                           (sample.motion[2].r - Vec3(0.5, 0, 0) - arm).norm()});
    });
    trial.hold("violation seen, off by, m", open, 1e-12);
    trial.hold("gap shared, m", shared, 1e-10);
    trial.hold("pendulum, m", bob, allowance(tolerance, 1, 1));
    trial.hold("four-bar, m", beside, allowance(tolerance, 1, 1, std::cosh(std::sqrt(crank_pull(1)) * 0.5)));
}

} // namespace

std::vector<HardCase> linkage_cases() {
    return {{"PlanarFourBar",
             "parallelograms of one and three loops drawn in space: three repeated rows a loop",
             planar_four_bar},
            {"FlatFromTheStart", "a parallelogram that starts flat: redundant and singular at once",
             flat_from_the_start},
            {"OpenAtTheStart", "closure violated by 1e-2 m at the start", open_at_the_start}};
}

} // namespace gudgeon::hard

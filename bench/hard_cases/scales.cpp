// Large and small side by side: masses, stiffnesses, inertias, lengths.
#include "bench/hard_cases/cases.hpp"
#include "bench/hard_cases/truths.hpp"
#include "models/builders.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>

#include <functional>

namespace gudgeon::hard {

namespace {

constexpr const char* ill_conditioned =
    "the scaled matrix has a condition number near 1e13: its solutions lose rows of the constraints (G dq = "
    "-Phi left open by as much as Phi), so that hardly a step closes, or multipliers are lost (which, the "
    "last bits decide); 1e-4 ... 1e4 "
    "kg run";

constexpr double g = 9.81;
const std::string away = "off the perfect hinge, m", reaction = "force of the hinge, of itself";
const std::string iterative =
    "sweeps are solved to 1e-5 of their residual, which at 1e12 N/m is all the spring's; with 1e-10 the "
    "errors are 6e-5 m and 1e-3";

Model weighed_chain(const std::vector<double>& mass) {
    Model model = build_mechanism("chain", {{"links", std::to_string(mass.size())}, {"thin", "1"}});
    for (std::size_t k = 0; k < mass.size(); ++k) {
        model.bodies[k].mass *= mass[k];
        model.bodies[k].inertia *= mass[k];
    }
    return model;
}

/// Masses of 13 links, kg, by their powers of ten.
std::vector<double> masses(const std::function<double(int)>& power) {
    std::vector<double> out;
    for (int k = 0; k < 13; ++k)
        out.push_back(std::pow(10.0, power(k)));
    return out;
}

/// Stretched out and turning about the origin, no weight.
Model turning(const std::vector<double>& mass, double speed) {
    Model model = weighed_chain(mass);
    model.gravity = Vec3::Zero();
    for (Body& body : model.bodies) {
        body.angular_velocity = {0, speed, 0};
        body.velocity = body.angular_velocity.cross(body.position);
    }
    return model;
}

using Long = long double;
using LongVec = Eigen::Matrix<Long, Eigen::Dynamic, 1>;
using LongMat = Eigen::Matrix<Long, Eigen::Dynamic, Eigen::Dynamic>;

/// The chain as n angles (of each rod above X) with its full mass matrix, by Runge-Kutta steps: no
/// constraint.
class RodAngles {
  public:
    explicit RodAngles(std::vector<double> mass)
        : n_(static_cast<int>(mass.size())), c_(n_, n_), weight_(n_) {
        for (int i = 0; i < n_; ++i) {
            Long beyond = 0;
            for (int k = i + 1; k < n_; ++k)
                beyond += mass[k];
            weight_[i] = g * (beyond + mass[i] / 2);
            for (int j = 0; j < i; ++j)
                c_(i, j) = c_(j, i) = beyond + mass[i] / 2;
            c_(i, i) = beyond + mass[i] / 3;
        }
    }
    /// The tip after `end` from rest at these angles, m.
    Eigen::Matrix<Long, 2, 1> tip(LongVec angle, Long end, int steps) const {
        LongVec rate = LongVec::Zero(n_);
        const Long h = end / steps;
        for (int s = 0; s < steps; ++s) {
            const LongVec a1 = acceleration(angle, rate), r2 = rate + h / 2 * a1,
                          a2 = acceleration(angle + h / 2 * rate, r2), r3 = rate + h / 2 * a2,
                          a3 = acceleration(angle + h / 2 * r2, r3), r4 = rate + h * a3,
                          a4 = acceleration(angle + h * r3, r4);
            angle += h / 6 * (rate + 2 * r2 + 2 * r3 + r4);
            rate += h / 6 * (a1 + 2 * a2 + 2 * a3 + a4);
        }
        return {angle.array().cos().sum(), angle.array().sin().sum()};
    }

  private:
    LongVec acceleration(const LongVec& angle, const LongVec& rate) const {
        LongMat m(n_, n_);
        LongVec f(n_);
        for (int i = 0; i < n_; ++i) {
            f[i] = -weight_[i] * std::cos(angle[i]);
            for (int j = 0; j < n_; ++j) {
                m(i, j) = c_(i, j) * std::cos(angle[i] - angle[j]);
                f[i] -= c_(i, j) * std::sin(angle[i] - angle[j]) * rate[j] * rate[j];
            }
        }
        return m.llt().solve(f);
    }

    int n_;
    LongMat c_;
    LongVec weight_;
};

/// Turns the chain once; how far it leaves the circle (m), and the pull of its joints the truth (of itself).
void turn_once(Trial& trial, const std::vector<double>& mass, const SimulationOptions& options, double& place,
               double& pull) {
    const double speed = 2;
    trial.run(turning(mass, speed), options, {2 * pi / speed, 0.1 * pi},
              [&](const Simulation&, const Sample& sample) {
                  const double a = speed * sample.state.t;
                  const Vec3 out(std::cos(a), 0, -std::sin(a));
                  double force = 0;
                  for (std::size_t k = mass.size(); k-- > 0;) {
                      const double r = static_cast<double>(k) + 0.5;
                      force += mass[k] * r * speed * speed;
                      place = std::max(place, (sample.motion[k].r - r * out).norm());
                      pull = std::max(pull, (sample.joint[k].force + force * out).norm() / force);
                  }
              });
}

// Turning chains stay straight whatever their masses, and each joint pulls what lies beyond it on its circle.
// The falling chain gets lighter outwards (inwards it could not be followed by explicit steps); how much it
// blows up errors is that of a small turn of all its rods.
void mass_ratios(Trial& trial) {
    const double tolerance = 1e-6;
    const std::pair<const char*, std::vector<double>> orders[]{
        {"growing", masses([](int k) { return (k - 6) / 2.0; })},
        {"falling", masses([](int k) { return 6.0 - k; })},
        {"in turn", masses([](int k) { return k % 2 ? 3.0 : -3.0; })}};
    double place = 0, pull = 0;
    for (const auto& [name, mass] : orders)
        turn_once(trial, mass, trial.options(tolerance), place, pull);
    const double bound = allowance(tolerance, 1, 13);
    trial.hold("turning once: off the circle, m", place, bound);
    trial.hold("pull of the joints, of itself", pull, bound);
    const double end = 0.5;
    const int links = 13;
    const RodAngles rods(orders[1].second);
    static const auto exact = rods.tip(LongVec::Zero(links), end, 2000);
    static const auto coarse = rods.tip(LongVec::Zero(links), end, 1000);
    static const double growth =
        static_cast<double>((rods.tip(LongVec::Constant(links, 1e-6), end, 1000) - coarse).norm()) / 1e-6;
    const Sample last = trial.run(weighed_chain(orders[1].second), tolerance, {end});
    const BodyMotion& link = last.motion[links - 1];
    const Vec3 tip = link.r + link.A * Vec3(0.5, 0, 0);
    trial.hold("the reference's own error, m", static_cast<double>((exact - coarse).norm()), tolerance);
    trial.hold("falling 0.5 s: tip, m",
               std::hypot(tip.x() - static_cast<double>(exact[0]), tip.z() - static_cast<double>(exact[1])),
               allowance(tolerance, 1, 13, std::max(1.0, growth / links)));
}

// As above. The start and what it pulls with are exact to 12 digits; steps are another matter.
void light_holds_heavy(Trial& trial) {
    const double tolerance = 1e-6;
    const std::vector<double> mass = masses([](int k) { return k - 6.0; });
    SimulationOptions options = trial.options(tolerance);
    options.integration.max_steps = 2000;
    double place = 0, pull = 0, force = 0;
    for (std::size_t k = 0; k < mass.size(); ++k)
        force += mass[k] * (static_cast<double>(k) + 0.5) * 4;
    Simulation start(turning(mass, 2), options);
    trial.hold("pull at the start, of itself", std::abs(start.sample().joint[0].force.norm() / force - 1),
               1e-9);
    turn_once(trial, mass, options, place, pull);
    trial.hold("turning once: off the circle, m", place, allowance(tolerance, 1, 13));
    trial.hold("pull of the joints, of itself", pull, allowance(tolerance, 1, 13));
}

/// A bar that hangs from a hinge in rubber 1 m from its mass centre, level at the start.
struct RubberHinge {
    double stiffness;
    static constexpr double mass = 1, inertia = 0.1, damping_share = 0.1;
    double damping() const { return 2 * damping_share * std::sqrt(stiffness * mass); }

    Model model() const {
        Model out;
        out.bodies = {make_body("bar", mass, {1e-3, inertia, inertia}, {1, 0, 0})};
        Joint joint = make_joint("hinge", JointKind::revolute, "ground", "bar", Vec3::Zero(), Vec3::UnitY());
        joint.fidelity = Fidelity::bushing;
        joint.bushing = Bushing{};
        for (int i = 0; i < 5; ++i) { // the last turns about the hinge's own axis
            joint.bushing->stiffness[i] = stiffness;
            joint.bushing->damping[i] = damping();
        }
        out.joints = {joint};
        return out;
    }

    /// x, z, angle (below X) and their rates by Runge-Kutta steps, 50 to a radian of the fastest mode.
    Vec6 state(double end) const {
        const double fastest = std::sqrt(stiffness * (1 / mass + 1 / inertia));
        const long steps = std::lround(50 * end * (fastest + 10));
        Vec6 y;
        y << 1, 0, 0, 0, 0, 0;
        const auto rates = [&](const Vec6& s) {
            const double c = std::cos(s[2]), d = std::sin(s[2]);
            const double x = s[0] - c, z = s[1] + d; // of the hinge's point on the bar
            const double vx = s[3] + d * s[5], vz = s[4] + c * s[5];
            const double fx = -stiffness * x - damping() * vx, fz = -stiffness * z - damping() * vz;
            Vec6 out;
            out << s[3], s[4], s[5], fx / mass, fz / mass - g, (d * fx + c * fz) / inertia;
            return out;
        };
        const double h = end / static_cast<double>(steps);
        for (long i = 0; i < steps; ++i) {
            const Vec6 k1 = rates(y), k2 = rates(y + h / 2 * k1), k3 = rates(y + h / 2 * k2),
                       k4 = rates(y + h * k3);
            y += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
        }
        return y;
    }
};

MatX dense(const CscMatrix& m) {
    MatX out = MatX::Zero(m.pattern.rows, m.pattern.cols);
    for (int c = 0; c < m.pattern.cols; ++c)
        for (int i = m.pattern.col_start[c]; i < m.pattern.col_start[c + 1]; ++i)
            out(m.pattern.row[i], c) += m.values[i];
    return out;
}

/// Least eigenvalue of the symmetric part of a M + C + S/a over what the constraints leave free, of the
/// largest. Where it is negative no penalty on the constraints makes that matrix positive definite. Larger a
/// only add to it.
double definiteness(Model model, const SimulationOptions& options, double t, double a) {
    Simulation sim(std::move(model), options);
    sim.advance_to(t);
    const Simulation::Matrices m = sim.matrices();
    const MatX A = a * dense(m.M) + dense(m.C) + dense(m.K) / a;
    const MatX free = m.G.pattern.rows == 0 ? MatX(MatX::Identity(A.rows(), A.cols()))
                                            : MatX(Eigen::FullPivLU<MatX>(dense(m.G)).kernel());
    const MatX basis =
        Eigen::HouseholderQR<MatX>(free).householderQ() * MatX::Identity(free.rows(), free.cols());
    const VecX values =
        Eigen::SelfAdjointEigenSolver<MatX>(basis.transpose() * (A + A.transpose()) / 2 * basis)
            .eigenvalues();
    return values.minCoeff() / values.cwiseAbs().maxCoeff();
}

// Up to 1e6 N/m the truth is three equations by short explicit steps.
void soft_bushings(Trial& trial) {
    const double tolerance = 1e-6, end = 2;
    double off = 0;
    for (const double stiffness : {1e2, 1e3, 1e4, 1e5, 1e6}) {
        const RubberHinge hinge{stiffness};
        const Vec3 r = trial.run(hinge.model(), tolerance, {end}).motion[0].r;
        const Vec6 truth = hinge.state(end);
        off = std::max(off, std::hypot(r.x() - truth[0], r.z() - truth[1]));
    }
    trial.hold("mass centre, m", off, allowance(tolerance, end * std::sqrt(1e2 * 11) / (2 * pi), 1));
}

// Above, the motion is that of the pendulum on a perfect hinge but for the hinge's give, at most 3 m g over
// the stiffness, twice that while it rings. No step needs to follow the stiff spring: some thousand are for
// its first ring and for noise.
void stiff_bushings(Trial& trial, const std::vector<double>& all) {
    const double tolerance = 1e-6, end = 2, weight = RubberHinge::mass * g;
    const Swing swing{g / (1 + RubberHinge::inertia), pi / 2};
    const Swing::Now now = swing.at(end);
    const Vec3 perfect(std::sin(now.theta), 0, -std::cos(now.theta));
    const double force = (2 / (1 + RubberHinge::inertia) + 1) * weight * std::cos(now.theta); // along the bar
    double off = 0, pull = 0, steps = 0;
    for (const double stiffness : all) {
        const Sample last = trial.run(RubberHinge{stiffness}.model(), tolerance, {end});
        steps = std::max(steps, static_cast<double>(trial.work().steps));
        off = std::max(off, (last.motion[0].r - perfect).norm() - 6 * weight / stiffness);
        pull = std::max(pull, std::abs(last.joint[0].force.dot(-perfect) / force - 1));
    }
    const double bound = allowance(tolerance, end / swing.period(), 1);
    trial.hold(away, off, bound);
    trial.hold(reaction, pull, 10 * bound);
    trial.hold("steps of the longest run", steps, 10'000);
}

// Matrices belong to predicted poses, which are off by a tolerance: a hinge pressed in by that much at 1e10
// N/m bears 1e4 N, whose geometric terms outweigh inertia.
void stiffest_bushings(Trial& trial) {
    stiff_bushings(trial, {1e10, 1e11, 1e12});
    Model pressed = RubberHinge{1e10}.model();
    pressed.bodies[0].start_position = Vec3(1 - 1e-6, 0, 0);
    trial.hold("least eigenvalue of sym A, hinge pressed in by 1e-6 m",
               definiteness(pressed, trial.options(1e-6), 0, 30), 0);
}

// Without inertia about its own axis a top is a pendulum: what 1e-9 kg m2 at 40 rad/s turn it aside is 1e-6
// rad. No moment acts about that axis, so the spin stays.
void tiny_inertia(Trial& trial, double across, bool indefinite) {
    const double tolerance = 1e-7, end = 2, arm = 0.3, spin = 40;
    Model model = build_mechanism("heavy-top", {{"spin", "0"}});
    model.bodies[0].inertia = Vec3(across, across, 1e-9).asDiagonal();
    model.bodies[0].angular_velocity = {0, 0, spin};
    const Swing swing{g * arm / (across + arm * arm), pi - pi / 3};
    double place = 0, turn = 0;
    trial.run(model, tolerance, {end, 0.05}, [&](const Simulation&, const Sample& sample) {
        const double theta = swing.at(sample.state.t).theta;
        const Vec3 truth = arm * Vec3(std::sin(theta), 0, -std::cos(theta));
        place = std::max(place, (sample.motion[0].r - truth).norm());
        turn = std::max(turn, std::abs(sample.motion[0].w.z() / spin - 1));
    });
    const double turns = end * spin / (2 * pi);
    trial.hold("mass centre, m", place, allowance(tolerance, turns, 1) + 1e-6);
    trial.hold("spin, of itself", turn, allowance(tolerance, turns, 0));
    const double a = 3.64 * static_cast<double>(trial.work().steps) / end; // radau's; gear's are smaller
    if (indefinite)
        trial.hold("least eigenvalue of free sym A", definiteness(model, trial.options(tolerance), 0.5, a),
                   0);
}

/// A steel bar of 10 m that swings, and a part of 1 um hung on it where it swings as a mathematical pendulum
/// does (2/3 of its length). Starts hanging, at a speed.
struct MoteOnBar {
    static constexpr double length = 10, heavy = 600, light = 7.8e-15, arm = 1e-6;

    Model model(double speed) const {
        const Vec3 hook(0, 0, -2 * length / 3), rate(0, speed, 0);
        const double across = heavy * length * length / 12, own = light * arm * arm / 6;
        Model out;
        out.bodies = {make_body("bar", heavy, {across, across, 1}, {0, 0, -length / 2}),
                      make_body("mote", light, {own, own, own}, hook - Vec3(0, 0, arm))};
        for (Body& body : out.bodies) {
            body.velocity = rate.cross(body.position);
            body.angular_velocity = rate;
        }
        out.joints = {make_joint("hinge", JointKind::revolute, "ground", "bar", Vec3::Zero(), Vec3::UnitY()),
                      make_joint("hook", JointKind::revolute, "bar", "mote", hook, Vec3::UnitY())};
        return out;
    }
};

// At that point the apparent weight lies along the bar, so the mote keeps pointing along it but for its own
// length over that of the pendulum, 2e-7 rad. The hook is closed to 1e-10 m, 1e-4 of the mote.
void micro_and_macro(Trial& trial) {
    const double tolerance = 1e-5, end = 5;
    const Swing swing{g / (2 * MoteOnBar::length / 3), pi / 3};
    const double quarter = swing.period() / 4, full = MoteOnBar::light * g;
    double bar = 0, mote = 0, pull = 0;
    trial.run(MoteOnBar{}.model(-swing.at(quarter).rate), tolerance, {end, 0.1},
              [&](const Simulation&, const Sample& sample) {
                  const Swing::Now now = swing.at(quarter + sample.state.t); // theta is that towards X
                  const Vec3 along(std::sin(now.theta), 0, -std::cos(now.theta));
                  bar = std::max(bar, (sample.motion[0].r - MoteOnBar::length / 2 * along).norm());
                  const Vec3 own = sample.motion[1].A.col(2), its_bar = sample.motion[0].A.col(2);
                  mote = std::max(mote, own.cross(its_bar).norm());
                  const double stretch =
                      std::cos(now.theta) + now.rate * now.rate * (2 * MoteOnBar::length / 3) / g;
                  pull = std::max(pull, (sample.joint[1].force + full * stretch * along).norm() / full);
              });
    const double own = std::sqrt(g / MoteOnBar::arm / (7.0 / 6)); // rad/s
    const double off = allowance(tolerance, end * own / (2 * pi), 1) / own + 1e-4;
    trial.hold("bar, m", bar, 5 * allowance(tolerance, end / swing.period(), 1));
    trial.hold("mote against bar, rad", mote, off);
    trial.hold("force on the mote, of its weight", pull, 3 * off);
}

} // namespace

std::vector<HardCase> scale_cases() {
    return {
        {"MassRatios",
         "chains of 13 links: 1e-3 ... 1e3 kg outwards, 1e6 ... 1e-6 kg outwards, 1e-3 and 1e3 kg in turn",
         mass_ratios},
        {"LightHoldsHeavy",
         "13 links of 1e-6 ... 1e6 kg outwards: the lightest holds all",
         light_holds_heavy,
         false,
         "",
         {{"stops", "gear saddle-point", ill_conditioned},
          {"stops", "radau", ill_conditioned},
          {"", "gear augmented-lagrangian", ill_conditioned}}},
        {"SoftBushings", "a pendulum on a rubber hinge of 1e2 ... 1e6 N/m", soft_bushings},
        {"StiffBushings", "the same of 1e7 ... 1e9 N/m",
         [](Trial& t) {
             stiff_bushings(t, {1e7, 1e8, 1e9});
         }},
        {"StiffestBushings",
         "the same of 1e10 ... 1e12 N/m",
         stiffest_bushings,
         false,
         "predicted poses press stiff springs so that A itself is indefinite there (last number)",
         {{away, "gear augmented-lagrangian", iterative},
          {reaction, "gear augmented-lagrangian", iterative}}},
        {"PointLikeTop", "a top of 1e-9 kg m2 about every axis",
         [](Trial& t) { tiny_inertia(t, 1e-9, false); }},
        {"SlenderTop", "a top of 1e-9 kg m2 about its own axis, 0.02 across it",
         [](Trial& t) { tiny_inertia(t, 0.02, true); }, false,
         "gyroscopic terms of 0.02 kg m2 couple the tiny inertia: the symmetric part of A has a negative "
         "eigenvalue over what the constraints leave free (last number), which no penalty changes"},
        {"MicroAndMacro", "parts of 1 um and of 10 m in one scene", micro_and_macro}};
}

} // namespace gudgeon::hard

// Consistent starts: rounded data, held coordinates, mechanisms that cannot be closed, repeated rows.
#include "solvers/initial.hpp"
#include "solvers/redundancy.hpp"

#include "models/builders.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <set>

namespace gudgeon {
namespace {

using namespace test;

Vec3 rounded(const Vec3& x) { return (1000 * x).array().round() / 1000; }

/// The exact slider-crank with joints given in the frames of the bodies.
Model with_body_frames(Model model) {
    for (Joint& joint : model.joints) {
        for (int side : {0, 1}) {
            Body ground;
            const Body& body =
                joint.bodies[side] == "ground" ? ground : body_named(model, joint.bodies[side]);
            const Mat3 to_body = rotation(body.orientation).transpose();
            joint.points[side] = to_body * (joint.points[side] - body.position);
            if (joint.axes)
                (*joint.axes)[side] = to_body * (*joint.axes)[side];
        }
        joint.body_frame = true;
    }
    return model;
}

/// Table 2 of Ambrosio & Pombo: x, e1 e2 e3, v, omega' to three decimals.
Model table_2() {
    Model model = with_body_frames(build_mechanism("slider-crank"));
    for (Body& body : model.bodies) {
        const Vec3 e = rounded(body.orientation.tail<3>());
        body.position = rounded(body.position);
        body.orientation << std::sqrt(1 - e.squaredNorm()), e;
        body.velocity = rounded(body.velocity);
        body.angular_velocity = rounded(body.angular_velocity);
    }
    return model;
}

TEST(Assembly, RoundedTableOfTheSliderCrankCloses) {
    const Model table = table_2();
    EXPECT_EQ(table.bodies[1].orientation.tail<3>(), Vec3(-0.210, 0.397, -0.094)); // as printed
    EXPECT_EQ(table.bodies[1].angular_velocity, Vec3(-1.600, -1.073, 1.431));
    const System system = compiled(table);
    State state = initial_state(system);
    const AssemblyReport report = assemble_start(system, state);
    ASSERT_TRUE(report.ok) << report.message(system);
    EXPECT_GT(report.position_before, 5e-5);
    EXPECT_LT(report.position_before, 5e-4);
    EXPECT_GT(report.velocity_before, 1e-4);
    EXPECT_LT(report.position_after, 1e-12);
    EXPECT_LT(report.velocity_after, 1e-12);

    // reported is what moved, body by body
    const State exact = initial_state(compiled("slider-crank")), given = initial_state(system);
    ASSERT_FALSE(report.changes.empty());
    std::set<int> named;
    for (const AssemblyReport::Change& c : report.changes) {
        named.insert(c.body);
        EXPECT_LT(std::max({c.shift, c.turn}), 1e-3);
        EXPECT_LT(std::max({c.velocity, c.angular_velocity}), 5e-3);
        EXPECT_NEAR(c.shift, (state.q - given.q).segment<3>(7 * c.body).norm(), 1e-15);
        EXPECT_NEAR(c.velocity, (state.u - given.u).segment<3>(6 * c.body).norm(), 1e-15);
        EXPECT_NEAR(c.angular_velocity, (state.u - given.u).segment<3>(6 * c.body + 3).norm(), 1e-15);
        const Eigen::Quaterniond p0(given.q[7 * c.body + 3], given.q[7 * c.body + 4], given.q[7 * c.body + 5],
                                    given.q[7 * c.body + 6]);
        const Eigen::Quaterniond p1(state.q[7 * c.body + 3], state.q[7 * c.body + 4], state.q[7 * c.body + 5],
                                    state.q[7 * c.body + 6]);
        EXPECT_NEAR(c.turn, p0.angularDistance(p1), 1e-7);
    }
    for (int i = 0; i < system.moving; ++i)
        if (!named.contains(i)) {
            EXPECT_LT((state.q - given.q).segment<7>(7 * i).norm(), 1e-11);
        }
    // the rod was open most and is among them; all end near the exact start
    EXPECT_TRUE(named.contains(system.body_index("rod")));
    EXPECT_LT((state.q - exact.q).cwiseAbs().maxCoeff(), 1e-3);
    EXPECT_LT((state.u - exact.u).cwiseAbs().maxCoeff(), 5e-3);
}

TEST(Assembly, ExactStartIsLeftAlone) {
    const System system = compiled("slider-crank");
    State state = initial_state(system);
    const State given = state;
    const AssemblyReport report = assemble_start(system, state);
    EXPECT_TRUE(report.ok);
    EXPECT_TRUE(report.changes.empty());
    EXPECT_LT((state.q - given.q).norm() + (state.u - given.u).norm(), 1e-14);
}

TEST(Assembly, SimulationStartsFromTheAssembledState) {
    Simulation sim(table_2());
    EXPECT_GT(sim.assembly().position_before, 1e-5);
    Workspace ws = make_workspace(sim.system());
    const State start = sim.state();
    set_motion(sim.system(), start.q, start.u, ws);
    evaluate_constraints(sim.system(), 0, nullptr, false, ws);
    EXPECT_LT(ws.phi.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_LT(ws.rate.cwiseAbs().maxCoeff(), 1e-12);
}

/// Slider-crank whose crank stands and turns as the user says; rod and slider stay where they were.
Model crank_at(double angle, double speed) {
    Model model = with_body_frames(build_mechanism("slider-crank"));
    Body& crank = body_named(model, "crank");
    crank.orientation = {std::cos(angle / 2), std::sin(angle / 2), 0, 0};
    crank.position = Vec3(0, 0.1, 0.12) + 0.04 * Vec3(0, -std::sin(angle), std::cos(angle));
    crank.angular_velocity = {speed, 0, 0};
    crank.velocity = 0.04 * speed * Vec3(0, -std::cos(angle), -std::sin(angle));
    crank.hold = {"rx", "wx"};
    return model;
}

TEST(Assembly, HeldCrankKeepsAngleAndSpeed) {
    const double angle = 0.3, speed = 5;
    const System system = compiled(crank_at(angle, speed));
    State state = initial_state(system);
    const State given = state;
    const AssemblyReport report = assemble_start(system, state);
    ASSERT_TRUE(report.ok) << report.message(system);
    EXPECT_LT((state.q - given.q).head<7>().norm(), 1e-12);
    EXPECT_LT((state.u - given.u).head<6>().norm(), 1e-12);
    // the slider follows: |C - B| = 0.3 m
    const double by = 0.1 - 0.08 * std::sin(angle), bz = 0.12 + 0.08 * std::cos(angle);
    const double vy = -0.08 * speed * std::cos(angle), vz = -0.08 * speed * std::sin(angle);
    const double x = std::sqrt(0.09 - by * by - bz * bz);
    const int slider = system.body_index("slider");
    EXPECT_NEAR(state.q[7 * slider], x, 1e-12);
    EXPECT_NEAR(state.u[6 * slider], -(by * vy + bz * vz) / x, 1e-12);
    for (const AssemblyReport::Change& c : report.changes)
        EXPECT_NE(c.body, system.body_index("crank"));

    // free, it would have been moved too
    Model free = crank_at(angle, speed);
    free.bodies[0].hold.clear();
    const System other = compiled(free);
    State moved = initial_state(other);
    ASSERT_TRUE(assemble_start(other, moved).ok);
    EXPECT_GT((moved.q - given.q).head<7>().norm(), 1e-3);
}

/// Two cranks of 1 m with their feet 3 m apart and a coupler between their tops.
Model wide_four_bar(double coupler) {
    Model model;
    for (const auto& [name, x] : {std::pair("left", 0.0), {"right", 3.0}}) {
        Body crank = make_bar(name, 1.0 / 12, {x, 0, 0.5});
        crank.orientation = {std::sqrt(0.5), 0, -std::sqrt(0.5), 0};
        model.bodies.push_back(crank);
    }
    model.bodies.push_back(make_bar("coupler", 1.0 / 12, {1.5, 0, 1}));
    const auto add = [&](const char* name, const char* a, const char* b, const Vec3& pa, const Vec3& pb) {
        Joint joint = make_joint(name, JointKind::revolute, a, b, Vec3::Zero(), Vec3::UnitY());
        joint.body_frame = true;
        joint.points = {pa, pb};
        model.joints.push_back(joint);
    };
    const Vec3 half(0.5, 0, 0);
    add("A", "ground", "left", {0, 0, 0}, -half);
    add("B", "left", "coupler", half, {-coupler / 2, 0, 0});
    add("C", "coupler", "right", {coupler / 2, 0, 0}, half);
    add("D", "ground", "right", {3, 0, 0}, -half);
    return model;
}

TEST(Assembly, FourBarThatReachesCloses) {
    const System system = compiled(wide_four_bar(1.5));
    State state = initial_state(system);
    const AssemblyReport report = assemble_start(system, state);
    EXPECT_NEAR(report.position_before, 0.75, 1e-12);
    ASSERT_TRUE(report.ok) << report.message(system);
    EXPECT_LT(report.position_after, 1e-12);
}

TEST(Assembly, FourBarWithTooShortACouplerIsRefused) {
    const double coupler = 0.2; // 1 + 0.2 + 1 against 3 m
    const System system = compiled(wide_four_bar(coupler));
    State state = initial_state(system);
    const AssemblyReport report = assemble_start(system, state);
    EXPECT_FALSE(report.ok);
    ASSERT_FALSE(report.open.empty());
    EXPECT_EQ(report.open[0].by, report.open[0].by < 0 ? -report.position_after : report.position_after);
    // the gaps of the four joints together make up for the 0.8 m that miss
    Workspace ws = make_workspace(system);
    set_motion(system, state.q, state.u, ws);
    evaluate_constraints(system, 0, nullptr, false, ws);
    double gaps = 0;
    for (const JointRecord& joint : system.joints)
        gaps += ws.phi.segment<3>(joint.first_row).norm();
    EXPECT_GE(gaps, 0.8 - 1e-9);
    EXPECT_LT(gaps, 0.9); // and little more: it was pulled together as far as it goes
    for (std::size_t i = 0; i < report.open.size(); ++i) {
        EXPECT_EQ(report.open[i].by, ws.phi[report.open[i].row]);
        EXPECT_FALSE(report.open[i].velocity);
        if (i > 0) {
            EXPECT_LE(std::abs(report.open[i].by), std::abs(report.open[i - 1].by));
        }
    }
    const std::string text = report.message(system);
    EXPECT_NE(text.find("stays open by 0."), std::string::npos) << text;
    EXPECT_NE(text.find("joint '" + system.joints[system.rows[report.open[0].row].joint].name + "'"),
              std::string::npos)
        << text;
}

TEST(Assembly, SimulationRefusesWhatCannotBeClosed) {
    try {
        Simulation sim(wide_four_bar(0.2));
        FAIL() << "a four-bar that cannot be closed was accepted";
    } catch (const AssemblyError& error) {
        EXPECT_NE(std::string(error.what()).find("cannot be assembled"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("joint '"), std::string::npos) << error.what();
        EXPECT_FALSE(error.report().open.empty());
    }
}

/// A shaft in two bearings on one axis, the second driven too.
Model two_drives(double first, double second) {
    Model model;
    model.bodies = {make_body("shaft", 1, {0.1, 0.2, 0.2}, Vec3::Zero())};
    for (const auto& [name, speed] : {std::pair("motor", first), {"brake", second}}) {
        Joint joint = make_joint(name, JointKind::revolute, "ground", "shaft", Vec3::Zero(), Vec3::UnitX());
        joint.drives["angle"] = RampFunction{0, speed, 0};
        model.joints.push_back(joint);
    }
    return model;
}

TEST(Assembly, ContradictorySpeedsAreRefused) {
    const System system = compiled(two_drives(2, 3));
    State state = initial_state(system);
    const AssemblyReport report = assemble_start(system, state);
    EXPECT_LT(report.position_after, 1e-12);
    EXPECT_FALSE(report.ok);
    ASSERT_EQ(report.open.size(), 2u);
    std::set<std::string> joints;
    for (const AssemblyReport::Open& open : report.open) {
        EXPECT_TRUE(open.velocity);
        EXPECT_NEAR(std::abs(open.by), 0.5, 1e-6); // they meet at 2.5 rad/s
        EXPECT_EQ(system.rows[open.row].direction, "driven angle");
        joints.insert(system.joints[system.rows[open.row].joint].name);
    }
    EXPECT_EQ(joints, (std::set<std::string>{"motor", "brake"}));
    EXPECT_NE(report.message(system).find("speed violated by 0.5"), std::string::npos)
        << report.message(system);
}

TEST(Assembly, AgreeingSpeedsPass) {
    const System system = compiled(two_drives(2, 2));
    State state = initial_state(system);
    EXPECT_TRUE(assemble_start(system, state).ok);
    EXPECT_NEAR(state.u[3], 2, 1e-8);
}

TEST(Redundancy, FourBarRepeatsThreeRowsPerLoop) {
    for (const int loops : {1, 3}) {
        const System system = compiled("four-bar", {{"loops", std::to_string(loops)}});
        const RedundancyReport report = find_redundancy(system, initial_state(system));
        EXPECT_EQ(report.rows, 5 * (3 * loops + 1));
        EXPECT_EQ(report.rank, report.rows - 3 * loops);
        EXPECT_EQ(report.dof, 1);
        ASSERT_EQ(report.dependent.size(), static_cast<std::size_t>(3 * loops));
        // each combination vanishes, and stays within what keeps a plane mechanism plane
        Workspace ws = make_workspace(system);
        const MatX G = dense_rows(system, initial_state(system), ws);
        for (const RankReport::Dependence& d : report.dependent) {
            VecX sum = VecX::Zero(G.cols());
            for (const auto& [row, coefficient] : d.combination) {
                sum += coefficient * G.row(row).transpose();
                const std::string_view direction = system.rows[row].direction;
                EXPECT_TRUE(direction == "displacement along y" || direction.starts_with("tilt"))
                    << direction;
            }
            EXPECT_LT(sum.cwiseAbs().maxCoeff(), 1e-9);
        }
        const std::vector<std::string> lines = report.lines(system);
        ASSERT_EQ(lines.size(), report.dependent.size());
        for (const std::string& line : lines)
            EXPECT_NE(line.find(" repeats '"), std::string::npos) << line;
    }
}

TEST(Redundancy, OtherMechanismsHaveNone) {
    const std::vector<std::tuple<std::string, std::map<std::string, std::string>, int>> expected{
        {"pendulum", {}, 2},
        {"chain", {{"links", "4"}}, 4},
        {"chain", {{"links", "4"}, {"joint", "spherical"}}, 12},
        {"chain", {{"links", "4"}, {"joint", "universal"}}, 8},
        {"slider-crank", {}, 1},
        {"heavy-top", {}, 3},
        {"triple-pendulum", {}, 4},
        {"suspension-chain", {{"units", "2"}}, 14 * 6 - 8 * 3}, // 14 bodies, 8 spherical joints
    };
    for (const auto& [name, parameters, dof] : expected) {
        const System system = compiled(name, parameters);
        const RedundancyReport report = find_redundancy(system, initial_state(system));
        EXPECT_TRUE(report.dependent.empty()) << name;
        EXPECT_EQ(report.dof, dof) << name;
    }
}

} // namespace
} // namespace gudgeon

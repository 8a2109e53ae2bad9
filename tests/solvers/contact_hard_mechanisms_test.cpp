// Hard cases of bearings and of whole mechanisms with clearance. The bounds and their reasons stand beside
// each test.
#include "tests/solvers/hard_case_tools.hpp"

namespace gudgeon {
namespace {

using namespace hard_cases;
using test::joint_named;

// Without clearance contact begins at zero speed: Lankarani and Nikravesh's law is then elastic with the
// stiffness (1 + chi) K and dissipates nothing. What is left is a perfect joint on a stiff spring: the load
// of the perfect joint, at most tripled by undamped vibration, gives its depth, and the motion over 1 s parts
// by that depth times the growth of an error of the crank's angle (about 10).
TEST(HardMechanism, ZeroClearanceIsNearThePerfectJoint) {
    struct Case {
        const char *integrator, *stiffness;
        long steps;
    };
    for (const Case& c : {Case{"radau", "5e6", 6000}, Case{"gear", "5e6", 12000}, Case{"radau", "5e9", 25000},
                          Case{"radau", "5e12", 6000}}) {
        SCOPED_TRACE(std::string(c.integrator) + " at " + c.stiffness);
        std::vector<double> x;
        double load = 0;
        simulate(build_mechanism("slider-crank"), {"radau", 1e-10, 1, 0.01}, [&](const Sample& s) {
            x.push_back(s.state.q[14]);
            load = std::max(load, s.joint[1].force.norm());
        });
        double apart = 0, depth = 0;
        std::size_t i = 0;
        const HardRun run = simulate(
            build_mechanism("slider-crank",
                            {{"joint", "spherical"}, {"clearance", "0"}, {"stiffness", c.stiffness}}),
            {c.integrator, 1e-6, 1, 0.01}, [&](const Sample& s) {
                apart = std::max(apart, std::abs(s.state.q[14] - x[i++]));
                depth = std::max(depth, s.contacts[0].penetration);
            });
        const double K = (1 + factor(0.75)) * std::stod(c.stiffness);
        EXPECT_LT(depth, std::pow(3 * load / K, 1 / 1.5));
        EXPECT_GT(depth, 0.2 * std::pow(load / K, 1 / 1.5));
        EXPECT_LT(apart, 20 * depth);
        EXPECT_LT(std::abs(run.last.state.dissipated()), 1e-12);
        EXPECT_LT(run.balance, 2e-5);
        EXPECT_EQ(run.starts.size(), 1u);
        EXPECT_LT(run.statistics.steps, c.steps);
    }
}

TEST(HardMechanism, BallWithAMicrometre) {
    for (const char* integrator : {"radau", "gear"}) {
        SCOPED_TRACE(integrator);
        const HardRun run =
            simulate(build_mechanism("slider-crank", {{"joint", "spherical"}, {"clearance", "1e-6"}}),
                     {integrator, 1e-6, 1, 0.01});
        EXPECT_LT(run.balance, 1e-4);
        EXPECT_GT(run.last.state.dissipated(), 0);
        EXPECT_LE(run.statistics.rejected_contact, 20);
        EXPECT_LT(run.statistics.steps, 10000);
    }
}

TEST(HardMechanism, ConcentricJournalAtRest) {
    for (const double clearance : {1e-4, 0.0})
        for (const double turn : {0.0, pi}) {
            SCOPED_TRACE(clearance);
            const Model model = journal(clearance, turn, Vec3::Zero());
            const System system = test::compiled(model);
            Workspace ws = make_workspace(system);
            const State state = initial_state(system);
            set_motion(system, state.q, state.u, ws);
            evaluate_forces(system, 0, ws);
            linearise(system, 0, state.lambda.data(), ws);
            sample_contacts(system, 0, ws);
            EXPECT_EQ(ws.f.cwiseAbs().maxCoeff(), 0);
            EXPECT_TRUE(std::ranges::all_of(ws.lin.S, [](double x) { return std::isfinite(x); }));
            EXPECT_TRUE(std::ranges::all_of(ws.lin.C, [](double x) { return std::isfinite(x); }));
            for (const char* integrator : {"radau", "gear"}) {
                const HardRun run = simulate(model, {integrator, 1e-6, 10});
                EXPECT_EQ((run.last.state.q - state.q).norm(), 0);
                EXPECT_EQ(run.last.state.u.norm(), 0);
                EXPECT_LT(run.statistics.steps, 20);
            }
        }
}

// Parallel and antiparallel axes: the whole law along the line of centres and no moment; nearly parallel ones
// differ by the tilt times force and length and no more.
TEST(HardMechanism, ParallelAxes) {
    const Vec3 off(0, 6e-5, -1.2e-4);
    const double force = 1e8 * std::pow(off.norm() - 1e-4, 1.5);
    for (const double tilt : {0.0, pi, 1e-15, 1e-12, 1e-9, 1e-6}) {
        SCOPED_TRACE(tilt);
        const System system = test::compiled(journal(1e-4, tilt, off));
        Workspace ws = make_workspace(system);
        const State state = initial_state(system);
        set_motion(system, state.q, state.u, ws);
        ws.contacts.start_speed.setConstant(1);
        evaluate_forces(system, 0, ws);
        const double slant = tilt == pi ? 0 : tilt;
        const Vec3 wanted = -force * off.normalized();
        EXPECT_LT((Vec3(ws.f.head<3>()) - wanted).norm(), (1e-13 + 10 * slant) * force);
        // a tilt of 1 rad would change the depth at the ends by half the length
        EXPECT_LT(Vec3(ws.f.tail<3>()).norm(), 1e-16 * force + 1.5 * force / 5e-5 * 0.02 * 0.02 * slant);
    }
}

TEST(HardMechanism, ParallelAxesStayParallel) {
    for (const char* integrator : {"radau", "gear"}) {
        SCOPED_TRACE(integrator);
        Model model = journal(5e-4, 0, Vec3::Zero());
        model.bodies[0].velocity = {0, 0.03, 0.04};
        model.bodies[0].angular_velocity = {50, 0, 0};
        const HardRun run = simulate(model, {integrator, 1e-8, 0.03}); // one impact
        ASSERT_EQ(run.starts.size(), 16u);                             // at the same instant
        for (const ContactEvent& start : run.starts) {
            EXPECT_NEAR(start.t, 0.01, 1e-8);
            EXPECT_NEAR(start.speed, 0.05, 2e-6); // two hundred tolerances
        }
        const double ratio = speed_ratio(factor(0.75));
        EXPECT_NEAR(run.last.state.u[1], -0.03 * ratio, 1e-6);
        EXPECT_NEAR(run.last.state.u[2], -0.04 * ratio, 1e-6);
        EXPECT_LT(std::abs(run.last.state.u[4]) + std::abs(run.last.state.u[5]), 1e-10);
        EXPECT_NEAR(run.last.state.u[3], 50, 1e-9);
    }
}

/// A journal as long as its bearing on a spring of 900 N/m along the axis, started with this speed.
Model sliding_journal(double speed, const Vec3& position, double gravity) {
    Model model = journal(1e-4, 0, position, 1e9);
    model.gravity = {0, 0, -gravity};
    model.joints[0].clearance->journal_length = 0.04;
    model.bodies[0].velocity = {speed, 0, 0};
    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "journal"};
    spring.body_frame = true;
    spring.points = {Vec3(-1, 0, 0), Vec3::Zero()};
    spring.stiffness = 900;
    spring.free_length = 1;
    model.forces = {spring};
    return model;
}

// Lying in its bearing it slides out by 17 of 40 mm and back, to both sides, four times: strips are left bare
// and covered again at a depth. The energy (0.125 J) is kept to 1e-4 of it and is never won.
TEST(HardMechanism, JournalSlidesPartlyOutAndBack) {
    for (const char* integrator : {"radau", "gear"}) {
        SCOPED_TRACE(integrator);
        double out = 0, least = 0;
        const HardRun run = simulate(sliding_journal(0.5, {0, 0, -1e-4}, 9.81),
                                     {integrator, 1e-6, 0.4, 0.001}, [&](const Sample& s) {
                                         out = std::max(out, std::abs(s.state.q[0]));
                                         least = std::min(least, s.state.dissipated());
                                     });
        EXPECT_NEAR(out, 0.5 / 30, 1e-5);
        EXPECT_GT(run.starts.size(), 40u);
        EXPECT_LT(run.balance, 1.25e-5);
        EXPECT_GT(least, -1e-6);
        EXPECT_LT(run.last.state.dissipated(), 1.25e-3); // nothing hits hard
        EXPECT_LE(run.statistics.rejected_contact, 30);
        EXPECT_LT(run.statistics.steps, 5000);
    }
}

// It tips as well: strips appear at a depth, which no shorter step makes less.
TEST(HardMechanism, StripsThatAppearAtADepthAreNotTriedForEver) {
    for (const double tolerance : {1e-3, 1e-4, 1e-5}) {
        const HardRun run =
            simulate(sliding_journal(0.9, {0, 0, -1e-4}, 9.81), {"radau", tolerance, 0.4, 0.01});
        EXPECT_LT(run.statistics.rejected_contact, 50) << tolerance;
        EXPECT_LT(run.statistics.steps, 10000) << tolerance;
    }
}

// Wholly out and back without touching: the motion of the spring alone.
TEST(HardMechanism, JournalLeavesItsBearingUntouched) {
    for (const char* integrator : {"radau", "gear"}) {
        SCOPED_TRACE(integrator);
        double error = 0;
        const HardRun run = simulate(
            sliding_journal(2, Vec3::Zero(), 0), {integrator, 1e-8, 0.4, 0.01}, [&](const Sample& s) {
                error = std::max(error, std::abs(s.state.q[0] - 2.0 / 30 * std::sin(30 * s.state.t)));
            });
        EXPECT_TRUE(run.starts.empty());
        EXPECT_LT(error, 1e-5);
        EXPECT_LT(run.statistics.steps, 1500);
    }
}

Clearance play(double radial, double stiffness) {
    Clearance out;
    out.radial = radial;
    out.law = lankarani_nikravesh(stiffness, 0.75);
    return out;
}

/// No perfect joint is left: strips and end faces at A, a ball at B, a ball with a right angle of its own at
/// C, strips and a key at D.
Model all_in_clearance(double c) {
    Model model = build_mechanism("slider-crank");
    for (Joint& joint : model.joints)
        joint.fidelity = Fidelity::clearance;
    const ContactLaw bearing = lankarani_nikravesh(1e9, 0.75), angular = lankarani_nikravesh(1e4, 0.75);
    joint_named(model, "A").clearance = strip_bearing(0.01, 0.04, c, 8, bearing);
    joint_named(model, "A").clearance->axial = c;
    joint_named(model, "B").clearance = play(c, 1e8);
    joint_named(model, "C").clearance = play(c, 1e8);
    joint_named(model, "C").clearance->misalignment = 1e-3;
    joint_named(model, "C").clearance->rotation_law = angular;
    joint_named(model, "D").clearance = strip_bearing(0.01, 0.06, c, 8, bearing);
    joint_named(model, "D").clearance->rotation = 1e-3;
    joint_named(model, "D").clearance->rotation_law = angular;
    return model;
}

// Three free bodies of 18 degrees of freedom. Half a second, before neighbouring solutions part: both methods
// see the same slide to the tolerance, and stay within the sum of the clearances of the perfect mechanism
// (times 10, the crank's lag grows).
TEST(HardMechanism, AllJointsInClearance) {
    double perfect = 0;
    simulate(build_mechanism("slider-crank"), {"radau", 1e-9, 0.5},
             [&](const Sample& s) { perfect = s.state.q[14]; });
    double slide[2];
    for (const int i : {0, 1}) {
        const bool radau = i == 0;
        SCOPED_TRACE(radau ? "radau" : "gear");
        const HardRun run = simulate(all_in_clearance(1e-4), {radau ? "radau" : "gear", 1e-4, 0.5, 0.01});
        slide[i] = run.last.state.q[14];
        EXPECT_LT(run.balance, radau ? 1e-5 : 2e-3); // of 0.767 J
        EXPECT_GT(run.last.state.dissipated(), 0);
        EXPECT_LT(run.last.state.dissipated(), 0.1 * 0.767);
        for (const ContactHistory& joint : run.history)
            EXPECT_GT(joint.impacts, 0);
        EXPECT_LT(run.statistics.steps, radau ? 6000 : 16000); // some 230 contacts
        EXPECT_LE(run.statistics.rejected_contact, 30);
    }
    EXPECT_NEAR(slide[0], slide[1], 5e-4);
    EXPECT_NEAR(slide[0], perfect, 10 * 6e-4);
}

/// Independent worn bearings, pressed, clear and tilted.
Model thousand_bearings() {
    Model model;
    for (int k = 0; k < 1000; ++k) {
        const std::string name = "b" + std::to_string(k);
        const double z = 0.2 * k;
        Body body = make_body(name, 1, {1e-2, 1e-2, 1e-2}, {0, 0, z});
        body.orientation = Vec4(1, 1e-4 * (k % 7), 0, 0).normalized();
        body.velocity = {0.01 * (k % 5), 0.02 * (k % 3 - 1), 0};
        model.bodies.push_back(body);
        Joint joint = make_joint("J" + std::to_string(k), JointKind::revolute, "ground", name, Vec3::Zero());
        joint.body_frame = true;
        joint.points = {Vec3(0, 0, z + 1.5e-4 * (k % 3 - 1)), Vec3::Zero()};
        joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
        joint.fidelity = Fidelity::clearance;
        joint.clearance = strip_bearing(0.01, 0.04, 1e-4, 16, lankarani_nikravesh(1e8, 0.75));
        joint.clearance->axial = 1e-4;
        model.joints.push_back(joint);
    }
    return model;
}

TEST(HardMechanism, ThousandJointsOfSixteenStrips) {
    const System system = test::compiled(thousand_bearings());
    const State state = initial_state(system);
    VecX f;
    std::vector<double> c, s;
    for (const int threads : {1, 2}) {
        Workspace ws = make_workspace(system, threads);
        ws.contacts.start_speed.setConstant(0.3);
        set_motion(system, state.q, state.u, ws);
        evaluate_forces(system, 0, ws);
        linearise(system, 0, state.lambda.data(), ws);
        if (threads == 1) {
            f = ws.f;
            c = ws.lin.C;
            s = ws.lin.S;
            EXPECT_GT(f.norm(), 100);
        }
        EXPECT_EQ((ws.f - f).cwiseAbs().maxCoeff(), 0);
        EXPECT_EQ(ws.lin.C, c);
        EXPECT_EQ(ws.lin.S, s);
    }
    State reached;
    for (const int threads : {1, 2}) {
        const HardRun run =
            simulate(thousand_bearings(), {"radau", 1e-4, 0.002, 0, Onset::threshold, threads, 200});
        EXPECT_LT(run.statistics.steps, 50);
        EXPECT_LT(run.balance, 0.02); // of some 2 J stored and moving
        if (threads == 1)
            reached = run.last.state;
        EXPECT_EQ((run.last.state.q - reached.q).cwiseAbs().maxCoeff(), 0);
        EXPECT_EQ((run.last.state.u - reached.u).cwiseAbs().maxCoeff(), 0);
    }
}

} // namespace
} // namespace gudgeon

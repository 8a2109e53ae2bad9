// The three models of a cylindrical bearing beside each other: strips (AP 25-42), two ends (AU 19) and one
// planar contact (AU 10-17).
#include "core/assembly.hpp"
#include "models/builders.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon {
namespace {

using namespace test;

constexpr double radius = 0.01, length = 0.04, clearance = 1e-4, stiffness = 5e7;

/// Force and moment (about the bearing's middle) on a journal along X, shifted down and tilted about Y.
Vec6 wrench(const std::string& model_name, double exponent, double shift, double tilt, int strips = 64) {
    Model model;
    model.gravity = Vec3::Zero();
    Body body = make_body("journal", 1, {1, 1, 1}, {0, 0, -shift});
    body.orientation = {std::cos(tilt / 2), 0, std::sin(tilt / 2), 0};
    model.bodies.push_back(body);
    Joint joint = make_joint("J", JointKind::cylindrical, "ground", "journal", Vec3::Zero());
    joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
    joint.body_frame = true;
    joint.points = {Vec3::Zero(), Vec3::Zero()};
    joint.fidelity = Fidelity::clearance;
    joint.clearance = Clearance{};
    joint.clearance->model = model_name;
    joint.clearance->radial = clearance;
    if (model_name != "planar")
        joint.clearance->length = length;
    joint.clearance->radius = radius;
    joint.clearance->strips = strips;
    joint.clearance->law.kind = "hertz";
    joint.clearance->law.stiffness = stiffness;
    joint.clearance->law.exponent = exponent;
    model.joints.push_back(joint);
    const System system = compiled(model);
    Workspace ws = make_workspace(system);
    const State state = initial_state(system);
    set_motion(system, state.q, state.u, ws);
    evaluate_forces(system, 0, ws);
    Vec6 out = ws.f;
    out.tail<3>() = ws.motion[0].A * out.tail<3>() + ws.motion[0].r.cross(Vec3(out.head<3>()));
    return out;
}

TEST(BearingModels, ParallelAxesGiveOneForce) {
    const double depth = 3e-5, force = stiffness * std::pow(depth, 1.5);
    for (const char* model : {"strips", "two-end", "planar"}) {
        const Vec6 w = wrench(model, 1.5, clearance + depth, 0);
        EXPECT_NEAR(w[2], force, 1e-9 * force) << model;
        EXPECT_LT(w.tail<3>().norm(), 1e-9 * force * length) << model;
        EXPECT_EQ(wrench(model, 1.5, clearance, 0).norm(), 0) << model;
        EXPECT_EQ(wrench(model, 1.5, 0, 0).norm(), 0) << model;
    }
}

// With a linear law and contact along the whole length, strips are a bed of springs, K l^2 / 12 (1 - 1/N^2)
// against a tilt, and their normals, which tilt with the journal, act at the radius; the two ends are three
// times as stiff, K l^2 / 4; the planar model does not feel it.
TEST(BearingModels, TiltStiffnessOfABed) {
    const double depth = 1e-4, tilt = 1e-3; // the ends lie 2e-5 m off
    const double line = stiffness * tilt * length * length;
    const double bed = line / 12 * (1 - 1.0 / (64 * 64)) + stiffness * depth * radius * tilt;
    EXPECT_NEAR(wrench("strips", 1, clearance + depth, tilt)[4], -bed, 1e-4 * bed);
    EXPECT_NEAR(wrench("two-end", 1, clearance + depth, tilt)[4], -line / 4, 2e-3 * line / 4);
    EXPECT_NEAR(wrench("planar", 1, clearance + depth, tilt)[4], 0, 1e-3 * line);
    EXPECT_NEAR(wrench("strips", 1, clearance + depth, tilt)[2], stiffness * depth, 1e-3 * stiffness * depth);
}

// AU's four cases: no contact, a line, one point, two points (a tilted, centred journal).
TEST(BearingModels, CasesOfTheTwoEnds) {
    const double tilt = 2 * clearance / length; // the ends touch when centred
    EXPECT_EQ(wrench("two-end", 1.5, 0, 0.99 * tilt).norm(), 0);
    const Vec6 two = wrench("two-end", 1.5, 0, 1.2 * tilt);
    EXPECT_NEAR(two.head<3>().norm(), 0, 1e-9 * stiffness * std::pow(clearance, 1.5));
    EXPECT_LT(two[4], 0);
    const Vec6 one = wrench("two-end", 1.5, 0.3 * clearance, 0.99 * tilt);
    EXPECT_GT(one[2], 0);
    const Vec6 strips = wrench("strips", 1.5, 0, 1.2 * tilt);
    EXPECT_LT(strips[4], 0);
    EXPECT_GT(strips[4], two[4]); // only the outer strips press
}

TEST(BearingModels, StripsConverge) {
    const double shift = 1.1 * clearance, tilt = 5e-3;
    const Vec6 fine = wrench("strips", 1.5, shift, tilt, 4096);
    double last = 1e300;
    for (const int n : {8, 32, 128, 512}) {
        const double error = (wrench("strips", 1.5, shift, tilt, n) - fine).norm();
        EXPECT_LT(error, 0.5 * last) << n;
        last = error;
    }
    EXPECT_LT(last, 1e-4 * fine.norm());
}

} // namespace
} // namespace gudgeon

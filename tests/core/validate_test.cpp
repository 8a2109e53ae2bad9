// Models built in C++: what the file cannot even say (numbers that are not finite, missing parts) is
// refused by validate() at the same places.
#include "core/joint_kinds.hpp"
#include "core/model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>

namespace gudgeon {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinity = std::numeric_limits<double>::infinity();

Body make_body(const std::string& name) {
    Body body;
    body.name = name;
    body.mass = 1;
    body.inertia = Vec3(1, 1, 1).asDiagonal();
    return body;
}

Model good() {
    Model m;
    m.bodies = {make_body("a"), make_body("b")};
    Joint joint;
    joint.name = "J";
    joint.kind = JointKind::revolute;
    joint.bodies = {"ground", "a"};
    joint.axes = {Vec3(0, 1, 0), Vec3(0, 1, 0)};
    m.joints = {joint};
    SpringDamper spring;
    spring.name = "S";
    spring.bodies = {"a", "b"};
    spring.points = {Vec3(0, 0, 0), Vec3(0, 0, 1)};
    TorsionSpring torsion;
    torsion.name = "T";
    torsion.joint = "J";
    Tyre tyre;
    tyre.name = "W";
    tyre.body = "b";
    AppliedForce force;
    force.name = "F";
    force.body = "a";
    m.forces = {spring, torsion, tyre, force};
    m.markers = {{"P", "ground", false, Vec3::Zero()}};
    return m;
}

/// Where the changed model is refused; "" if it is not.
std::string refused(const std::function<void(Model&)>& change) {
    Model m = good();
    change(m);
    try {
        validate(m);
    } catch (const ModelError& error) {
        EXPECT_EQ(std::string(error.what()).rfind("model: ", 0), 0u) << error.what();
        return error.pointer();
    }
    return "";
}

template <class T> T& force(Model& m, std::size_t i) { return std::get<T>(m.forces[i]); }

TEST(Validate, GoodModelPasses) {
    EXPECT_EQ(refused([](Model&) {}), "");
}

TEST(Validate, EmptyModel) {
    EXPECT_EQ(refused([](Model& m) { m = Model{}; }), "/bodies");
    EXPECT_EQ(refused([](Model& m) { m.name = ""; }), "/name");
}

TEST(Validate, NumbersThatAreNotFinite) {
    for (const double bad : {nan, infinity, -infinity}) {
        EXPECT_EQ(refused([&](Model& m) { m.gravity[2] = bad; }), "/gravity/2");
        EXPECT_EQ(refused([&](Model& m) { m.parameters["c"] = bad; }), "/parameters/c");
        EXPECT_EQ(refused([&](Model& m) { m.bodies[1].mass = bad; }), "/bodies/1/mass");
        EXPECT_EQ(refused([&](Model& m) { m.bodies[1].inertia(0, 1) = bad; }), "/bodies/1/inertia");
        EXPECT_EQ(refused([&](Model& m) { m.bodies[0].position[1] = bad; }), "/bodies/0/position/1");
        EXPECT_EQ(refused([&](Model& m) { m.bodies[0].orientation[3] = bad; }), "/bodies/0/orientation/3");
        EXPECT_EQ(refused([&](Model& m) { m.bodies[0].velocity[0] = bad; }), "/bodies/0/velocity/0");
        EXPECT_EQ(refused([&](Model& m) { m.bodies[0].angular_velocity[0] = bad; }),
                  "/bodies/0/angular_velocity/0");
        EXPECT_EQ(refused([&](Model& m) { m.joints[0].points[1][2] = bad; }), "/joints/0/points/1/2");
        EXPECT_EQ(refused([&](Model& m) { (*m.joints[0].axes)[1][0] = bad; }), "/joints/0/axes/1/0");
        EXPECT_EQ(refused([&](Model& m) { force<SpringDamper>(m, 0).damping = bad; }), "/forces/0/damping");
        EXPECT_EQ(refused([&](Model& m) { force<SpringDamper>(m, 0).preload = bad; }), "/forces/0/preload");
        EXPECT_EQ(refused([&](Model& m) { force<TorsionSpring>(m, 1).free_angle = bad; }),
                  "/forces/1/free_angle");
        EXPECT_EQ(refused([&](Model& m) { force<Tyre>(m, 2).reference = bad; }), "/forces/2/reference");
        EXPECT_EQ(refused([&](Model& m) { force<AppliedForce>(m, 3).vector[1] = bad; }),
                  "/forces/3/vector/1");
        EXPECT_EQ(refused([&](Model& m) { m.markers[0].point[0] = bad; }), "/markers/0/point/0");
        EXPECT_EQ(refused([&](Model& m) { m.end = bad; }), "/end");
        EXPECT_EQ(refused([&](Model& m) { m.every = bad; }), "/every");
    }
}

TEST(Validate, FunctionsOfTime) {
    const auto place = [](const TimeFunction& f) {
        return refused([&](Model& m) { m.joints[0].drives.emplace("angle", f); });
    };
    const std::string at = "/joints/0/drives/angle";
    EXPECT_EQ(place(ConstantFunction{nan}), at + "/value");
    EXPECT_EQ(place(HarmonicFunction{nan, 1, 0, 0}), at + "/amplitude");
    EXPECT_EQ(place(HarmonicFunction{1, -1, 0, 0}), at + "/frequency");
    EXPECT_EQ(place(HarmonicFunction{1, 1, infinity, 0}), at + "/phase");
    EXPECT_EQ(place(SmoothStepFunction{1, 1, 0, 1}), at + "/end");
    EXPECT_EQ(place(RampFunction{0, nan, 0}), at + "/rate");
    EXPECT_EQ(place(TableFunction(Table{{0, 1, 1}, {0, 0, 0}})), at + "/x/2");
    EXPECT_EQ(place(TableFunction(Table{{0, 1}, {0, nan}})), at + "/y/1");
    EXPECT_EQ(place(TableFunction(Table{})), at + "/x");
    EXPECT_EQ(place(RampFunction{}), "");
}

TEST(Validate, PartsThatAreMissing) {
    EXPECT_EQ(refused([](Model& m) { m.joints[0].axes.reset(); }), "/joints/0/axis");
    EXPECT_EQ(refused([](Model& m) { m.joints[0].fidelity = Fidelity::bushing; }), "/joints/0/bushing");
    EXPECT_EQ(refused([](Model& m) {
                  m.joints[0].references = {Vec3(0, 1, 0), Vec3(1, 0, 0)};
              }),
              "/joints/0/references/0");
    EXPECT_EQ(refused([](Model& m) {
                  m.joints[0].kind = JointKind::spherical;
                  m.joints[0].axes.reset();
                  m.joints[0].references = {Vec3(1, 0, 0), Vec3(1, 0, 0)};
                  m.forces.clear();
              }),
              "/joints/0/reference");
}

TEST(Validate, InertiaUpToRoundOff) {
    const auto place = [](const Mat3& inertia) {
        return refused([&](Model& m) { m.bodies[0].inertia = inertia; });
    };
    const auto principal = [](double a, double b, double c) { return Mat3(Vec3(a, b, c).asDiagonal()); };
    EXPECT_EQ(place(principal(1, 1, 2 * (1 + 1e-10))), ""); // lamina
    EXPECT_EQ(place(principal(1, 1, 2 * (1 + 1e-8))), "/bodies/0/inertia");
    EXPECT_EQ(place(principal(5e-5, 1.0 / 12, 1.0 / 12)), ""); // bar
    EXPECT_EQ(place(principal(0, 1, 1)), "/bodies/0/inertia");
    EXPECT_EQ(place(principal(1e-30, 1e-30, 2e-30)), "");
    // The same lamina turned by an awkward angle: a full matrix with the same principal moments.
    const Mat3 a = rotation(Vec4(0.5, 0.1, -0.7, 0.3).normalized());
    EXPECT_EQ(place(a * principal(1, 1, 2) * a.transpose()), "");
    EXPECT_EQ(place(a * principal(1, 1, 2.001) * a.transpose()), "/bodies/0/inertia");
    EXPECT_EQ(place(a * principal(1, 1, 0) * a.transpose()), "/bodies/0/inertia");
    EXPECT_EQ(place(a * principal(1, 1, -0.1) * a.transpose()), "/bodies/0/inertia");
}

TEST(Validate, DirectionsAreComparedInOneFrame) {
    // Parallel components in two body frames that are turned against each other are not parallel.
    const auto universal = [](const Vec3& a, const Vec3& b) {
        return refused([&](Model& m) {
            m.bodies[1].orientation = {std::sqrt(0.5), std::sqrt(0.5), 0, 0}; // y of b along global z
            m.joints[0].kind = JointKind::universal;
            m.joints[0].bodies = {"a", "b"};
            m.joints[0].body_frame = true;
            m.joints[0].axes = {a, b};
            m.forces.clear();
        });
    };
    EXPECT_EQ(universal(Vec3(0, 1, 0), Vec3(0, 1, 0)), "");
    EXPECT_EQ(universal(Vec3(0, 0, 1), Vec3(0, 1, 0)), "/joints/0/axes");
}

TEST(Validate, DistanceInBodyFrames) {
    const auto distance = [](const Vec3& a, const Vec3& b) {
        return refused([&](Model& m) {
            m.bodies[1].position = {0, 0, 2};
            m.joints[0].kind = JointKind::distance;
            m.joints[0].bodies = {"a", "b"};
            m.joints[0].body_frame = true;
            m.joints[0].points = {a, b};
            m.forces.clear();
        });
    };
    EXPECT_EQ(distance(Vec3(0, 0, 0), Vec3(0, 0, 0)), "");
    EXPECT_EQ(distance(Vec3(0, 0, 1), Vec3(0, 0, -1)), "/joints/0/points");
}

TEST(Validate, FixedBodyNeedsNoMass) {
    EXPECT_EQ(refused([](Model& m) {
                  Body fixed;
                  fixed.name = "base";
                  fixed.fixed = true;
                  m.bodies.push_back(fixed);
              }),
              "");
}

TEST(Validate, MessageBearsTheSource) {
    Model m = good();
    m.source = "crank.json";
    m.bodies[0].mass = 0;
    try {
        validate(m);
        FAIL();
    } catch (const ModelError& error) {
        EXPECT_STREQ(error.what(), "crank.json: /bodies/0/mass: 0 is not positive; allowed: more than 0");
        EXPECT_EQ(error.problem(), "0 is not positive");
        EXPECT_EQ(error.allowed(), "more than 0");
    }
}

TEST(JointKinds, NamesAndCoordinates) {
    using Names = std::vector<std::string>;
    const Names six{"dx", "dy", "dz", "ax", "ay", "az"};
    const std::map<std::string, Names> expected{{"rigid", {}},
                                                {"revolute", {"angle"}},
                                                {"translation", {"slide"}},
                                                {"spherical", six},
                                                {"distance", {}},
                                                {"cylindrical", {"slide", "angle"}},
                                                {"point-on-axis", {"slide"}},
                                                {"planar", {"u", "v", "angle"}},
                                                {"universal", {"angle1", "angle2"}}};
    const auto with = [](JointKind kind, Fidelity fidelity) {
        Joint joint;
        joint.kind = kind;
        joint.fidelity = fidelity;
        return joint;
    };
    ASSERT_EQ(joint_kinds().size(), expected.size());
    for (const auto& [name, coordinates] : expected) {
        const JointKindInfo* info = find_joint_kind(name);
        ASSERT_TRUE(info) << name;
        EXPECT_EQ(joint_coordinates(with(info->kind, Fidelity::perfect)), coordinates) << name;
        EXPECT_EQ(joint_coordinates(with(info->kind, Fidelity::bushing)), six) << name;
        EXPECT_TRUE(driveable_coordinates(info->kind, Fidelity::bushing).empty());
    }
    EXPECT_FALSE(find_joint_kind("hinge"));
    EXPECT_EQ(rotation_coordinates(JointKind::planar, Fidelity::perfect), Names{"angle"});
    EXPECT_TRUE(rotation_coordinates(JointKind::spherical, Fidelity::perfect).empty());
}

} // namespace
} // namespace gudgeon

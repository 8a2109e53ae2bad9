// Columns against hand values: the sample is made up, no solver takes part.
#include "core/channels.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace gudgeon {
namespace {

Vec4 about(const Vec3& axis, double angle) {
    const Vec3 v = std::sin(angle / 2) * axis;
    return {std::cos(angle / 2), v[0], v[1], v[2]};
}

Body body(const std::string& name, const Vec3& position) {
    Body b;
    b.name = name;
    b.mass = 1;
    b.inertia = Mat3::Identity();
    b.position = position;
    return b;
}

Joint joint(const std::string& name, JointKind kind, const std::string& a, const std::string& b,
            const Vec3& point, const Vec3& axis) {
    Joint j;
    j.name = name;
    j.kind = kind;
    j.bodies = {a, b};
    j.points = {point, point};
    j.axes = {axis, axis};
    return j;
}

void place(Sample& s, int i, const Vec3& r, const Vec4& p, const Vec3& v = Vec3::Zero(),
           const Vec3& w = Vec3::Zero()) {
    s.motion[i] = {rotation(p), p, r, v, w};
}

/// A sample of the pose as given, everything at rest.
Sample sample_of(const System& system) {
    Sample s;
    s.motion = system.start;
    s.acceleration = VecX::Zero(system.velocities());
    s.joint.resize(system.joints.size());
    const auto angles = static_cast<Eigen::Index>(system.angles.size());
    s.state.angles = {VecX::Zero(angles), VecX::Zero(angles), 0};
    return s;
}

double value(const System& system, const Sample& s, const std::string& name) {
    const Channels channels(system, {name});
    EXPECT_EQ(channels.names(), std::vector<std::string>{name});
    double out = 0;
    channels.read(s, {&out, 1});
    return out;
}

void expect_values(const System& system, const Sample& s,
                   const std::vector<std::pair<std::string, double>>& expected) {
    for (const auto& [name, number] : expected)
        EXPECT_NEAR(value(system, s, name), number, 1e-14) << name;
}

/// One body on one joint to the ground.
System single(const Joint& j) {
    Model model;
    model.bodies = {body("bar", {1, 0, 0})};
    model.joints = {j};
    return compile(model, {});
}

TEST(Channels, BodyMotion) {
    const System system = single(joint("J", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, 0, 1}));
    Sample s = sample_of(system);
    place(s, 0, {1, 2, 3}, {0.5, -0.5, 0.5, -0.5}, {4, 5, 6}, {7, 8, 9});
    s.acceleration << 10, 11, 12, 13, 14, 15;
    expect_values(system, s,
                  {{"bar.x", 1},
                   {"bar.y", 2},
                   {"bar.z", 3},
                   {"bar.e0", 0.5},
                   {"bar.e1", -0.5},
                   {"bar.e2", 0.5},
                   {"bar.e3", -0.5},
                   {"bar.vx", 4},
                   {"bar.vy", 5},
                   {"bar.vz", 6},
                   {"bar.wx", 7},
                   {"bar.wy", 8},
                   {"bar.wz", 9},
                   {"bar.ax", 10},
                   {"bar.ay", 11},
                   {"bar.az", 12},
                   {"bar.alx", 13},
                   {"bar.aly", 14},
                   {"bar.alz", 15}});
}

TEST(Channels, WrenchGlobalAndInTheJointFrame) {
    Model model;
    model.bodies = {body("base", {0, 0, 0}), body("bar", {1, 0, 0})};
    // Axis X: the joint frame is h = Y, t = Z, b = X of a.
    model.joints = {joint("J", JointKind::revolute, "base", "bar", {0, 0, 0}, {1, 0, 0})};
    const System system = compile(model, {});
    Sample s = sample_of(system);
    s.joint[0] = {{1, 2, 3}, {4, 5, 6}};
    expect_values(system, s, {{"J.fx", 1}, {"J.fy", 2}, {"J.fz", 3}, {"J.mx", 4}, {"J.my", 5}, {"J.mz", 6}});
    expect_values(system, s,
                  {{"J.fjx", 2}, {"J.fjy", 3}, {"J.fjz", 1}, {"J.mjx", 5}, {"J.mjy", 6}, {"J.mjz", 4}});
    // The frame turns with a: by +90 degrees about Z its h = Y becomes -X, its b = X becomes Y.
    place(s, 0, {0, 0, 0}, about(Vec3::UnitZ(), pi / 2));
    expect_values(system, s,
                  {{"J.fx", 1}, {"J.mz", 6}, {"J.fjx", -1}, {"J.fjy", 3}, {"J.fjz", 2}, {"J.mjz", 5}});
    // What b does is of no concern.
    place(s, 1, {3, 1, 0}, about(Vec3::UnitY(), 1));
    expect_values(system, s, {{"J.fx", 1}, {"J.fjx", -1}, {"J.fjz", 2}});
}

TEST(Channels, AngleCountsTurnsFromTheMemory) {
    const System system = single(joint("J", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, 0, 1}));
    Sample s = sample_of(system);
    place(s, 0, {0, 1, 0}, about(Vec3::UnitZ(), pi / 2));
    EXPECT_NEAR(value(system, s, "J.angle"), pi / 2, 1e-14);
    s.state.angles.value << 2 * pi + 1.4;
    EXPECT_NEAR(value(system, s, "J.angle"), 2.5 * pi, 1e-14);
    s.state.angles.value << -4;
    EXPECT_NEAR(value(system, s, "J.angle"), -1.5 * pi, 1e-14);
    // The last accepted step was at t = 2 s; the sample, 0.5 s later, is a turn further.
    s.state.angles = {VecX::Constant(1, 1.5), VecX::Constant(1, 4 * pi), 2};
    s.state.t = 2.5;
    EXPECT_NEAR(value(system, s, "J.angle"), 2.5 * pi, 1e-14);
}

TEST(Channels, CylindricalSlideAndAngle) {
    const System system = single(joint("J", JointKind::cylindrical, "ground", "bar", {0, 0, 0}, {0, 1, 0}));
    Sample s = sample_of(system);
    place(s, 0, {std::cos(0.3), 0.25, -std::sin(0.3)}, about(Vec3::UnitY(), 0.3));
    expect_values(system, s, {{"J.slide", 0.25}, {"J.angle", 0.3}});
}

TEST(Channels, PlanarCoordinates) {
    // Axis Y: h = Z, t = X.
    const System system = single(joint("J", JointKind::planar, "ground", "bar", {1, 0, 0}, {0, 1, 0}));
    Sample s = sample_of(system);
    place(s, 0, {1.1, 0, 0.2}, about(Vec3::UnitY(), -0.7));
    expect_values(system, s, {{"J.u", 0.2}, {"J.v", 0.1}, {"J.angle", -0.7}});
}

TEST(Channels, UniversalAngles) {
    Joint j = joint("J", JointKind::universal, "ground", "bar", {1, 0, 0}, {0, 0, 1});
    j.axes = {Vec3::UnitZ(), Vec3::UnitX()};
    const System system = single(j);
    Sample s = sample_of(system);
    const Mat3 turn = rotation(about(Vec3::UnitZ(), 0.3)) * rotation(about(Vec3::UnitX(), 0.2));
    const Eigen::Quaterniond q(turn);
    place(s, 0, {1, 0, 0}, {q.w(), q.x(), q.y(), q.z()});
    expect_values(system, s, {{"J.angle1", 0.3}, {"J.angle2", 0.2}});
}

TEST(Channels, SphericalDisplacementAndRotationVector) {
    Model model;
    model.bodies = {body("base", {0, 0, 0}), body("bar", {1, 0, 0})};
    model.joints = {joint("S", JointKind::spherical, "base", "bar", {0, 0, 0}, {0, 0, 1})};
    model.joints[0].axes.reset(); // frame parallel to the global axes
    const System system = compile(model, {});
    Sample s = sample_of(system);
    place(s, 1, {1 + 0.1, 0.2, 0.3}, {1, 0, 0, 0});
    expect_values(system, s,
                  {{"S.dx", 0.1}, {"S.dy", 0.2}, {"S.dz", 0.3}, {"S.ax", 0}, {"S.ay", 0}, {"S.az", 0}});
    // a turned by +90 degrees about Z: its x is Y, its y is -X; b did not turn, so -90 degrees from a.
    place(s, 0, {0, 0, 0}, about(Vec3::UnitZ(), pi / 2));
    expect_values(system, s, {{"S.dx", 0.2}, {"S.dy", -0.1}, {"S.dz", 0.3}, {"S.az", -pi / 2}, {"S.ax", 0}});
    // b turned by 0.4 about global X, seen from the turned a: about its -y. Its point is at the origin.
    const Eigen::Quaterniond q(rotation(about(Vec3::UnitX(), 0.4)) * rotation(about(Vec3::UnitZ(), pi / 2)));
    place(s, 1, {0, std::cos(0.4), std::sin(0.4)}, {q.w(), q.x(), q.y(), q.z()});
    expect_values(system, s, {{"S.ax", 0}, {"S.ay", -0.4}, {"S.az", 0}, {"S.dx", 0}, {"S.dy", 0}});
}

TEST(Channels, BushingHasTheSixCoordinates) {
    Joint j = joint("R", JointKind::revolute, "ground", "bar", {1, 0, 0}, {1, 0, 0});
    j.fidelity = Fidelity::bushing;
    j.bushing = Bushing{{1, 1, 1, 1, 1, 1}, {}, {}, {}, false};
    const System system = single(j);
    Sample s = sample_of(system);
    // Joint frame h = Y, t = Z, b = X.
    place(s, 0, {1.1, 0.2, 0.3}, about(Vec3::UnitX(), 0.5));
    expect_values(system, s,
                  {{"R.dx", 0.2}, {"R.dy", 0.3}, {"R.dz", 0.1}, {"R.ax", 0}, {"R.ay", 0}, {"R.az", 0.5}});
}

TEST(Channels, Markers) {
    Model model;
    model.bodies = {body("bar", {1, 0, 0}), body("wall", {0, 5, 0})};
    model.bodies[1].fixed = true;
    model.markers = {{"tip", "bar", false, {2, 0, 0}}, {"nail", "wall", true, {0, 0, 1}}};
    const System system = compile(model, {});
    Sample s = sample_of(system);
    // Turned by 90 degrees about Z and turning about it at 3 rad/s: the tip lies at +Y and moves to -X.
    place(s, 0, {1, 2, 3}, about(Vec3::UnitZ(), pi / 2), {10, 20, 30}, {0, 0, 3});
    expect_values(system, s,
                  {{"tip.x", 1}, {"tip.y", 3}, {"tip.z", 3}, {"tip.vx", 7}, {"tip.vy", 20}, {"tip.vz", 30}});
    expect_values(system, s, {{"nail.x", 0}, {"nail.y", 5}, {"nail.z", 1}, {"nail.vx", 0}});
}

TEST(Channels, Energies) {
    const System system = single(joint("J", JointKind::revolute, "ground", "bar", {0, 0, 0}, {0, 0, 1}));
    Sample s = sample_of(system);
    s.energies.kinetic = 1;
    s.energies.potential = 2;
    s.energies.elastic = 3;
    s.state.work = Eigen::Vector2d(4, 5);
    s.balance = 6;
    expect_values(system, s,
                  {{"energy.kinetic", 1},
                   {"energy.potential", 2},
                   {"energy.elastic", 3},
                   {"energy.dissipated", 4},
                   {"energy.input", 5},
                   {"energy.balance", 6}});
}

System pair() {
    Model model;
    model.bodies = {body("frame", {0, 0, 0}), body("bar", {1, 0, 0}), body("rod", {2, 0, 0})};
    model.bodies[0].fixed = true;
    model.joints = {joint("J1", JointKind::revolute, "frame", "bar", {0, 0, 0}, {0, 1, 0}),
                    joint("J2", JointKind::spherical, "bar", "rod", {1.5, 0, 0}, {0, 1, 0})};
    model.markers = {{"tip", "rod", false, {3, 0, 0}}};
    return compile(model, {});
}

TEST(Channels, AllOfThemInOrderWithUnits) {
    const System system = pair();
    const Channels channels(system);
    // 2 moving bodies, a revolute, a spherical, a marker, energies; none of the fixed body.
    EXPECT_EQ(channels.names().size(), 2u * 19 + (1 + 12) + (6 + 12) + 6 + 6);
    EXPECT_EQ(Channels::count_all(system), channels.names().size());
    EXPECT_EQ(channels.units().size(), channels.names().size());
    EXPECT_EQ(channels.names().front(), "bar.x");
    EXPECT_EQ(channels.names().back(), "energy.balance");
    EXPECT_EQ(std::set<std::string>(channels.names().begin(), channels.names().end()).size(),
              channels.names().size());
    const std::vector<std::pair<std::string, std::string>> units{
        {"bar.x", "m"},     {"bar.e2", "1"},       {"bar.vz", "m/s"},    {"bar.wx", "rad/s"},
        {"bar.ay", "m/s2"}, {"bar.aly", "rad/s2"}, {"J1.angle", "rad"},  {"J2.dx", "m"},
        {"J2.az", "rad"},   {"J1.fjy", "N"},       {"J1.mx", "N m"},     {"J2.mjz", "N m"},
        {"tip.vy", "m/s"},  {"tip.x", "m"},        {"energy.input", "J"}};
    for (const auto& [name, unit] : units)
        EXPECT_EQ(Channels(system, {name}).units(), std::vector<std::string>{unit}) << name;
}

TEST(Channels, Globs) {
    const System system = pair();
    using Names = std::vector<std::string>;
    EXPECT_EQ(Channels(system, {"J2.f?"}).names(), (Names{"J2.fx", "J2.fy", "J2.fz"}));
    EXPECT_EQ(
        Channels(system, {"*.v?", "bar.vx"}).names(),
        (Names{"bar.vx", "bar.vy", "bar.vz", "rod.vx", "rod.vy", "rod.vz", "tip.vx", "tip.vy", "tip.vz"}));
    // In the order of the full list, whatever the order of the globs.
    EXPECT_EQ(Channels(system, {"energy.k*", "J?.angle", "bar.x"}).names(),
              (Names{"bar.x", "J1.angle", "energy.kinetic"}));
    EXPECT_EQ(Channels(system, {"*a*.alx"}).names(), (Names{"bar.alx"}));
    EXPECT_EQ(Channels(system, {"**"}).names().size(), Channels::count_all(system));
}

void expect_refused(const System& system, const std::string& glob, const std::string& says) {
    try {
        const Channels channels(system, {"energy.*", glob});
        ADD_FAILURE() << glob << " accepted";
    } catch (const std::invalid_argument& error) {
        const std::string message = error.what();
        EXPECT_NE(message.find("'" + glob + "'"), std::string::npos) << message;
        EXPECT_NE(message.find(says), std::string::npos) << message;
    }
}

TEST(Channels, GlobThatMatchesNothingIsNamed) {
    const System system = pair();
    expect_refused(system, "J1.angl", "did you mean 'J1.angle'?");
    expect_refused(system, "baar.x", "did you mean 'bar'?");
    expect_refused(system, "spring.*", "bar, rod, J1, J2, tip");
    expect_refused(system, "BAR.x", "columns begin with");
    expect_refused(system, "frame.x", "does not move");
    expect_refused(system, "ground.x", "does not move");
    expect_refused(system, "bar.x?", "columns of 'bar': bar.x");
    expect_refused(system, "x", "columns begin with");
}

TEST(Channels, ReadNeedsOneValuePerColumn) {
    const System system = pair();
    const Channels channels(system, {"bar.x", "bar.y"});
    double one = 0;
    EXPECT_THROW(channels.read(sample_of(system), {&one, 1}), std::invalid_argument);
}

} // namespace
} // namespace gudgeon

// Front left corner of a real vehicle (public data of Project Chrono, BSD-3:
// hmmwv/suspension/HMMWV_DoubleWishboneFront_bushings.json, restated).
#include "models/builders.hpp"

#include <Eigen/QR>

#include <algorithm>

namespace gudgeon {

namespace {

constexpr double tyre_load = 5000; // N, in the position given

Joint arm_hinge(const std::string& name, const std::string& arm, const Vec3& front, const Vec3& back,
                bool perfect) {
    Joint hinge = make_joint(name, JointKind::revolute, "chassis", arm, (front + back) / 2,
                             (front - back).normalized());
    if (perfect)
        return hinge;
    hinge.fidelity = Fidelity::bushing;
    hinge.bushing = Bushing{};
    hinge.bushing->stiffness = {7e7, 7e7, 7e7, 1e5, 1e5, 0}; // free about the hinge axis
    hinge.bushing->damping = {3.5e4, 3.5e4, 3.5e4, 500, 500, 0};
    return hinge;
}

void add_bodies(Model& model) {
    Body chassis = make_body("chassis", 0, Vec3::Zero(), Vec3::Zero());
    chassis.fixed = true;
    const Vec3 rim(0.4634, 0.6243, 0.4634); // 18.8 kg on the spindle, same centre
    model.bodies = {
        chassis,
        make_body("spindle", 14.705 + 18.8, Vec3(0.04117, 0.07352, 0.04117) + rim, {-0.040, 0.910, -0.026}),
        make_body("upright", 19.450, {0.1656, 0.1934, 0.04367}, {-0.040, 0.751, -0.026}),
        make_body("upper_arm", 5.813, {0.03, 0.03, 0.06}, {-0.106, 0.589, 0.218}),
        make_body("lower_arm", 23.965, {0.4, 0.4, 0.8}, {0.000, 0.547, -0.059}),
    };
}

/// Rod with z along it, universal on the chassis (both axes normal to the rod), ball on the upright.
void add_tie_rod(Model& model) {
    const Vec3 inner(-0.250, 0.448, 0.054), outer(-0.176, 0.821, -0.016);
    Mat3 axes;
    axes.col(2) = (outer - inner).normalized();
    axes.col(0) = axes.col(2).cross(Vec3::UnitZ()).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    Body rod = make_body("tie_rod", 6, {0.5, 0.5, 0.05}, (inner + outer) / 2);
    rod.orientation = euler_parameters(axes);
    model.bodies.push_back(rod);
    Joint universal = make_joint("tie_universal", JointKind::universal, "chassis", "tie_rod", inner);
    universal.axes = {axes.col(0), axes.col(1)};
    model.joints.push_back(universal);
    model.joints.push_back(make_joint("tie_ball", JointKind::spherical, "tie_rod", "upright", outer));
}

void add_joints(Model& model, bool perfect) {
    model.joints = {
        arm_hinge("upper_hinge", "upper_arm", {-0.048, 0.446, 0.245}, {-0.268, 0.478, 0.196}, perfect),
        arm_hinge("lower_hinge", "lower_arm", {0.223, 0.307, 0.000}, {-0.223, 0.307, 0.000}, perfect),
        make_joint("upper_ball", JointKind::spherical, "upper_arm", "upright", {-0.053, 0.716, 0.215}),
        make_joint("lower_ball", JointKind::spherical, "lower_arm", "upright", {-0.036, 0.787, -0.118}),
        make_joint("wheel_bearing", JointKind::revolute, "upright", "spindle", {-0.040, 0.910, -0.026},
                   Vec3::UnitY()),
    };
    add_tie_rod(model);
}

Tyre wheel_tyre(const Body& spindle) {
    Tyre tyre;
    tyre.name = "tyre";
    tyre.body = spindle.name;
    tyre.point = spindle.position;
    tyre.stiffness = 3e5;
    tyre.damping = 500;
    tyre.preload = tyre_load;
    tyre.reference = spindle.position.z();
    tyre.road = HarmonicFunction{0.02, 2, 0, 0};
    return tyre;
}

/// Forces and moments on the bodies that do not move with the ground, six rows each: force, then
/// moment about the mass centre, in global axes.
class Balance {
  public:
    explicit Balance(const Model& model) : model_(model) {}

    void add(Eigen::Ref<VecX> rows, const std::string& name, const Vec3& point, const Vec3& force,
             const Vec3& moment = Vec3::Zero()) const {
        Eigen::Index row = 0;
        for (const Body& body : model_.bodies) {
            if (body.fixed)
                continue;
            if (body.name == name) {
                rows.segment<3>(row) += force;
                rows.segment<3>(row + 3) += moment + (point - body.position).cross(force);
            }
            row += 6;
        }
    }

    Eigen::Index rows() const {
        return 6 * std::count_if(model_.bodies.begin(), model_.bodies.end(),
                                 [](const Body& body) { return !body.fixed; });
    }

  private:
    const Model& model_;
};

/// Directions of the moments a perfect joint can carry.
std::vector<Vec3> carried_moments(const Joint& joint) {
    if (joint.kind == JointKind::spherical)
        return {};
    const Vec3 axis = (*joint.axes)[0];
    if (joint.kind == JointKind::universal)
        return {axis.cross((*joint.axes)[1])};
    const Vec3 normal = axis.unitOrthogonal();
    return {normal, axis.cross(normal)};
}

/// Tension of the spring with which the corner is in static balance in the position given, all
/// joints perfect: equilibrium of every body, solved for the joint reactions and the tension.
double balancing_tension(const Model& model, const SpringDamper& spring, const Tyre& tyre) {
    const Balance balance(model);
    VecX loads = VecX::Zero(balance.rows());
    for (const Body& body : model.bodies)
        balance.add(loads, body.name, body.position, body.mass * model.gravity);
    balance.add(loads, tyre.body, tyre.point, tyre.preload * Vec3::UnitZ());

    std::vector<VecX> columns;
    const Vec3 line = (spring.points[1] - spring.points[0]).normalized();
    columns.emplace_back(VecX::Zero(balance.rows()));
    balance.add(columns.back(), spring.bodies[0], spring.points[0], line);
    balance.add(columns.back(), spring.bodies[1], spring.points[1], -line);
    for (const Joint& joint : model.joints) {
        const auto add_reaction = [&](const Vec3& force, const Vec3& moment) {
            columns.emplace_back(VecX::Zero(balance.rows()));
            balance.add(columns.back(), joint.bodies[0], joint.points[0], -force, -moment);
            balance.add(columns.back(), joint.bodies[1], joint.points[1], force, moment);
        };
        for (int i = 0; i < 3; ++i)
            add_reaction(Vec3::Unit(i), Vec3::Zero());
        for (const Vec3& moment : carried_moments(joint))
            add_reaction(Vec3::Zero(), moment);
    }
    MatX reactions(balance.rows(), static_cast<Eigen::Index>(columns.size()));
    for (std::size_t i = 0; i < columns.size(); ++i)
        reactions.col(static_cast<Eigen::Index>(i)) = columns[i];
    // One row more than unknowns: nothing turns the wheel about its bearing, so that row is 0 = 0.
    return reactions.colPivHouseholderQr().solve(-loads)[0];
}

Model build_hmmwv_corner(const ParameterValues& values) {
    Model model;
    add_bodies(model);
    add_joints(model, values.word("joints") == "perfect");

    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"chassis", "lower_arm"};
    spring.points = {Vec3(0.104, 0.510, 0.197), Vec3(0.097, 0.543, -0.047)};
    spring.stiffness = 1.2e5;
    SpringDamper damper;
    damper.name = "damper";
    damper.bodies = spring.bodies;
    damper.points = {Vec3(0.104, 0.498, 0.323), Vec3(0.097, 0.543, -0.047)};
    damper.damping = 19015.5692;
    const Tyre tyre = wheel_tyre(model.bodies[1]);
    spring.preload = balancing_tension(model, spring, tyre);
    model.forces = {spring, damper, tyre};
    return model;
}

} // namespace

Mechanism hmmwv_corner() {
    return {"hmmwv-corner",
            "double-wishbone corner of a real vehicle on a wavy road, chassis fixed",
            {choice_parameter("joints", {"bushing", "perfect"},
                              "joints of the arms on the chassis: bushings or revolutes")},
            5,
            0.01,
            &build_hmmwv_corner};
}

Table hmmwv_progressive_spring() {
    const std::vector<double> x{0.02, 0.04, 0.06, 0.08, 0.10, 0.12, 0.14, 0.16, 0.18, 0.20};
    const std::vector<double> force{3629.923,  8991.945,   17818.165,  31840.681,  52791.592,
                                    82402.997, 122406.996, 174535.686, 240521.166, 322095.536};
    Table table;
    for (std::size_t i = x.size(); i-- > 0;) {
        table.x.push_back(-x[i]);
        table.y.push_back(-force[i]);
    }
    table.x.push_back(0);
    table.y.push_back(0);
    table.x.insert(table.x.end(), x.begin(), x.end());
    table.y.insert(table.y.end(), force.begin(), force.end());
    return table;
}

} // namespace gudgeon

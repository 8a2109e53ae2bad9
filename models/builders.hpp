// Blocks the ready mechanisms are put together from; internal to models/.
#pragma once

#include "models/mechanisms.hpp"

namespace gudgeon {

/// At rest, axes parallel to the global frame. Principal inertias about the mass centre, kg m2.
Body make_body(const std::string& name, double mass, const Vec3& inertia, const Vec3& position);

/// Bar of 1 m, 1 kg with x along it; transverse: Iyy = Izz, kg m2.
Body make_bar(const std::string& name, double transverse, const Vec3& position);

/// One point (global, pose as given) for both sides; the joint frame is parallel to the global one.
Joint make_joint(const std::string& name, JointKind kind, const std::string& a, const std::string& b,
                 const Vec3& point);

/// The same with one axis for both sides.
Joint make_joint(const std::string& name, JointKind kind, const std::string& a, const std::string& b,
                 const Vec3& point, const Vec3& axis);

/// K d^(3/2) with Lankarani and Nikravesh's damping; stiffness of the whole joint, N/m^(3/2).
ContactLaw lankarani_nikravesh(double stiffness, double restitution);

/// The cylinder law (AP 44-48) between two bodies of steel, 207 GPa.
ContactLaw steel_cylinders(double restitution);

/// A bearing in strips, its journal longer than itself; journal radius = radius - radial, m.
Clearance strip_bearing(double radius, double length, double radial, int strips, const ContactLaw& law);

/// Marker on a body at a global point (pose as given).
Marker make_marker(const std::string& name, const std::string& body, const Vec3& point);

/// Euler parameters of the matrix whose columns are the body axes, e0 >= 0.
Vec4 euler_parameters(const Mat3& axes);

MechanismParameter number_parameter(const std::string& name, const std::string& default_value,
                                    const std::string& unit, const std::string& help, double minimum,
                                    double maximum);
MechanismParameter restitution_parameter(const std::string& default_value);
MechanismParameter count_parameter(const std::string& name, const std::string& default_value,
                                   const std::string& help, double maximum);
/// The first choice is the default.
MechanismParameter choice_parameter(const std::string& name, const std::vector<std::string>& choices,
                                    const std::string& help);

Mechanism pendulum();
Mechanism chain();
Mechanism four_bar();
Mechanism slider_crank();
Mechanism heavy_top();
Mechanism triple_pendulum();
Mechanism suspension_chain();
Mechanism hmmwv_corner();
Mechanism bouncing_journal();
Mechanism tilted_journal();
Mechanism stick_slip();
Mechanism rsup();

} // namespace gudgeon

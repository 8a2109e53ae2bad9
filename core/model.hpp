// What the user says: bodies, joints, forces, markers. Plain data, filled by the JSON reader
// (core/reader.hpp) or directly in C++; checked by validate(); compiled by System.
//
// SI units throughout (m, kg, s, N, rad). Poses: position of the mass centre in the global frame,
// Euler parameters body -> global. Velocities: global; angular velocities: body frame.
#pragma once

#include "core/equality.hpp"
#include "core/shared_part.hpp"
#include "core/time_function.hpp"
#include "core/types.hpp"

#include <array>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace gudgeon {

struct Body {
    std::string name;
    double mass = 0;              // kg
    Mat3 inertia = Mat3::Zero();  // kg m2, about the mass centre, body axes
    Vec3 position = Vec3::Zero(); // m
    Vec4 orientation{1, 0, 0, 0};
    Vec3 velocity = Vec3::Zero();         // m/s, global
    Vec3 angular_velocity = Vec3::Zero(); // rad/s, body frame
    /// A fixed body has no unknowns: it is part of the ground and may have no mass.
    bool fixed = false;
    bool piece = false; // a rigid element of a beam (core/beam.hpp): written as part of that beam
    /// Pose at the start, where it is not the one above, in which the geometry of the model is given.
    std::optional<Vec3> start_position;
    std::optional<Vec4> start_orientation;
    /// Coordinates kept while the start is assembled: x y z (global), rx ry rz (about body axes),
    /// vx vy vz (global), wx wy wz (body axes).
    std::vector<std::string> hold;
};

enum class JointKind {
    rigid,
    revolute,
    translation,
    cylindrical,
    spherical,
    universal,
    planar,
    point_on_axis,
    distance,
};

/// What holds a relative motion: a constraint, rubber, contact after a free play, or nothing.
enum class Fidelity { perfect, bushing, clearance, free };

/// The relative motions a joint may hold (design of AP 2.2): a joint kind holds some of them. Spherical
/// and universal joints hold all three displacements as `radial`; a universal joint's right angle is its
/// `misalignment`.
enum class Motion { radial, axial, misalignment, rotation };
inline constexpr std::array<std::string_view, 4> motion_names{"radial", "axial", "misalignment", "rotation"};

/// Six-component elastic law between the joint frames: three translations, three rotations
/// (components of the rotation vector), in the joint frame (h, t, b) or, with global_axes, along
/// axes parallel to the global ones in the pose as given (fixed in a).
struct Bushing {
    std::array<double, 6> stiffness{}; // N/m, N m/rad; ignored on axes with a table
    std::array<double, 6> damping{};   // N s/m, N m s/rad
    std::array<double, 6> preload{};   // N, N m: restoring force at zero displacement
    std::array<Table, 6> tables;       // restoring force against displacement, replaces the stiffness
    bool global_axes = false;
    GUDGEON_EQUALITY(Bushing)
};

/// Elastic constants of one of the two bodies in contact.
struct Material {
    double young = 0;   // Pa
    double poisson = 0; // 1
    GUDGEON_EQUALITY(Material)
};

/// Normal contact law as the user says it; contact/normal_law.hpp lists the kinds and what each needs.
/// Force against penetration: N and m, or N m and rad on a rotation. The stiffness is the whole joint's.
struct ContactLaw {
    std::string kind = "lankarani-nikravesh";
    std::optional<double> stiffness;   // N/m^exponent; absent: from materials and geometry
    std::optional<double> exponent;    // 1; absent: the law's own
    std::optional<double> restitution; // 1
    std::optional<double> speed;       // m/s, kelvin-voigt: width of its transition
    std::optional<double> damping;     // N s/m, linear and tabulated laws, bushing part of a blend
    std::optional<std::array<Material, 2>> materials; // of bearing and journal
    Table table;                                      // force against penetration, replaces the stiffness
    // blend (AP 50): a bushing of this thickness, then over a width the law in `hard` (one entry)
    std::optional<double> thickness; // m
    std::optional<double> width;     // m
    bool smooth = false;             // C1 blend instead of the weighted sum
    std::vector<ContactLaw> hard;
    GUDGEON_EQUALITY(ContactLaw)
};

/// Friction as the user says it; contact/friction_law.hpp lists the kinds.
struct Friction {
    std::string kind = "coulomb";          // coulomb, coulomb-smooth, lugre, dahl
    double kinetic = 0;                    // mu_k, 1
    std::optional<double> statics;         // mu_s, 1; absent: mu_k
    std::optional<double> speed;           // m/s, threshold (coulomb) or Stribeck speed (lugre)
    double exponent = 2;                   // of the Stribeck curve
    std::optional<double> sigma0;          // 1/m, bristle stiffness per normal force
    double sigma1 = 0, sigma2 = 0;         // s/m
    std::optional<double> normal_force;    // N, given; else that of the contact or of the reaction
    std::optional<double> radius;          // m, of a pin (slip speed = radius x rate), a face or a key
    std::optional<std::string> coordinate; // of the joint; absent: its only free one
    GUDGEON_EQUALITY(Friction)
};

/// Play between bearing and journal: radial = bearing radius - journal radius, and so on.
struct Clearance {
    std::string model = "strips";         // strips, planar, two-end (cylinders); slot (guide)
    std::optional<double> radial;         // m
    std::optional<double> axial;          // m, each side, between end faces; absent: the radial one
    std::optional<double> rotation;       // rad, each side: key or spline
    std::optional<double> misalignment;   // rad, universal joints: play of the right angle
    std::optional<double> radius;         // m, of the bearing or socket
    std::optional<double> length;         // m, of the bearing
    std::optional<double> journal_length; // m, centred on b's point; absent: always covers the bearing
    int strips = 8;
    std::vector<double> profile;                  // m, bearing radius of each strip; replaces radius
    std::optional<std::array<double, 2>> section; // m, slot: width along h and height along t
    bool bearing_on_b = false;
    ContactLaw law;                                    // radial
    std::optional<ContactLaw> axial_law, rotation_law; // absent: the radial one
    std::optional<Friction> friction;
    GUDGEON_EQUALITY(Clearance)
};

/// Limits of a free coordinate of a joint; `swing`, the angle between the axes of a ball, has an upper one
/// only.
struct Stop {
    std::optional<double> lower, upper; // m or rad
    ContactLaw law;
    std::optional<Friction> friction = std::nullopt; // of what slides over the stop
};

struct Joint {
    std::string name;
    JointKind kind = JointKind::rigid;
    std::array<std::string, 2> bodies{"ground",
                                      "ground"}; // a, b: coordinates are the motion of b relative to a

    /// Geometry: points and axes of both sides. In the global frame in the pose as given (then both
    /// axes are usually the same vector), or, with body_frame, each in the frame of its body.
    bool body_frame = false;
    bool piece = false; // the spring-damping element between two pieces of a beam
    std::array<Vec3, 2> points{Vec3::Zero(), Vec3::Zero()};
    /// Joint axis b of each side; absent: the joint frame is parallel to the global frame.
    /// Universal: axes[0] is fixed in a, axes[1] is the second axis, fixed in b.
    std::optional<std::array<Vec3, 2>> axes;
    /// First transverse direction h of each side (projected normal to the axis); absent: chosen by
    /// joint_triad() for a, and parallel to it in the pose as given for b.
    std::optional<std::array<Vec3, 2>> references;
    std::optional<double> length; // distance joint, m; absent: the distance of the points as given

    Fidelity fidelity = Fidelity::perfect;
    /// Mixed joints: what holds each motion, where it differs from fidelity; by Motion.
    std::array<std::optional<Fidelity>, 4> motions;
    SharedPart<Bushing> bushing;       // required where a motion is held by a bushing
    SharedPart<Clearance> clearance;   // required where a motion is held by contact
    std::map<std::string, Stop> stops; // by free coordinate
    std::vector<Friction> friction;    // on free coordinates
    Fidelity holds(Motion motion) const {
        return motions[static_cast<std::size_t>(motion)].value_or(fidelity);
    }
    /// Angles at the start that are not near zero, by coordinate: which of their turns is meant.
    std::map<std::string, double> start_angles;
    /// Driven coordinates: name of a free coordinate (angle, slide, u, v, angle1, angle2) -> function.
    std::map<std::string, TimeFunction> drives;
    /// Loops are cut here where the mechanism is treated as a tree (spanning_tree.hpp).
    bool cut = false;
};

/// Force along the line between two points: tension = k (l - l0) + c l' + actuator(t). A table
/// (force against elongation l - l0) replaces k. Either a free length or the tension at the start.
struct SpringDamper {
    std::string name;
    std::array<std::string, 2> bodies{"ground", "ground"};
    bool body_frame = false;
    std::array<Vec3, 2> points{Vec3::Zero(), Vec3::Zero()};
    double stiffness = 0;              // N/m
    double damping = 0;                // N s/m
    std::optional<double> free_length; // m; absent: the length as given
    std::optional<double> preload;     // N, tension in the pose as given (instead of free_length)
    Table table;                       // tension against elongation
    SharedPart<TimeFunction> actuator; // N, tension
};

/// Moment about the rotation coordinate of a joint: on b, -(k (q - q0) + c q').
struct TorsionSpring {
    std::string name;
    std::string joint;
    std::string coordinate = "angle"; // a rotation coordinate of that joint
    double stiffness = 0;             // N m/rad
    double damping = 0;               // N m s/rad
    double free_angle = 0;            // rad
    Table table;                      // restoring moment against q - q0, replaces k
};

/// Vertical spring-damper over a road: F_z = preload - k (z - z_ref - z_road) - c d/dt(z - z_road),
/// on the body at the point; bilateral, no horizontal force. z_road = road(t) + profile(x).
struct Tyre {
    std::string name;
    std::string body;
    bool body_frame = false;
    Vec3 point = Vec3::Zero();
    double stiffness = 0;            // N/m
    double damping = 0;              // N s/m
    double preload = 0;              // N
    std::optional<double> reference; // m, z_ref; absent: height of the point as given
    SharedPart<TimeFunction> road;
    Table profile; // road height against the x coordinate of the point
};

/// Force or torque vector times a function of time (absent: constant 1).
struct AppliedForce {
    std::string name;
    std::string body;
    bool torque = false;     // vector in N m instead of N; no point
    bool follows = false;    // the vector turns with the body ("axes": "body")
    bool body_frame = false; // the point is given in the body frame
    Vec3 point = Vec3::Zero();
    Vec3 vector = Vec3::Zero();
    SharedPart<TimeFunction> time;
};

/// Friction along a direction fixed in the first body, between points of two bodies, with a given normal
/// force: on the second body -N mu(v) along the axis, v the speed of its point relative to the first.
struct FrictionForce {
    std::string name;
    std::array<std::string, 2> bodies{"ground", "ground"};
    bool body_frame = false;
    std::array<Vec3, 2> points{Vec3::Zero(), Vec3::Zero()};
    Vec3 axis{1, 0, 0}; // global in the pose as given, or in the first body's frame
    Friction friction;
};

using Force = std::variant<SpringDamper, TorsionSpring, Tyre, AppliedForce, FrictionForce>;

/// Named point of a body as output.
struct Marker {
    std::string name;
    std::string body;
    bool body_frame = false;
    Vec3 point = Vec3::Zero();
    bool piece = false; // an end of a beam
};

/// Cross-section of a beam in its axes y and z.
struct GeneralSection {
    double area = 0, iy = 0, iz = 0;               // m2; m4: integrals of z^2 and of y^2
    double torsion = 0;                            // m4, Saint-Venant's constant
    std::array<double, 2> shear{5.0 / 6, 5.0 / 6}; // effective over whole area, along y and along z
};
struct RoundSection {
    double diameter = 0; // m
};
struct RectangleSection {
    double width = 0, height = 0; // m, along y and along z
};
struct TubeSection {
    double outer = 0, inner = 0; // m, diameters
};
using BeamSection = std::variant<GeneralSection, RoundSection, RectangleSection, TubeSection>;

struct BeamMaterial {
    double young = 0, poisson = 0, density = 0; // Pa, 1, kg/m3
    double loss = 0;                            // loss factor (twice the damping ratio) at the frequency
    std::optional<double> frequency;            // Hz; absent: first bending of the beam hinged at both ends
};

/// A straight, prismatic, elastic link, divided into rigid elements by expand_beams() (core/beam.hpp).
struct Beam {
    std::string name;
    std::array<Vec3, 2> points{Vec3::Zero(), Vec3::Zero()}; // m, global: start and end, the beam's x axis
    std::optional<Vec3> direction; // of y, projected normal to x; absent: chosen by joint_triad()
    BeamSection section;
    BeamMaterial material;
    int elements = 1;             // n spring-damping elements between n + 1 rigid ones
    bool stretch = true;          // false: neither extension nor shear, three rotations between neighbours
    Vec3 velocity = Vec3::Zero(); // m/s, global, of the middle
    Vec3 angular_velocity = Vec3::Zero(); // rad/s, beam axes
    /// Pose of each rigid element at the start of the motion; empty: the straight one.
    struct Pose {
        Vec3 position;
        Vec4 orientation;
    };
    std::vector<Pose> start;
    bool expanded = false; // its pieces are among the bodies, joints and markers of the model
};

struct Model {
    std::string name = "model";
    std::string source; // file it came from, for messages; empty: built in C++
    Vec3 gravity{0, 0, -9.81};
    std::map<std::string, double> parameters; // as used, for the record
    std::vector<Body> bodies;
    std::vector<Joint> joints;
    std::vector<Force> forces;
    std::vector<Marker> markers;
    std::vector<Beam> beams;
    std::optional<double> end;   // s, default end of a run
    std::optional<double> every; // s, default output interval
    /// How deep a contact may be when it is first seen, as a length (m), a force (N) or an energy (J);
    /// absent: from law, approach speed and tolerance (solvers/contact_watch.hpp).
    struct Onset {
        std::optional<double> depth, force, energy;
    };
    Onset onset;
};

/// Names of the coordinates of a joint as outputs, in their order: the free ones of a perfect joint; else
/// the six of the relative motion and those free ones that stops, friction or a key need.
std::vector<std::string> joint_coordinates(const Joint& joint);

/// A model that is refused. pointer: JSON pointer into the model file ("/bodies/0/mass").
class ModelError : public std::runtime_error {
  public:
    ModelError(std::string source, std::string pointer, std::string problem, std::string allowed);
    const std::string& pointer() const { return pointer_; }
    const std::string& problem() const { return problem_; }
    const std::string& allowed() const { return allowed_; }

  private:
    std::string pointer_, problem_, allowed_;
};

/// Equal bushings and clearances of different joints are stored once from now on.
void share_equal_parts(Model& model);

/// Throws ModelError on the first thing no mechanism can have (see models/README.md for the list).
void validate(const Model& model);

} // namespace gudgeon

// The compiled mechanism: flat arrays, batches, index maps and patterns. Constant once compiled; it
// holds data and no algorithm (assembly.hpp has those).
//
// Coordinates q: per moving body 7 numbers, position of the mass centre and Euler parameters.
// Velocities u: per moving body 6 numbers, velocity (global) and angular velocity (body frame).
// Multipliers lambda: one per constraint row; the constraints push with -G^T lambda (AP 2, transposed).
#pragma once

#include "core/batch.hpp"
#include "core/block_layout.hpp"
#include "core/model.hpp"

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace gudgeon {

/// One scalar coordinate of a joint as an output.
struct JointCoordinate {
    enum class Kind { displacement, angle, point, rotation, swing } kind;
    int index = 0; // angle: number in System::angles; displacement, point, rotation: axis 0..2 of a's frame
    std::string_view name; // in static storage
};

struct JointRecord {
    std::string name;
    JointKind kind;
    Anchor a, b;
    int first_row = 0, rows = 0;
    std::vector<JointCoordinate> coordinates;
    int contact = -1; // number in System::contact_joints, -1: nothing can touch
};

/// One constraint row.
struct RowRecord {
    int joint;
    int a, b;
    std::string_view direction; // what it stops: "displacement along h", "rotation about b", ...
    unsigned mask;              // which of its 12 coefficients can be nonzero
};

struct AngleRecord {
    int a, b;
    AngleFrames frames;
    double start; // branch at the start: the angle nearest to this value
};

struct MarkerRecord {
    std::string name;
    int body;
    Vec3 point; // body frame
};

struct System {
    Model model; // what it was compiled from

    // Bodies: [0, moving) have unknowns; fixed ones follow; the last is "ground".
    int moving = 0;
    std::vector<std::string> body_names;
    std::vector<BodyMotion> start; // poses and velocities as given
    std::vector<double> mass;      // moving bodies
    std::vector<Mat3> inertia, inverse_inertia;
    std::vector<unsigned> hold; // bits 0-5: coordinates kept in assembly, 6-11: velocities
    Vec3 gravity = Vec3::Zero();

    std::vector<JointRecord> joints;
    std::vector<RowRecord> rows;
    std::vector<AngleRecord> angles;
    std::vector<MarkerRecord> markers;

    std::vector<std::unique_ptr<ConstraintBatch>> constraints;
    std::vector<std::unique_ptr<ForceBatch>> forces;
    BlockLayout layout;

    std::vector<ContactChannel> contacts;
    std::vector<int> contact_elements; // first channel of each element that can touch, and their number
    std::vector<int> contact_joints;   // joints with contacts, as they appear in State::history
    std::vector<double> state_scales;  // per friction state, m: size of a change that matters
    std::size_t scratch = 0;           // doubles of Workspace::scratch
    bool reaction_friction = false;    // some friction takes its normal force from the multipliers

    int positions() const { return 7 * moving; }
    int velocities() const { return 6 * moving; }
    int row_count() const { return static_cast<int>(rows.size()); }
    int friction_states() const { return static_cast<int>(state_scales.size()); }
    int channels() const { return static_cast<int>(contacts.size()); }
    int body_index(std::string_view name) const; // -1: none
    int joint_index(std::string_view name) const;
};

/// What a batch builder may look at while the model is compiled.
struct CompileContext {
    const Model& model;
    const System& system; // bodies, joints and angles are filled
    std::function<int(std::string_view)> body;
    std::function<int(std::string_view)> joint;
    /// Number of the angle measure of a joint's coordinate.
    std::function<int(int joint, std::string_view coordinate)> angle;
    /// A global point (pose as given) in a body's frame.
    Vec3 in_body(int body, const Vec3& global) const;
};

/// Makes a force batch for what it finds in the model; null when there is nothing of its kind.
using ForceBatchBuilder = std::function<std::unique_ptr<ForceBatch>(const CompileContext&)>;

/// The builders of core: spring-dampers, torsion springs, tyres, applied forces.
std::vector<ForceBatchBuilder> core_force_builders();

/// Validates and compiles. Throws ModelError.
System compile(Model model, const std::vector<ForceBatchBuilder>& builders);

} // namespace gudgeon

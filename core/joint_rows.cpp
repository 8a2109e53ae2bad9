#include "core/joint_rows.hpp"

#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"

#include <algorithm>
#include <array>

namespace gudgeon {

namespace {

// Coefficient masks of a row over (v_a, w_a, v_b, w_b).
constexpr unsigned rotations = 0b111000111000;
constexpr unsigned everything = 0b111111111111;
constexpr unsigned one_translation(int k) { return (1u << k) | (1u << (6 + k)); }

constexpr std::array<std::string_view, 3> displacement_names{"displacement along h", "displacement along t",
                                                             "displacement along the axis"};

class RowBuilder {
  public:
    RowBuilder(int joint, JointRecord& record, System& system, ConstraintBatches& batches)
        : joint_(joint), record_(record), system_(system), batches_(batches), a_(record.a), b_(record.b) {}

    void coincident() {
        CoincidentKernel::Element x;
        place(x);
        x.sa = a_.point;
        x.sb = b_.point;
        batches_.coincident.add(x);
        static constexpr std::array<std::string_view, 3> names{"displacement along x", "displacement along y",
                                                               "displacement along z"};
        for (int k = 0; k < 3; ++k)
            row(names[k], rotations | one_translation(k));
    }

    void displacement(int axis) {
        DisplacementKernel::Element x;
        fill(x, axis);
        batches_.displacement.add(x);
        row(displacement_names[axis], everything);
    }

    void driven_displacement(int axis, const TimeFunction& f) {
        DrivenDisplacementKernel::Element x{{}, f};
        fill(x, axis);
        batches_.driven_displacement.add(std::move(x));
        row("driven displacement", everything);
    }

    /// Direction `axis_a` of a stays normal to direction `axis_b` of b.
    void alignment(int axis_a, int axis_b, std::string_view name) {
        AlignmentKernel::Element x;
        place(x);
        x.x = a_.axes.col(axis_a);
        x.y = b_.axes.col(axis_b);
        batches_.alignment.add(x);
        row(name, rotations);
    }

    void parallel_axes() {
        alignment(0, 2, "tilt about t");
        alignment(1, 2, "tilt about h");
    }

    void distance(double length) {
        DistanceKernel::Element x;
        place(x);
        x.sa = a_.point;
        x.sb = b_.point;
        x.length = length;
        batches_.distance.add(x);
        row("distance", everything);
    }

    void driven_angle(int angle, const TimeFunction& f) {
        DrivenAngleKernel::Element x{{}, system_.angles[angle].frames, angle, f};
        place(x);
        batches_.driven_angle.add(std::move(x));
        row("driven angle", rotations);
    }

  private:
    void place(ConstraintElement& x) const {
        x.a = a_.body;
        x.b = b_.body;
        x.row = system_.row_count();
    }
    void fill(DisplacementKernel::Element& x, int axis) const {
        place(x);
        x.sa = a_.point;
        x.sb = b_.point;
        x.x = a_.axes.col(axis);
    }
    void row(std::string_view name, unsigned mask) {
        system_.rows.push_back({joint_, a_.body, b_.body, name, mask});
        ++record_.rows;
    }

    int joint_;
    JointRecord& record_;
    System& system_;
    ConstraintBatches& batches_;
    const Anchor& a_;
    const Anchor& b_;
};

// Directions of the joint frames whose products give sine and cosine of a coordinate.
AngleFrames angle_frames(const JointRecord& r, std::string_view coordinate) {
    const auto a = [&](int k) -> Vec3 { return r.a.axes.col(k); };
    const auto b = [&](int k) -> Vec3 { return r.b.axes.col(k); };
    if (coordinate == "angle1")
        return {a(1), b(2), a(0), b(2)}; // second axis turned about the first
    if (coordinate == "angle2")
        return {a(2), -b(1), a(2), b(0)}; // first axis seen from b, turned back
    return {a(1), b(0), a(0), b(0)};
}

void add_drive(RowBuilder& rows, const JointCoordinate& c, const TimeFunction& f) {
    if (c.kind == JointCoordinate::Kind::angle)
        rows.driven_angle(c.index, f);
    else
        rows.driven_displacement(c.index, f);
}

// The motions that constraints hold in a joint where other things hold the rest.
void add_mixed_rows(RowBuilder& rows, const Joint& joint) {
    const auto constrained = [&](Motion motion) {
        return holds_motion(joint.kind, motion) && joint.holds(motion) == Fidelity::perfect;
    };
    const bool point = joint.kind == JointKind::spherical || joint.kind == JointKind::universal;
    if (constrained(Motion::radial)) {
        if (point || constrained(Motion::axial)) {
            rows.coincident();
        } else {
            rows.displacement(0);
            rows.displacement(1);
        }
    } else if (constrained(Motion::axial)) {
        rows.displacement(2);
    }
    if (constrained(Motion::misalignment)) {
        if (joint.kind == JointKind::universal)
            rows.alignment(2, 2, "angle between the two axes");
        else
            rows.parallel_axes();
    }
    if (constrained(Motion::rotation))
        rows.alignment(0, 1, "rotation about the axis");
}

// The name in static storage: joints are many, names few.
std::string_view coordinate_word(std::string_view name) {
    static constexpr std::array<std::string_view, 13> words{
        "dx", "dy", "dz", "ax", "ay", "az", "slide", "u", "v", "angle", "angle1", "angle2", "swing"};
    return *std::ranges::find(words, name);
}

} // namespace

void add_joint_coordinates(const Joint& joint, JointRecord& record, System& system) {
    using Kind = JointCoordinate::Kind;
    for (const std::string& name : joint_coordinates(joint)) {
        const std::string_view word = coordinate_word(name);
        if (name.starts_with("angle")) {
            const auto drive = joint.drives.find(name);
            const auto turned = joint.start_angles.find(name);
            const double start = drive != joint.drives.end()          ? evaluate(drive->second, 0).value
                                 : turned != joint.start_angles.end() ? turned->second
                                                                      : 0;
            system.angles.push_back({record.a.body, record.b.body, angle_frames(record, name), start});
            record.coordinates.push_back({Kind::angle, static_cast<int>(system.angles.size()) - 1, word});
        } else if (name == "slide" || name == "u" || name == "v") {
            record.coordinates.push_back({Kind::displacement, name == "u" ? 0 : name == "v" ? 1 : 2, word});
        } else if (name == "swing") {
            record.coordinates.push_back({Kind::swing, 0, word});
        } else {
            record.coordinates.push_back(
                {name[0] == 'd' ? Kind::point : Kind::rotation, name[1] - 'x', word});
        }
    }
}

void add_joint_rows(const Joint& joint, int joint_index, System& system, ConstraintBatches& batches) {
    JointRecord& record = system.joints[joint_index];
    record.first_row = system.row_count();
    RowBuilder rows(joint_index, record, system, batches);
    if (!is_wholly_perfect(joint)) {
        add_mixed_rows(rows, joint);
        return;
    }
    switch (joint.kind) {
    case JointKind::rigid:
        rows.coincident();
        rows.parallel_axes();
        rows.alignment(0, 1, "rotation about the axis");
        break;
    case JointKind::revolute:
        rows.coincident();
        rows.parallel_axes();
        break;
    case JointKind::translation:
        rows.displacement(0);
        rows.displacement(1);
        rows.parallel_axes();
        rows.alignment(0, 1, "rotation about the axis");
        break;
    case JointKind::cylindrical:
        rows.displacement(0);
        rows.displacement(1);
        rows.parallel_axes();
        break;
    case JointKind::spherical:
        rows.coincident();
        break;
    case JointKind::universal:
        rows.coincident();
        rows.alignment(2, 2, "angle between the two axes");
        break;
    case JointKind::planar:
        rows.displacement(2);
        rows.parallel_axes();
        break;
    case JointKind::point_on_axis:
        rows.displacement(0);
        rows.displacement(1);
        break;
    case JointKind::distance: {
        const BodyMotion &a = system.start[record.a.body], &b = system.start[record.b.body];
        rows.distance(joint.length ? *joint.length : distance::value(a, b, record.a.point, record.b.point));
        break;
    }
    }
    for (const JointCoordinate& c : record.coordinates)
        if (const auto drive = joint.drives.find(std::string(c.name)); drive != joint.drives.end())
            add_drive(rows, c, drive->second);
}

} // namespace gudgeon

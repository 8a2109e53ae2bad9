// Contact along one relative coordinate c of a joint, both ways: end stops of a free coordinate (AP 51-53),
// end faces of a bearing, the key of a slider.
//
//   depth = max(c - upper, lower - c), one contact with one memory; force f of the law at (depth, depth')
//   pushes c back: with s = +1 beyond upper and -1 beyond lower the wrench is -B^T (s f), B the gradient of c
//
// Coordinates: a displacement along an axis fixed in a (m), the unwrapped angle of the joint (rad; several
// turns count), the cosine between an axis of a and one of b (rad for small deviations from a right angle).
#pragma once

#include "contact/contact_batch.hpp"
#include "core/system.hpp"

#include <limits>

namespace gudgeon {

/// One measure of relative_motion.hpp, so that a kernel is written once.
struct DisplacementMeasure {
    Vec3 sa = Vec3::Zero(), sb = Vec3::Zero(), axis = Vec3::UnitX(); // body frames; axis in a
    static constexpr bool rotation = false;
    static constexpr CouplingMask coupling = couple_all; // B^T B reaches blocks that B^T g does not
    double value(const Evaluation&, const BodyMotion& a, const BodyMotion& b) const {
        return displacement::value(a, b, sa, sb, axis);
    }
    Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b) const {
        return displacement::gradient(a, b, sa, sb, axis);
    }
    Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b) const {
        return displacement::rate_gradient(a, b, sa, sb, axis);
    }
    void add_geometric(const BodyMotion& a, const BodyMotion& b, double g, BlockMatrix& out) const {
        displacement::add_geometric(a, b, sa, sb, g * axis, out);
    }
    Vec3 force_direction(const BodyMotion& a) const { return a.A * axis; }
};

struct AngleMeasure {
    AngleFrames frames;
    int angle = 0; // in System::angles
    static constexpr bool rotation = true;
    static constexpr CouplingMask coupling = angle::coupling;
    double value(const Evaluation& e, const BodyMotion& a, const BodyMotion& b) const {
        return angle::value(a, b, frames, e.angle_reference(angle));
    }
    Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b) const {
        return angle::gradient(a, b, frames);
    }
    Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b) const {
        return angle::rate_gradient(a, b, frames);
    }
    void add_geometric(const BodyMotion& a, const BodyMotion& b, double g, BlockMatrix& out) const {
        angle::add_geometric(a, b, frames, g, out);
    }
    Vec3 force_direction(const BodyMotion&) const { return Vec3::Zero(); }
};

struct CosineMeasure {
    Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(); // in a, in b
    static constexpr bool rotation = true;
    static constexpr CouplingMask coupling = alignment::coupling;
    double value(const Evaluation&, const BodyMotion& a, const BodyMotion& b) const {
        return alignment::value(a, b, x, y);
    }
    Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b) const {
        return alignment::gradient(a, b, x, y);
    }
    Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b) const {
        return alignment::rate_gradient(a, b, x, y);
    }
    void add_geometric(const BodyMotion& a, const BodyMotion& b, double g, BlockMatrix& out) const {
        alignment::add_geometric(a, b, x, y, g, out);
    }
    Vec3 force_direction(const BodyMotion&) const { return Vec3::Zero(); }
};

template <class Measure> struct LimitKernel {
    struct Element : ContactElement {
        Measure measure;
        double lower = -std::numeric_limits<double>::infinity();
        double upper = std::numeric_limits<double>::infinity();
        std::string_view place;
    };
    static constexpr const char* name = "limit";
    static constexpr CouplingMask coupling = Measure::coupling;
    static constexpr int contacts = 1;

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
    static ContactPlace place(const Element& x, int) { return {x.place, 0, Measure::rotation}; }
    static ContactSample sample(const Evaluation& e, const Element& x, int contact, int slot);
};

/// Stops of free coordinates, end faces and keys of the joints with clearance.
ForceBatchBuilder displacement_limit_builder();
ForceBatchBuilder angle_limit_builder();
ForceBatchBuilder cosine_limit_builder();

} // namespace gudgeon

// Contact along one relative coordinate c of a joint, both ways: end stops of a free coordinate (AP 51-53),
// end faces of a bearing, the key of a slider, the cone of a ball stud.
//
//   depth = max(c - upper, lower - c), one contact with one memory; force f of the law at (depth, depth')
//   pushes c back: with s = +1 beyond upper and -1 beyond lower the wrench is -B^T (s f), B the gradient of c
//
// Coordinates: a displacement along an axis fixed in a (m), the unwrapped angle of the joint (rad; several
// turns count), the cosine between an axis of a and one of b (rad for small deviations from a right angle),
// the swing: the angle in [0, pi] between two such axes. A swing has an upper limit only, above 0 and below
// pi, so that contact stays clear of both ends, where the angle has no gradient.
//
// Where friction is named, end faces and stops of displacements rub as faces, keys and stops of a turning
// slider as keys (friction_face.hpp); cosines and swings do not rub.
#pragma once

#include "contact/contact_batch.hpp"
#include "contact/friction_face.hpp"
#include "core/system.hpp"

#include <limits>

namespace gudgeon {

/// One measure of relative_motion.hpp, so that a kernel is written once.
struct DisplacementMeasure {
    Vec3 sa = Vec3::Zero(), sb = Vec3::Zero(), axis = Vec3::UnitX(); // body frames; axis in a
    static constexpr bool rotation = false;
    static constexpr CouplingMask coupling = couple_all; // B^T B reaches blocks that B^T g does not
    static constexpr bool rubs = true;
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
    static constexpr bool rubs = false;
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

/// The angle where a key rubs along the axis.
struct KeyMeasure : AngleMeasure {
    static constexpr CouplingMask coupling = couple_all;
    static constexpr bool rubs = true;
};

struct CosineMeasure {
    Vec3 x = Vec3::UnitX(), y = Vec3::UnitY(); // in a, in b
    static constexpr bool rotation = true;
    static constexpr CouplingMask coupling = alignment::coupling;
    static constexpr bool rubs = false;
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

struct SwingMeasure {
    Vec3 x = Vec3::UnitX(), y = Vec3::UnitX(); // in a, in b
    static constexpr bool rotation = true;
    static constexpr CouplingMask coupling = swing::coupling;
    static constexpr bool rubs = false;
    double value(const Evaluation&, const BodyMotion& a, const BodyMotion& b) const {
        return swing::value(a, b, x, y);
    }
    Gradient<1> gradient(const BodyMotion& a, const BodyMotion& b) const {
        return swing::gradient(a, b, x, y);
    }
    Gradient<1> rate_gradient(const BodyMotion& a, const BodyMotion& b) const {
        return swing::rate_gradient(a, b, x, y);
    }
    void add_geometric(const BodyMotion& a, const BodyMotion& b, double g, BlockMatrix& out) const {
        swing::add_geometric(a, b, x, y, g, out);
    }
    Vec3 force_direction(const BodyMotion&) const { return Vec3::Zero(); }
};

template <class Measure> struct LimitKernel {
    struct Element : ContactElement {
        Measure measure;
        FaceSlip face; // of what rubs
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
    static void state_terms(const Evaluation& e, const Element& x, int contact, double* source,
                            double* decay) requires Measure::rubs;
    static std::array<Linearisation::StateCoupling, 3> state_couplings(const Evaluation& e, const Element& x,
                                                                       int contact) requires Measure::rubs;
};

/// Stops of free coordinates, end faces and keys of the joints with clearance.
ForceBatchBuilder displacement_limit_builder();
ForceBatchBuilder angle_limit_builder(); // those that do not rub
ForceBatchBuilder key_limit_builder();   // those that do
ForceBatchBuilder cosine_limit_builder();
ForceBatchBuilder swing_limit_builder();

} // namespace gudgeon

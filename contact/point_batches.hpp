// Batches of the gaps with one or a few points: ball in socket, planar and two-end bearings, slots.
//
// Each point is a contact with its own memory; its force acts along its normal at the point
// (point_contact.hpp).
#pragma once

#include "contact/contact_batch.hpp"
#include "contact/gap_planar.hpp"
#include "contact/gap_slot.hpp"
#include "contact/gap_sphere.hpp"
#include "core/system.hpp"

#include <array>

namespace gudgeon {

/// What a kernel wants of a gap: its points all together, and the rates of one of them.
struct SphereShape {
    SphereGap gap;
    static constexpr int points = 1;
    static constexpr std::string_view place = "ball";
    std::array<ContactPoint, 1> find(const BodyMotion& a, const BodyMotion& b) const {
        return {sphere_point(a, b, gap)};
    }
    ContactPointRates rates(const BodyMotion& a, const BodyMotion& b, int, const ContactPoint& c) const {
        return sphere_rates(a, b, gap, c);
    }
};

struct PlanarShape {
    PlanarGap gap;
    static constexpr int points = 1;
    static constexpr std::string_view place = "journal";
    std::array<ContactPoint, 1> find(const BodyMotion& a, const BodyMotion& b) const {
        return {planar_point(a, b, gap)};
    }
    ContactPointRates rates(const BodyMotion& a, const BodyMotion& b, int, const ContactPoint& c) const {
        return planar_rates(a, b, gap, c);
    }
};

struct TwoEndShape {
    TwoEndGap gap;
    static constexpr int points = 2;
    static constexpr std::string_view place = "end";
    std::array<ContactPoint, 2> find(const BodyMotion& a, const BodyMotion& b) const {
        return two_end_points(a, b, gap);
    }
    ContactPointRates rates(const BodyMotion& a, const BodyMotion& b, int end, const ContactPoint& c) const {
        return two_end_rates(a, b, gap, end, c);
    }
};

struct SlotShape {
    SlotGap gap;
    static constexpr int points = slot_channels;
    static constexpr std::string_view place = "corner";
    std::array<ContactPoint, slot_channels> find(const BodyMotion& a, const BodyMotion& b) const {
        return slot_points(a, b, gap);
    }
    ContactPointRates rates(const BodyMotion& a, const BodyMotion& b, int, const ContactPoint& c) const {
        return slot_rates(a, b, gap, c);
    }
};

template <class Shape> struct PointKernel {
    struct Element : ContactElement {
        Shape shape;
    };
    static constexpr const char* name = "contact";
    static constexpr CouplingMask coupling = couple_all;
    static constexpr int contacts = Shape::points;

    static PairWrench wrench(const Evaluation& e, const Element& x);
    static void linearise(const Evaluation& e, const Element& x, BlockMatrix& c, BlockMatrix& s);
    static EnergyRates energies(const Evaluation& e, const Element& x);
    static ContactPlace place(const Element&, int contact) {
        return {Shape::place, Shape::points == 1 ? 0 : contact + 1};
    }
    static ContactSample sample(const Evaluation& e, const Element& x, int contact, int slot);
    static void state_terms(const Evaluation& e, const Element& x, int contact, double* source,
                            double* decay);
    static std::array<Linearisation::StateCoupling, 3> state_couplings(const Evaluation& e, const Element& x,
                                                                       int contact);
};

ForceBatchBuilder sphere_builder();  // spherical and universal joints
ForceBatchBuilder planar_builder();  // "model": "planar"
ForceBatchBuilder two_end_builder(); // "model": "two-end"
ForceBatchBuilder slot_builder();    // "model": "slot"

} // namespace gudgeon

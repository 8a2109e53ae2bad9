// Normal contact laws by name: force of a contact against its depth and rate (one file each in
// contact/laws/). SI units; on a rotation read rad for m and N m for N. Laws are values: no state, the
// starting speed is the caller's (Indentation). A joint of N strips scales: one strip has `share` (1/N) of
// the whole joint's force.
#pragma once

#include "contact/laws/blend.hpp"
#include "core/model.hpp"

#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gudgeon {

/// What a stiffness can be made of. Radii, length 0: unknown or none (end faces, stops).
struct ContactGeometry {
    double bearing_radius = 0; // m
    double journal_radius = 0; // m
    double length = 0;         // m, of the bearing
    double clearance = 0;      // m, radial
    bool rotation = false;     // depth is an angle: nothing can be made, the stiffness must be given
};

/// A law that cannot be. member: JSON pointer inside the law ("/restitution", "/hard/width"), "/kind" for
/// what the geometry does not fit.
struct LawError : std::invalid_argument {
    LawError(std::string member, std::string problem, std::string allowed);
    std::string member, problem, allowed;
};

class NormalLaw {
  public:
    explicit NormalLaw(SingleLaw law) : law_(std::move(law)) {}
    explicit NormalLaw(Blend blend);

    /// Starting speeds this law keeps per contact: 1, a blend 2 (whole contact, hard part).
    int slots() const { return blend_ ? 2 : 1; }
    /// Depth at which the second slot begins (m): inner.depth = outer.depth - inner_offset().
    double inner_offset() const { return blend_ ? blend_->thickness() : 0; }

    /// Laws of one slot. (A blend takes the starting speed for that of both its parts.)
    NormalForce evaluate(const Indentation& contact) const {
        if (blend_)
            return (*blend_)(contact,
                             {contact.depth - blend_->thickness(), contact.rate, contact.start_speed});
        return std::visit([&contact](const auto& law) { return law(contact); }, law_);
    }
    /// Any law; those of one slot ignore inner.
    NormalForce evaluate(const Indentation& outer, const Indentation& inner) const {
        return blend_ ? (*blend_)(outer, inner) : evaluate(outer);
    }

    /// Least depth (m) at which the whole joint's loading curve (laws/single_law.hpp: no damping;
    /// Kelvin-Voigt: its compression K d) has taken up this energy (J), or gives this force (N): for a strip
    /// divide by its share first. 0 for nothing, infinite if the law never gets there. Not for the inner
    /// loop.
    double depth_of_energy(double energy) const;
    double depth_of_force(double force) const;

  private:
    SingleLaw law_;
    std::shared_ptr<const Blend> blend_; // replaces law_
};

/// What a strip that carries this share of the joint feels.
inline NormalForce operator*(double share, const NormalForce& f) {
    return {share * f.force, share * f.by_depth, share * f.by_rate, share * f.elastic, share * f.energy};
}

/// Throws LawError where refusal() finds one. Given stiffness and exponent, or for the laws K d^n from both
/// materials and the geometry: AP 43 (bearing and journal radius, clearance), the cylinder law AP 44-48
/// (length, clearance). The hard part of a blend touches where the bushing ends: its bearing radius and its
/// clearance are larger by the thickness. Defaults: exponent 3/2 (cylinder: AP 47), restitution 1, damping 0.
NormalLaw compile_law(const ContactLaw& law, const ContactGeometry& geometry);

/// What keeps a law from being compiled; without a geometry only what the law itself says is looked at.
std::optional<LawError> refusal(const ContactLaw& law, const ContactGeometry* geometry = nullptr);

/// The list of laws.
struct NormalLawInfo {
    std::string_view name;
    std::string_view summary; // one line: formula and what it needs
    unsigned takes;           // which members of ContactLaw; the others are refused
    SingleLaw (*make)(const ContactLaw&, const ContactGeometry&); // null: blend
};
std::span<const NormalLawInfo> normal_law_kinds();

} // namespace gudgeon

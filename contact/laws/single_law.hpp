// Any law that keeps one starting speed per contact.
#pragma once

#include "contact/laws/cylinder.hpp"
#include "contact/laws/flores.hpp"
#include "contact/laws/hertz.hpp"
#include "contact/laws/hunt_crossley.hpp"
#include "contact/laws/kelvin_voigt.hpp"
#include "contact/laws/lankarani_nikravesh.hpp"
#include "contact/laws/linear.hpp"
#include "contact/laws/tabulated.hpp"

#include <variant>

namespace gudgeon {

using SingleLaw =
    std::variant<Hertz, LankaraniNikravesh, Cylinder, HuntCrossley, Flores, KelvinVoigt, Linear, Tabulated>;

/// The characteristic a law follows while the contact is pressed in, without the damping that depends on its
/// history: K d^n, K d (Kelvin-Voigt: its compression) or the table.
using Loading = std::variant<PowerLaw, const Tabulated*>;

inline Loading loading_of(const Hysteretic& law) { return law.elastic; }
inline Loading loading_of(const KelvinVoigt& law) { return PowerLaw{law.stiffness, 1}; }
inline Loading loading_of(const Linear& law) { return PowerLaw{law.stiffness, 1}; }
inline Loading loading_of(const Tabulated& law) { return &law; }
inline Loading loading_of(const SingleLaw& law) {
    return std::visit([](const auto& x) { return loading_of(x); }, law);
}

} // namespace gudgeon

// Checks of normal laws and friction laws: kinds, what each needs and what it has no use for.
#pragma once

#include "core/validate_parts.hpp"

namespace gudgeon {

/// Where a normal law acts, as far as it concerns the law.
struct LawPlace {
    const char* name;       // in messages: "a stop"
    bool radii = false;     // curved surfaces: materials may give the stiffness
    bool cylinders = false; // cylinder in cylinder: the law 'cylinder' may stand here
};

void check_law(const Checker& check, const std::string& at, const ContactLaw& law, const LawPlace& place);

/// Law and numbers; normal force, radius and coordinate are checked for their sign only.
void check_friction_law(const Checker& check, const std::string& at, const Friction& friction);

/// For friction whose normal force is a contact's own.
void refuse_coordinate_and_force(const Checker& check, const std::string& at, const Friction& friction,
                                 const char* place);
/// For friction that is not on a coordinate of a joint.
void refuse_radius_and_coordinate(const Checker& check, const std::string& at, const Friction& friction,
                                  const char* place);

} // namespace gudgeon

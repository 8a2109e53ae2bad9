// The force elements of a model as custom forces of Simbody, one for each kind.
//
//   bushing        d = A_a^T (P_b - P_a), theta the rotation vector of A_a^T A_b, A_a and A_b the axes of the
//                  bushing on a and b. g = preload + k c + damping c' for the six c = (d, theta); on the
//                  bodies the generalised forces -g of these coordinates, so that forces and moments balance
//   spring-damper  tension k (l - l0) + c l' along the line between the points
//   tyre           F_z = preload - k (z - reference - road) - c (z' - road'), on the body at the point
//
// Simbody's own LinearBushing measures the turn by body-fixed x-y-z angles instead: other forces from the
// second order of the angles on.
#pragma once

#include "core/model.hpp"

#include <Simbody.h>

#include <vector>

namespace gudgeon::peers {

/// A point with axes on a body, in its frame, whose origin is the mass centre.
struct Station {
    SimTK::MobilizedBody body;
    SimTK::Vec3 point{0};
    SimTK::Rotation axes;
};

struct BushingElement {
    Station a, b;
    SimTK::Vec3 stiffness[2], damping[2], preload[2]; // translations, rotations
};

struct SpringElement {
    Station a, b;
    double stiffness = 0, damping = 0, free_length = 0;
};

struct TyreLoad {
    Station at;
    double stiffness = 0, damping = 0, preload = 0, reference = 0;
    TimeFunction road;
};

/// Rotation vector of a rotation matrix, of length below pi.
SimTK::Vec3 rotation_vector_of(const SimTK::Rotation& turn);

void add_bushings(SimTK::GeneralForceSubsystem& forces, std::vector<BushingElement> elements);
void add_springs(SimTK::GeneralForceSubsystem& forces, std::vector<SpringElement> elements);
/// The same by elements of Simbody: LinearBushing (x-y-z angles, no preload), TwoPointLinearSpring and
/// -Damper.
void add_library_bushings(SimTK::GeneralForceSubsystem& forces, const std::vector<BushingElement>& elements);
void add_library_springs(SimTK::GeneralForceSubsystem& forces, const std::vector<SpringElement>& elements);

void add_tyres(SimTK::GeneralForceSubsystem& forces, std::vector<TyreLoad> elements);

} // namespace gudgeon::peers

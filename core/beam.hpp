// Flexible links by the rigid finite element method (AU 3; Wittbrodt, Szczotka, Maczynski & Wojciech,
// Rigid Finite Element Method in Analysis of Dynamics of Offshore Structures, 2013, ch. 3).
//
// Primary division: n equal parts of the length d = l/n, all the flexibility of a part gathered in a
// spring-damping element in its middle. Secondary division: the n + 1 rigid elements between these, the
// outer two of the length d/2. A rigid element is an ordinary body with the exact mass and inertia of its
// prism; a spring-damping element is an ordinary bushing (contact/bushing.hpp), whose displacements and
// rotation vector are those between the two sections that meet in it. In beam axes (x along the beam)
//
//   stiffness  extension E A/d, shear k G A/d along y and z, torsion G J/d, bending E Iy/d and E Iz/d
//   damping    loss / (2 pi f) times the stiffness (Kelvin-Voigt): the loss factor is right at f, and a
//              vibration of the frequency f has the damping ratio loss/2
//
// with G = E / (2 (1 + nu)) and Timoshenko's shear factors k. Without stretch the displacements are
// constraints and three rotations remain, as in AU.
//
// Deflections under forces (a tip force lacks 1/(4 n^2) of the bending), clamped frequencies and large
// deflections have errors of 1/n^2, hinged frequencies of 1/n^4; twist, extension and bending by end moments
// are exact. Each element bends by any rotation below half a turn, the beam by any number of turns. A
// bushing measures displacements in the axes of its first body; against the axes half way between both this
// is a difference of strain times bending of one element.
#pragma once

#include "core/model.hpp"

namespace gudgeon {

struct SectionProperties {
    double area, iy, iz, torsion;
    std::array<double, 2> shear; // Timoshenko's factors along y and z
};

/// Rectangle: Saint-Venant's series for the torsion constant. Shear factors of round, rectangle and tube:
/// Cowper, J. Appl. Mech. 33 (1966).
SectionProperties section_properties(const BeamSection& section, double poisson);

/// Stiffness of one spring-damping element: along x y z (N/m), about x y z (N m/rad); damping over
/// stiffness, s.
struct ElementStiffness {
    Vec3 displacement, rotation;
    double relaxation;
};
ElementStiffness element_stiffness(const Beam& beam);

/// Columns: the beam's axes x y z in the pose as given, global.
Mat3 beam_axes(const Beam& beam);

/// Puts what the beams consist of behind the bodies, joints and markers of the model: rigid elements
/// "<beam>.1" ... "<beam>.<n+1>", joints "<beam>.sde1" ... "<beam>.sde<n>" and markers "<beam>.start",
/// "<beam>.end"; these two are also other names of the first and last element. Does nothing to beams
/// that are expanded already. The beams must be valid.
void expand_beams(Model& model);

/// Some beam is not expanded yet.
bool has_unexpanded_beams(const Model& model);

} // namespace gudgeon

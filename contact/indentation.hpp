// What passes between a contact and its normal law.
#pragma once

namespace gudgeon {

/// State of one contact: depth > 0 is touching. On rotations read rad for m and N m for N.
struct Indentation {
    double depth = 0; // m
    double rate = 0;  // m/s, positive while the bodies approach
    /// Rate at which the contact began, m/s >= 0. Negative: the contact is new in this step and the speed
    /// is not known yet; the ratio of speeds then counts as 1 approaching, 0 leaving.
    double start_speed = -1;
};

/// Answer of a normal law; all zero for depth <= 0. The force pushes the bodies apart and never pulls.
struct NormalForce {
    double force = 0;    // N
    double by_depth = 0; // N/m, d force / d depth
    double by_rate = 0;  // N s/m, d force / d rate
    double elastic = 0;  // N, the part that stores energy: d energy / d depth
    double energy = 0;   // J, stored; the power (force - elastic) rate is dissipated
};

} // namespace gudgeon

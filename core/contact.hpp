// Contacts as the rest of the program sees them: channels, what they remember, what is measured on them.
//
// A channel is one place of a joint that can touch: a strip, a ball in its socket, an end face, a stop. What
// a channel remembers belongs to the State and changes only when a step is accepted.
#pragma once

#include "core/types.hpp"

#include <string_view>
#include <vector>

namespace gudgeon {

/// One contact of the compiled mechanism.
struct ContactChannel {
    int batch;              // in System::forces
    int joint;              // in System::joints
    int a, b;               // bodies, bearing and journal side
    std::string_view place; // "strip", "end face", "stop of slide", ...
    int number = 0;         // of its kind in the joint, from 1; 0: the only one
    bool rotation = false;  // depth in rad and a moment, not m and a force
};

/// What one channel does at an instant.
struct ContactSample {
    double depth = -1;                // m or rad, > 0 touching; apart: some negative bound
    double rate = 0;                  // its rate, m/s or rad/s
    double force = 0;                 // N or N m, normal
    double friction = 0;              // N or N m
    double dissipated_power = 0;      // W, normal law and friction
    double elastic = 0;               // J
    double place = 0;                 // kept in the memory, meaning set by the batch
    double share = 1;                 // of the law's force that this channel carries now
    double inverse_mass = 0;          // 1/kg or 1/(kg m2): B M^-1 B^T of the two bodies; 0 where not found
    Vec3 normal_force = Vec3::Zero(); // N, on b, global; zero for moments
    Vec3 friction_force = Vec3::Zero();
};

/// Memory of all channels.
struct ContactMemory {
    VecX start_speed; // m/s or rad/s at the start of the present contact; negative: apart
    VecX start_time;  // s
    VecX place;       // ContactSample::place at the last accepted step
};

/// History of one joint with contacts, for the record.
struct ContactHistory {
    long impacts = 0;         // starts of contact, of all its channels
    double deepest = 0;       // m
    double deepest_angle = 0; // rad
    double peak_force = 0;    // N, of the joint's resultant
    double peak_moment = 0;   // N m, largest of its rotations
    double touching = 0;      // s during which some channel touched
};

} // namespace gudgeon

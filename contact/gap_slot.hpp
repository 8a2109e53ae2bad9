// Block in a guide of rectangular section: translation joint with clearance. Frames (h, t, b) of both sides,
// b along the guide; guide half widths H along h and T along t, the block's are smaller by the clearance c.
//
// The sharp edges that can touch are the ends of the shorter part: the mouths of a guide that the block
// passes through, or the ends of a block inside a long guide. Their eight corners, fixed in the body that
// carries them, meet the four faces, planes fixed in the other body and taken as unbounded. A corner X at
// (sign_h, sign_t, sign_b) has two depths, against the faces of its own side:
//   corners of the guide (a), faces of the block (b):  depth = (H - c) - sign_h h_b . (X - P_b), n = sign_h
//   h_b corners of the block (b), faces of the guide (a):  depth = sign_h h_a . (X - P_a) - H,       n =
//   sign_h h_a
// and likewise along t; p = X. The corners of the block are exact. Those of the guide are concave across the
// section: against a block that turns about b they are exact to first order in c.
// Channel = 8 (face direction: 0 h, 1 t) + 4 (end: 0 -, 1 +) + 2 (side: 0 -, 1 +) + (other side: 0 -, 1 +).
#pragma once

#include "contact/point_contact.hpp"

#include <array>

namespace gudgeon {

struct SlotGap {
    Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero(); // m, middles of guide and block in their bodies
    Mat3 axes_a = Mat3::Identity(), axes_b = Mat3::Identity(); // (h, t, b) as columns, in their bodies
    std::array<double, 2> half_width{};                        // m, of the guide along h and t
    double clearance = 0;                                      // m, each side
    double length = 0;                                         // m, of the part that carries the corners
    bool corners_on_b = false;                                 // true: block shorter than the guide
};

inline constexpr int slot_channels = 16;

std::array<ContactPoint, slot_channels> slot_points(const BodyMotion& a, const BodyMotion& b,
                                                    const SlotGap& gap);

/// c: one of the points above (the same for all channels: point and normal are fixed in the bodies).
ContactPointRates slot_rates(const BodyMotion& a, const BodyMotion& b, const SlotGap& gap,
                             const ContactPoint& c);

} // namespace gudgeon

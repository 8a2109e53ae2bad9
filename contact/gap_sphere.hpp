// Ball in a socket: spherical joint with clearance. The ball's centre P_b is fixed in b, the socket's P_a in
// a.
//
// With e = P_b - P_a the depth is |e| - c, the normal n = e / |e| (the ball pushes the socket the way it
// went) and the contact point lies on the socket, p = P_a + R n. Only the line matters for the wrench: R = 0
// is fine where the radius is not known. At e = 0 the normal and its rates are zero, the depth is -c.
#pragma once

#include "contact/point_contact.hpp"

namespace gudgeon {

struct SphereGap {
    Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero(); // m, centres of socket and ball in their bodies
    double clearance = 0;                                // m, socket radius - ball radius
    double radius = 0;                                   // m, of the socket
};

ContactPoint sphere_point(const BodyMotion& a, const BodyMotion& b, const SphereGap& gap);

ContactPointRates sphere_rates(const BodyMotion& a, const BodyMotion& b, const SphereGap& gap,
                               const ContactPoint& c);

} // namespace gudgeon

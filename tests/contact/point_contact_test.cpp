#include "contact/point_contact.hpp"

#include "contact/gap_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

// Point fixed in a, normal fixed in b: a corner on a face.
struct CornerOnFace {
    Vec3 corner, face, normal;
    ContactPoint point(const Pair& m) const {
        ContactPoint c;
        c.p = point_position(m[0], corner);
        c.n = m[1].A * normal;
        c.depth = c.n.dot(point_position(m[1], face) - c.p);
        return c;
    }
    ContactPointRates rates(const Pair& m) const {
        ContactPointRates r;
        r.p.ra = Mat3::Identity();
        r.p.ta = -m[0].A * skew(corner);
        r.n.tb = -m[1].A * skew(normal);
        return r;
    }
};

TEST(PointContact, DerivativesAndBalance) {
    std::mt19937 rng(51);
    for (int k = 0; k < 10; ++k) {
        const CornerOnFace x{random_vector(rng), random_vector(rng), random_vector(rng).normalized()};
        check_contact(
            random_pair(rng), [&](const Pair& m) { return x.point(m); },
            [&](const Pair& m, const ContactPoint&) { return x.rates(m); });
    }
}

// Two unturned bodies, a at the origin, b at (2, 0, 0), contact at (1, 1, 0) with n = -x: 5 N push a along
// -x, with the moment (1, 1, 0) x (-5, 0, 0) = (0, 0, 5) about a, and b along +x with (-1, 1, 0) x (5, 0, 0)
// = (0, 0, -5).
TEST(PointContact, ByHand) {
    BodyMotion a, b;
    b.r = Vec3(2, 0, 0);
    const ContactPoint c{0.1, Vec3(1, 1, 0), -Vec3::UnitX()};
    const PairWrench w = point_wrench(a, b, c.p, 5 * c.n);
    EXPECT_EQ(w.force_a, Vec3(-5, 0, 0));
    EXPECT_EQ(w.moment_a, Vec3(0, 0, 5));
    EXPECT_EQ(w.force_b, Vec3(5, 0, 0));
    EXPECT_EQ(w.moment_b, Vec3(0, 0, -5));
    a.v = Vec3(3, 0, 0); // a approaches b
    EXPECT_EQ(depth_gradient(a, b, c).times(a, b)(0), 3);
    a.v.setZero();
    a.w = Vec3(0, 0, 2); // its point moves along -x with 2 m/s
    EXPECT_EQ(depth_gradient(a, b, c).times(a, b)(0), -2);
}

// A force that also depends on where the point is: f = f0 + g . p.
TEST(PointContact, ForceThatChangesAlongTheBody) {
    std::mt19937 rng(52);
    const CornerOnFace x{random_vector(rng), random_vector(rng), random_vector(rng).normalized()};
    const Vec3 slope(3, -7, 5);
    const Pair m = random_pair(rng);
    const auto wrench = [&](const Pair& y) {
        const ContactPoint c = x.point(y);
        return MatX(dense(point_wrench(y[0], y[1], c.p, (4 + slope.dot(c.p)) * c.n)));
    };
    const ContactPoint c = x.point(m);
    const ContactPointRates rates = x.rates(m);
    Gradient<1> change;
    change.ra = slope.transpose() * rates.p.ra;
    change.ta = slope.transpose() * rates.p.ta;
    BlockMatrix C = zero_blocks(), S = zero_blocks();
    add_contact_linearisation(m[0], m[1], c, rates, depth_gradient(m[0], m[1], c), 4 + slope.dot(c.p), change,
                              0, C, S);
    EXPECT_LT(error(dense(S), -jacobian(m, wrench, moved)), 1e-9);
    EXPECT_EQ(dense(C).norm(), 0);
}

} // namespace
} // namespace gudgeon

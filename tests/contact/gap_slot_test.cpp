#include "contact/gap_slot.hpp"

#include "contact/gap_tools.hpp"

namespace gudgeon {
namespace {

using namespace test;

TEST(GapSlot, DerivativesAndBalance) {
    std::mt19937 rng(31);
    for (const bool on_b : {false, true}) {
        SlotGap gap;
        gap.point_a = random_vector(rng);
        gap.point_b = random_vector(rng);
        gap.axes_a = rotation(random_orientation(rng));
        gap.axes_b = rotation(random_orientation(rng));
        gap.half_width = {0.5, 0.8};
        gap.clearance = 0.1;
        gap.length = 2;
        gap.corners_on_b = on_b;
        const Pair m = random_pair(rng); // any pose will do: nothing degenerates
        for (int k = 0; k < slot_channels; k += 3)
            check_contact(
                m, [&](const Pair& x) { return slot_points(x[0], x[1], gap)[k]; },
                [&](const Pair& x, const ContactPoint& c) { return slot_rates(x[0], x[1], gap, c); });
    }
}

SlotGap guide_along_z(bool on_b) {
    SlotGap gap;
    gap.half_width = {0.02, 0.03};
    gap.clearance = 1e-3;
    gap.length = 0.1;
    gap.corners_on_b = on_b;
    return gap;
}

// Shifted by 1.5 mm along h: four corners touch the + side, 0.5 mm deep; the guide is pushed along +h.
TEST(GapSlot, ShiftedBlock) {
    for (const bool on_b : {false, true}) {
        const SlotGap gap = guide_along_z(on_b);
        BodyMotion a, b;
        b.r = Vec3(1.5e-3, 0, 0.4);
        const auto c = slot_points(a, b, gap);
        for (int k = 0; k < slot_channels; ++k) {
            const bool h = k < 8, plus = k & 2;
            EXPECT_NEAR(c[k].depth, h ? (plus ? 5e-4 : -2.5e-3) : -1e-3, 1e-16) << k;
            EXPECT_LT((c[k].n - (plus ? 1 : -1) * (h ? Vec3::UnitX() : Vec3::UnitY())).norm(), 1e-15) << k;
        }
        b.v = Vec3(1, 0, 0);
        EXPECT_NEAR(depth_gradient(a, b, c[2]).times(a, b)(0), 1, 1e-15);
    }
}

// Pitch about t by angle g about the middle: the ends touch on opposite sides.
TEST(GapSlot, TiltedBlock) {
    const double g = 0.03;
    for (const bool on_b : {false, true}) {
        const SlotGap gap = guide_along_z(on_b);
        BodyMotion a, b;
        b.A = Eigen::AngleAxisd(g, Vec3::UnitY()).toRotationMatrix();
        const auto c = slot_points(a, b, gap);
        // Block in the guide: corner (H - c, l/2) turned. Guide round the block: the mouth's corner (-H, l/2)
        // seen in the block's frame.
        const double H = 0.02, l2 = 0.05, clear = 1e-3;
        const double expected = on_b ? (H - clear) * std::cos(g) + l2 * std::sin(g) - H
                                     : H - clear - (H * std::cos(g) - l2 * std::sin(g));
        EXPECT_GT(expected, 0);
        const int far_plus = 4 + 2, near_minus = 0; // ends + and -, sides + and -
        EXPECT_NEAR(c[far_plus].depth, expected, 1e-16);
        EXPECT_NEAR(c[near_minus].depth, expected, 1e-16);
        EXPECT_LT(c[4].depth, 0);
        EXPECT_LT(c[2].depth, 0);
    }
}

// Turned about b by g: a block's corners touch when T sin g exceeds the clearance, the guide's to first
// order.
TEST(GapSlot, TurnedBlock) {
    const double g = 0.05;
    BodyMotion a, b;
    b.A = Eigen::AngleAxisd(g, Vec3::UnitZ()).toRotationMatrix();
    double deepest[2];
    for (const bool on_b : {false, true}) {
        const auto c = slot_points(a, b, guide_along_z(on_b));
        deepest[on_b] = -1;
        for (const ContactPoint& x : c)
            deepest[on_b] = std::max(deepest[on_b], x.depth);
    }
    EXPECT_NEAR(deepest[1], 0.019 * std::cos(g) + 0.029 * std::sin(g) - 0.02, 1e-16);
    EXPECT_NEAR(deepest[0], deepest[1], 2 * g * 1e-3);
}

} // namespace
} // namespace gudgeon

#include "core/shared_part.hpp"

#include "core/model.hpp"
#include "models/mechanisms.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

namespace gudgeon {
namespace {

TEST(SharedPart, IsEmptyUntilItIsGivenAValue) {
    SharedPart<Bushing> part;
    EXPECT_FALSE(part);
    EXPECT_FALSE(part.has_value());
    EXPECT_THROW(part.value(), std::bad_optional_access);
    part = Bushing{};
    EXPECT_TRUE(part);
    part->stiffness[2] = 3;
    EXPECT_EQ(part.value().stiffness[2], 3);
    part.reset();
    EXPECT_FALSE(part);
    part.emplace().damping[0] = 1;
    EXPECT_EQ(part->damping[0], 1);
    part = std::nullopt;
    EXPECT_FALSE(part);
    EXPECT_EQ(sizeof(part), sizeof(std::shared_ptr<int>));
}

TEST(SharedPart, CopiesShareTheValueUntilOneChanges) {
    SharedPart<Bushing> first = Bushing{};
    first->preload[1] = 5;
    SharedPart<Bushing> second = first;
    EXPECT_TRUE(first.shares(second));
    const SharedPart<Bushing>& seen = second;
    EXPECT_EQ(seen->preload[1], 5);
    EXPECT_TRUE(first.shares(second)); // reading shares on
    second->preload[1] = 7;
    EXPECT_FALSE(first.shares(second));
    EXPECT_EQ(first.value().preload[1], 5);
    EXPECT_EQ(second.value().preload[1], 7);
}

TEST(SharedPart, SharesEqualValuesOnly) {
    SharedPart<Bushing> a = Bushing{}, b = Bushing{}, other = Bushing{}, none;
    other->tables[4] = {{0, 1}, {0, 2}};
    EXPECT_FALSE(a.shares(b));
    EXPECT_FALSE(a.share_if_equal(other));
    EXPECT_FALSE(a.share_if_equal(none));
    EXPECT_FALSE(none.share_if_equal(a));
    EXPECT_TRUE(a.share_if_equal(b));
    EXPECT_TRUE(a.shares(b));
    EXPECT_TRUE(a.share_if_equal(b)); // already so
}

// The chain has two kinds of rubber, in the arms and between the units, and one bearing.
TEST(SharedPart, EqualPartsOfJointsAreStoredOnce) {
    Model model = build_mechanism("suspension-chain", {{"units", "3"}, {"joints", "mixed"}});
    share_equal_parts(model);
    std::vector<SharedPart<Bushing>> rubber;
    std::vector<SharedPart<Clearance>> bearings;
    const auto count = [](auto& known, const auto& part) {
        if (part && std::ranges::none_of(known, [&](const auto& k) { return k.shares(part); }))
            known.push_back(part);
    };
    for (const Joint& joint : model.joints) {
        count(rubber, joint.bushing);
        count(bearings, joint.clearance);
    }
    EXPECT_EQ(rubber.size(), 2u);
    EXPECT_EQ(bearings.size(), 1u);

    Joint& joint = *std::ranges::find_if(model.joints, [](const Joint& j) { return j.bushing.has_value(); });
    const double before = rubber[0].value().stiffness[0];
    joint.bushing->stiffness[0] = 2 * before;
    EXPECT_EQ(rubber[0].value().stiffness[0], before); // the others keep theirs
}

} // namespace
} // namespace gudgeon

// Archives against the published check value of their checksum, and round trips.
#include "core/archive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <sstream>

namespace gudgeon {
namespace {

TEST(Archive, ChecksumHasItsPublishedValue) {
    EXPECT_EQ(crc64("123456789"), 0x995DC9BBDF1939FAu); // CRC-64/XZ
    EXPECT_EQ(crc64(""), 0u);
}

struct Everything {
    double number = 0;
    bool flag = false;
    VecX vector;
    MatX matrix;
    std::vector<std::string> words;
    std::optional<double> maybe, never;
    std::map<std::string, int> map;
    std::array<Vec3, 2> fixed{};
    std::vector<std::complex<double>> values;
    void visit(Archive& archive) {
        archive(number, flag, vector, matrix, words, maybe, never, map, fixed, values);
    }
};

Everything example() {
    Everything x;
    x.number = -0.0;
    x.flag = true;
    x.vector = VecX::LinSpaced(5, 1, std::numeric_limits<double>::infinity());
    x.matrix = MatX::Identity(2, 3);
    x.words = {"", "a\0b", "c"};
    x.maybe = 0.1;
    x.map = {{"one", 1}, {"two", 2}};
    x.fixed[1] = {1, 2, 3};
    x.values = {{1, -1}};
    return x;
}

TEST(Archive, GivesBackWhatWasPutIn) {
    Everything in = example(), out;
    out.never = 3;
    out.map = {{"old", 0}};
    Archive saved;
    saved(in);
    std::stringstream stream;
    write_sealed(stream, saved);
    Archive loaded = read_sealed(stream);
    loaded(out);
    loaded.finish();
    EXPECT_TRUE(std::signbit(out.number) && out.number == 0);
    EXPECT_TRUE(out.flag && out.maybe == 0.1 && !out.never);
    EXPECT_EQ(out.vector.size(), 5);
    EXPECT_TRUE(out.matrix == in.matrix && out.words == in.words && out.map == in.map &&
                out.fixed == in.fixed && out.values == in.values);
}

TEST(Archive, EveryLengthThatIsTooShortIsRefused) {
    Everything in = example();
    Archive saved;
    saved(in);
    for (std::size_t n = 0; n < saved.content().size(); ++n) {
        Archive cut(saved.content().substr(0, n));
        Everything out;
        EXPECT_THROW(cut(out), ArchiveError) << n;
    }
    Archive longer(saved.content() + "x");
    Everything out;
    longer(out);
    EXPECT_THROW(longer.finish(), ArchiveError);
}

TEST(Archive, SectionsAndIdentities) {
    Archive saved;
    saved.section("gear");
    saved.same(3, "another size");
    Archive right(saved.content()), wrong(saved.content()), other(saved.content());
    right.section("gear");
    right.same(3, "another size");
    EXPECT_THROW(wrong.section("radau"), ArchiveError);
    other.section("gear");
    EXPECT_THROW(other.same(4, "another size"), ArchiveError);
}

} // namespace
} // namespace gudgeon

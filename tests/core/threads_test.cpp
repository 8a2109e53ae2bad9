// The same bits for any number of threads, and several threads at work.
#include "core/parallel.hpp"
#include "core/user_force.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <omp.h>

#include <algorithm>
#include <cstring>
#include <mutex>
#include <set>
#include <vector>

namespace gudgeon {
namespace {

using namespace test;

struct Numbered {
    int a, b;
};

TEST(Threads, TwoShareTheElementsOfAColour) {
    ColouredElements<Numbered> elements;
    for (int i = 0; i < 1000; ++i)
        elements.items().push_back({i, 1000});
    elements.colour(1000);
    ASSERT_EQ(elements.colour_starts().size(), 2u);
    std::vector<int> ran_by(1000, -1), team(1000, 0);
    elements.for_each(2, [&](const Numbered& x) {
        ran_by[x.a] = omp_get_thread_num();
        team[x.a] = omp_get_num_threads();
    });
    EXPECT_EQ(std::set<int>(ran_by.begin(), ran_by.end()), (std::set<int>{0, 1}));
    EXPECT_EQ(std::set<int>(team.begin(), team.end()), std::set<int>{2});
}

TEST(Threads, ALoopTakesEveryTurnOnce) {
    for (const int threads : {1, 2, 3})
        for (const int count : {0, 1, 99, 100, 101}) { // threshold 100
            std::vector<int> turns(count, 0);
            std::set<int> ran;
            std::mutex lock;
            parallel_for(threads, 0, count, 100, [&](std::ptrdiff_t i) {
                ++turns[i];
                const std::lock_guard<std::mutex> guard(lock);
                ran.insert(omp_get_thread_num());
            });
            EXPECT_TRUE(std::ranges::all_of(turns, [](int n) { return n == 1; })) << threads << ' ' << count;
            EXPECT_EQ(ran.size(), count == 0 ? 0u : count < 100 ? 1u : static_cast<unsigned>(threads));
        }
}

TEST(Threads, NoTwoElementsOfAColourShareAMovingBody) {
    ColouredElements<Numbered> elements;
    std::mt19937 rng(1);
    std::uniform_int_distribution<int> body(0, 60); // 50 moving, 11 fixed
    for (int i = 0; i < 500; ++i)
        elements.items().push_back({body(rng), body(rng)});
    elements.colour(50);
    EXPECT_EQ(elements.items().size(), 500u);
    for (std::size_t c = 0; c + 1 < elements.colour_starts().size(); ++c) {
        std::set<int> seen;
        for (int i = elements.colour_starts()[c]; i < elements.colour_starts()[c + 1]; ++i) {
            const Numbered x = elements.items()[i];
            for (const int b : {x.a, x.b})
                if (b < 50 && x.a != x.b) {
                    EXPECT_TRUE(seen.insert(b).second) << "colour " << c << ", body " << b;
                }
        }
    }
}

struct Bits {
    VecX f, phi, rate;
    std::vector<double> rows, C, S, K;

    bool operator==(const Bits& o) const {
        const auto same = [](const auto& x, const auto& y) {
            return x.size() == y.size() && std::memcmp(x.data(), y.data(), sizeof(double) * x.size()) == 0;
        };
        return same(f, o.f) && same(phi, o.phi) && same(rate, o.rate) && same(rows, o.rows) && same(C, o.C) &&
               same(S, o.S) && same(K, o.K);
    }
};

Bits evaluate_all(const System& system, const State& state, int threads) {
    Workspace ws = make_workspace(system, threads);
    set_motion(system, state.q, state.u, ws);
    evaluate_forces(system, 0.3, ws);
    evaluate_constraints(system, 0.3, state.lambda.data(), true, ws);
    Bits bits{ws.f, ws.phi, ws.rate, ws.rows, {}, {}, {}};
    linearise(system, 0.3, state.lambda.data(), ws);
    bits.C = ws.lin.C;
    bits.S = ws.lin.S;
    const SaddleMatrix saddle(system);
    bits.K.assign(saddle.pattern().nonzeros(), 0);
    saddle.assemble(system, ws, 1000, 1e-3, bits.K);
    return bits;
}

TEST(Threads, LargeSystemHasTheSameBitsForAnyNumber) {
    for (const char* joints : {"bushing", "perfect"}) {
        Model model = build_mechanism("suspension-chain", {{"units", "200"}, {"joints", joints}});
        std::mutex lock;
        std::set<int> ran;
        std::vector<UserForce> forces; // they tell who evaluates
        for (int k = 0; k < 200; ++k)
            forces.push_back({"wind" + std::to_string(k),
                              {"ground", "chassis" + std::to_string(k)},
                              [&](const UserForceInput& in, UserForceOutput& out) {
                                  out.wrench.force_b = -3 * in.b.v;
                                  const std::lock_guard<std::mutex> guard(lock);
                                  ran.insert(omp_get_thread_num());
                              }});
        std::vector<ForceBatchBuilder> builders = standard_force_builders();
        builders.push_back(user_force_builder(forces));
        const System system = compile(std::move(model), builders);
        std::mt19937 rng(17);
        const State state = shaken(system, rng, 0.01, 1);

        const Bits one = evaluate_all(system, state, 1);
        EXPECT_EQ(ran, std::set<int>{0});
        EXPECT_GT(one.f.norm(), 0);
        for (const int threads : {2, 3}) {
            ran.clear();
            EXPECT_TRUE(evaluate_all(system, state, threads) == one) << joints << ", " << threads;
            EXPECT_EQ(ran.size(), static_cast<std::size_t>(threads));
        }
    }
}

} // namespace
} // namespace gudgeon

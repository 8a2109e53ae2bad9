// Every normal law: values by hand, derivatives, stored energy, dissipation, limits, refusals.
#include "contact/normal_law.hpp"

#include "tests/allocation_count.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

namespace gudgeon {
namespace {

ContactLaw named(const std::string& kind) {
    ContactLaw law;
    law.kind = kind;
    return law;
}

ContactLaw hysteretic(const std::string& kind, double stiffness, double restitution) {
    ContactLaw law = named(kind);
    law.stiffness = stiffness;
    if (kind != "hertz")
        law.restitution = restitution;
    return law;
}

ContactLaw kelvin_voigt() {
    ContactLaw law = hysteretic("kelvin-voigt", 1e5, 0.3);
    law.speed = 0.1;
    return law;
}

ContactLaw linear(double stiffness, double damping) {
    ContactLaw law = named("linear");
    law.stiffness = stiffness;
    law.damping = damping;
    return law;
}

ContactLaw tabulated() {
    ContactLaw law = named("tabulated");
    law.table = {{0, 1e-4, 3e-4, 1e-3}, {0, 20, 50, 400}};
    law.damping = 30;
    return law;
}

ContactLaw blend(const ContactLaw& hard, bool smooth) {
    ContactLaw law = named("blend");
    law.stiffness = 1e4;
    law.damping = 20;
    law.thickness = 1e-3;
    law.width = 3e-4;
    law.smooth = smooth;
    law.hard = {hard};
    return law;
}

ContactLaw soft_table_blend(const ContactLaw& hard) {
    ContactLaw law = blend(hard, true);
    law.stiffness.reset();
    law.table = {{0, 5e-4, 1.05e-3, 1.2e-3, 2e-3}, {0, 8, 11, 30, 40}};
    return law;
}

const ContactGeometry journal{0.011, 0.01, 0.02, 1e-3, false};

struct Case {
    std::string name;
    ContactLaw law;
};

std::vector<Case> all_laws() {
    return {{"hertz", hysteretic("hertz", 5e6, 1)},
            {"lankarani-nikravesh", hysteretic("lankarani-nikravesh", 5e6, 0.75)},
            {"cylinder", hysteretic("cylinder", 5e6, 0.4)},
            {"hunt-crossley", hysteretic("hunt-crossley", 5e6, 0.5)},
            {"flores", hysteretic("flores", 5e6, 0.2)},
            {"kelvin-voigt", kelvin_voigt()},
            {"linear", linear(1e5, 40)},
            {"tabulated", tabulated()},
            {"sum, flores", blend(hysteretic("flores", 1e8, 0.5), false)},
            {"smooth, cylinder", blend(hysteretic("cylinder", 1e8, 0.5), true)},
            {"smooth, kelvin-voigt", blend(kelvin_voigt(), true)},
            {"sum, tabulated", blend(tabulated(), false)},
            {"tables, smooth, tabulated", soft_table_blend(tabulated())},
            {"tables, smooth, lankarani", soft_table_blend(hysteretic("lankarani-nikravesh", 1e8, 0.5))}};
}

// What a contact is at: the two starting speeds belong to the whole and to the hard part.
struct Point {
    double depth, rate, start, inner_start;
};

NormalForce at(const NormalLaw& law, const Point& p) {
    return law.evaluate({p.depth, p.rate, p.start}, {p.depth - law.inner_offset(), p.rate, p.inner_start});
}

// Compressing beyond the start (capped), compressing, leaving, leaving fast (clipped), resting, new.
std::vector<Point> points() {
    std::vector<Point> out;
    for (const double depth : {3e-6, 4e-5, 1.7e-4, 6.1e-4, 1.02e-3, 1.13e-3, 1.27e-3, 2.1e-3})
        for (const double rate : {0.9, 0.083, 0.031, -0.013, -0.11, -4.7})
            for (const double start : {0.25, 0.06, 1e-10, -1.0})
                out.push_back({depth, rate, start, start > 0 ? 0.7 * start : 0.05});
    return out;
}

double derivative(const std::function<double(double)>& f, double x, double h) {
    const auto central = [&](double s) { return (f(x + s) - f(x - s)) / (2 * s); };
    return (4 * central(h / 2) - central(h)) / 3;
}

TEST(NormalLaw, DerivativesAndEnergyAgainstDifferences) {
    for (const Case& c : all_laws()) {
        SCOPED_TRACE(c.name);
        const NormalLaw law = compile_law(c.law, journal);
        for (const Point& p : points()) {
            SCOPED_TRACE(testing::Message() << p.depth << ' ' << p.rate << ' ' << p.start);
            const NormalForce f = at(law, p);
            const double stiff = 1e-6 * (std::abs(f.by_depth) + f.elastic / p.depth);
            const auto moved = [&](double depth, double rate) {
                return at(law, {depth, rate, p.start, p.inner_start});
            };
            const double h = 1e-3 * p.depth;
            EXPECT_NEAR(f.by_depth, derivative([&](double d) { return moved(d, p.rate).force; }, p.depth, h),
                        stiff);
            EXPECT_NEAR(f.elastic, derivative([&](double d) { return moved(d, p.rate).energy; }, p.depth, h),
                        1e-8 * f.elastic);
            const double damped = derivative([&](double v) { return moved(p.depth, v).force; }, p.rate,
                                             1e-3 * std::abs(p.rate));
            EXPECT_NEAR(f.by_rate, damped, 1e-8 * (std::abs(f.by_rate) + f.force / std::abs(p.rate)));
        }
    }
}

TEST(NormalLaw, NeverPullsAndNeverMakesEnergy) {
    for (const Case& c : all_laws()) {
        SCOPED_TRACE(c.name);
        const NormalLaw law = compile_law(c.law, journal);
        for (const Point& p : points()) {
            SCOPED_TRACE(testing::Message() << p.depth << ' ' << p.rate << ' ' << p.start);
            const NormalForce f = at(law, p);
            EXPECT_GE(f.force, 0);
            EXPECT_GT(f.energy, 0);
            EXPECT_GE((f.force - f.elastic) * p.rate, -1e-12 * f.elastic * std::abs(p.rate));
            if (f.force == 0) {
                EXPECT_EQ(f.by_depth, 0);
                EXPECT_EQ(f.by_rate, 0);
            }
        }
    }
}

// The energy is the integral of the elastic part, over every border of a blend.
TEST(NormalLaw, EnergyIsTheWorkOfTheElasticPart) {
    for (const Case& c : all_laws()) {
        SCOPED_TRACE(c.name);
        const NormalLaw law = compile_law(c.law, journal);
        for (const double start : {0.2, 1e-10}) {
            double work = 0, low = 0;
            for (const double high : {1e-4, 3e-4, 5e-4, 1e-3, 1.05e-3, 1.1e-3, 1.2e-3, 1.3e-3, 2e-3}) {
                const int n = 2000; // Simpson in t, depth = low + (high - low) t^3: the powers become smooth
                const auto g = [&](double t) {
                    const double depth = low + (high - low) * t * t * t;
                    return at(law, {depth, 0, start, start}).elastic * (high - low) * 3 * t * t;
                };
                double sum = g(0) + g(1);
                for (int i = 1; i < n; ++i)
                    sum += (i % 2 ? 4 : 2) * g(double(i) / n);
                work += sum / (3 * n);
                const double stored = at(law, {high, 0, start, start}).energy;
                EXPECT_NEAR(stored, work, 1e-11 * stored) << high;
                low = high;
            }
        }
    }
}

TEST(NormalLaw, NothingWithoutTouchAndAllBeginsAtZero) {
    for (const Case& c : all_laws()) {
        SCOPED_TRACE(c.name);
        const NormalLaw law = compile_law(c.law, journal);
        for (const double depth : {0.0, -1e-9, -1.0}) {
            const NormalForce f = at(law, {depth, 1, 1, 1});
            EXPECT_EQ(f.force, 0);
            EXPECT_EQ(f.by_depth, 0);
            EXPECT_EQ(f.by_rate, 0);
            EXPECT_EQ(f.elastic, 0);
            EXPECT_EQ(f.energy, 0);
        }
        const double damping = c.law.damping.value_or(0); // viscous damping begins with a jump
        EXPECT_NEAR(at(law, {1e-14, 0.5, 0.5, 0.5}).force, 0.5 * damping, 1e-5);
        EXPECT_NEAR(at(law, {1e-14, -0.5, 0.5, 0.5}).force, 0, 1e-5);
    }
}

TEST(NormalLaw, BordersOfABlendAreContinuous) {
    for (const Case& c : all_laws()) {
        const NormalLaw law = compile_law(c.law, journal);
        if (law.slots() == 1)
            continue;
        SCOPED_TRACE(c.name);
        for (const double border : {1e-3, 1.3e-3}) {
            const NormalForce below = at(law, {border - 1e-13, 0.05, 0.2, 0.1});
            const NormalForce above = at(law, {border + 1e-13, 0.05, 0.2, 0.1});
            EXPECT_NEAR(below.force, above.force, 1e-6 * above.force);
            EXPECT_NEAR(below.elastic, above.elastic, 1e-6 * above.elastic);
            EXPECT_NEAR(below.energy, above.energy, 1e-8 * above.energy);
            if (c.law.smooth && c.law.hard[0].damping.value_or(0) == 0) {
                EXPECT_NEAR(below.by_depth, above.by_depth, 1e-4 * std::abs(above.by_depth));
            }
        }
    }
}

void expect_force(const NormalForce& f, double force, double by_depth, double by_rate, double energy) {
    EXPECT_NEAR(f.force, force, 1e-12 * (1 + force));
    EXPECT_NEAR(f.by_depth, by_depth, 1e-12 * (1 + std::abs(by_depth)));
    EXPECT_NEAR(f.by_rate, by_rate, 1e-12 * (1 + by_rate));
    EXPECT_NEAR(f.energy, energy, 1e-12);
}

// K = 1e6, d = 1e-4: K d^1.5 = 1 N, slope 15000 N/m, energy 1e-4 / 2.5 = 4e-5 J.
TEST(NormalLaw, HystereticByHand) {
    const auto value = [](const std::string& kind, double e, const Indentation& c) {
        return compile_law(hysteretic(kind, 1e6, e), {}).evaluate(c);
    };
    expect_force(value("hertz", 1, {1e-4, 0.1, 0.2}), 1, 15000, 0, 4e-5);
    // rho = 1/2: chi = 9/16, 3/4, 8/5
    expect_force(value("lankarani-nikravesh", 0.5, {1e-4, 0.1, 0.2}), 1.28125, 19218.75, 2.8125, 4e-5);
    expect_force(value("hunt-crossley", 0.5, {1e-4, 0.1, 0.2}), 1.375, 20625, 3.75, 4e-5);
    expect_force(value("flores", 0.5, {1e-4, 0.1, 0.2}), 1.8, 27000, 8, 4e-5);
    // leaving: less than the elastic force; faster than 1/chi times the start: nothing
    expect_force(value("flores", 0.5, {1e-4, -0.1, 0.2}), 0.2, 3000, 8, 4e-5);
    expect_force(value("flores", 0.5, {1e-4, -0.2, 0.2}), 0, 0, 0, 4e-5);
    // faster than at the start: capped
    expect_force(value("flores", 0.5, {1e-4, 0.3, 0.2}), 2.6, 39000, 0, 4e-5);
    // no starting speed to speak of: elastic with 1 + chi, both ways, and it stores that
    for (const double rate : {0.3, -0.3}) {
        const NormalForce f = value("flores", 0.5, {1e-4, rate, 0.99e-9});
        expect_force(f, 2.6, 39000, 0, 2.6 * 4e-5);
        EXPECT_EQ(f.force, f.elastic);
    }
    // not known yet
    expect_force(value("flores", 0.5, {1e-4, 0.3, -1}), 2.6, 39000, 0, 4e-5);
    expect_force(value("flores", 0.5, {1e-4, -0.3, -1}), 1, 15000, 0, 4e-5);
}

TEST(NormalLaw, KelvinVoigtByHand) {
    const NormalLaw law = compile_law(kelvin_voigt(), {}); // K = 1e5, e = 0.3, v0 = 0.1
    expect_force(law.evaluate({1e-3, 0.1, 1}), 100, 1e5, 0, 0.015);
    expect_force(law.evaluate({1e-3, -1, 1}), 30, 3e4, 0, 0.015);
    expect_force(law.evaluate({1e-3, 0, 1}), 30, 3e4, 0, 0.015);
    // r = 1/4: 3/16 - 2/64 = 5/32; derivative 6 r (1 - r) = 9/8
    expect_force(law.evaluate({1e-3, 0.025, 1}), 100 * (0.3 + 0.7 * 5 / 32), 1e5 * (0.3 + 0.7 * 5 / 32),
                 100 * 0.7 * 9 / 8 / 0.1, 0.015);
}

TEST(NormalLaw, LinearAndTabulatedByHand) {
    const NormalLaw law = compile_law(linear(1e5, 40), {});
    expect_force(law.evaluate({1e-3, 0.5, 1}), 120, 1e5, 40, 0.05);
    expect_force(law.evaluate({1e-3, -2, 1}), 20, 1e5, 40, 0.05);
    expect_force(law.evaluate({1e-3, -3, 1}), 0, 0, 0, 0.05);
    ContactLaw line = named("tabulated"); // two points: a line with the slope 2e4
    line.table = {{0, 1e-3}, {0, 20}};
    line.damping = 3;
    expect_force(compile_law(line, {}).evaluate({2e-3, 1, 1}), 43, 2e4, 3, 0.04);
}

// T = 1 mm, W = 0.3 mm, bushing 1e4 d + 20 d', hard 5e4 s (Kelvin-Voigt with e = 1).
TEST(NormalLaw, BlendByHand) {
    ContactLaw hard = named("kelvin-voigt");
    hard.stiffness = 5e4;
    hard.restitution = 1;
    hard.speed = 1;
    const NormalLaw sum = compile_law(blend(hard, false), {}), smooth = compile_law(blend(hard, true), {});
    EXPECT_EQ(sum.slots(), 2);
    EXPECT_EQ(sum.inner_offset(), 1e-3);
    expect_force(at(sum, {0.5e-3, 0.1, 1, 1}), 7, 1e4, 20, 1.25e-3);
    // x = 1/3: weights 1/3 and 7/27; 13 N of the bushing, 5 N of the hard part; dw/ds = 1/W, 6 x (1 - x) / W
    const double w = 7.0 / 27, slope = 4.0 / 3 / 3e-4;
    expect_force(at(sum, {1.1e-3, 0.1, 1, 1}), 26.0 / 3 + 5.0 / 3, 2e4 / 3 + 5e4 / 3 - 8 / 3e-4, 40.0 / 3,
                 at(sum, {1.1e-3, 0, 1, 1}).energy);
    expect_force(at(smooth, {1.1e-3, 0.1, 1, 1}), (1 - w) * 13 + w * 5, (1 - w) * 1e4 + w * 5e4 - 8 * slope,
                 (1 - w) * 20, at(smooth, {1.1e-3, 0, 1, 1}).energy);
    // Beyond: 5e4 s alone. Stored by the sum: T^2/2 1e4 = 5e-3, ramp 1e4 (T W/2 + W^2/6) + 5e4 W^2/3, then
    // 5e4 s ds
    expect_force(at(sum, {1.4e-3, 0.1, 1, 1}), 20, 5e4, 0,
                 5e-3 + 1e4 * (1.5e-7 + 1.5e-8) + 5e4 * 3e-8 + 2.5e4 * (16e-8 - 9e-8));
}

TEST(NormalLaw, PartsOfABlendKeepTheirOwnStart) {
    const NormalLaw law = compile_law(blend(hysteretic("flores", 1e9, 0.5), true), {});
    const NormalLaw hard = compile_law(hysteretic("flores", 1e9, 0.5), {});
    EXPECT_EQ(at(law, {2e-3, 0.1, 5, 0.2}).force, hard.evaluate({1e-3, 0.1, 0.2}).force);
    EXPECT_NE(at(law, {2e-3, 0.1, 5, 0.2}).force, at(law, {2e-3, 0.1, 5, 0.15}).force);
    EXPECT_EQ(law.evaluate({2e-3, 0.1, 0.3}).force, at(law, {2e-3, 0.1, 0.3, 0.3}).force);
}

TEST(NormalLaw, DepthsOfForceAndEnergy) {
    for (const Case& c : all_laws()) {
        SCOPED_TRACE(c.name);
        const NormalLaw law = compile_law(c.law, journal);
        EXPECT_EQ(law.depth_of_energy(0), 0);
        EXPECT_EQ(law.depth_of_force(-1), 0);
        for (const double energy : {1e-12, 1e-5, 3e-3, 7.0}) {
            const double depth = law.depth_of_energy(energy);
            const bool kelvin = c.law.kind == "kelvin-voigt"; // its compression, not what it stores
            if (kelvin || (!c.law.hard.empty() && c.law.hard[0].kind == "kelvin-voigt" && depth > 1e-3))
                continue;
            EXPECT_NEAR(at(law, {depth, 0, 1, 1}).energy, energy, 1e-12 * energy);
        }
        const double depth = law.depth_of_force(2.5);
        const double rate = c.law.damping ? 0 : 1e-200;
        EXPECT_NEAR(at(law, {depth, rate, 1, 1}).force, c.law.kind == "kelvin-voigt" ? 0.75 : 2.5, 1e-12);
    }
    const NormalLaw kelvin = compile_law(kelvin_voigt(), {});
    EXPECT_NEAR(kelvin.depth_of_energy(0.05), 1e-3, 1e-15);
    EXPECT_NEAR(kelvin.depth_of_force(100), 1e-3, 1e-15);
    ContactLaw flat = named("tabulated");
    flat.table = {{0, 1e-3, 2e-3, 3e-3}, {0, 20, 20, 20}};
    EXPECT_EQ(compile_law(flat, {}).depth_of_force(21), std::numeric_limits<double>::infinity());
}

TEST(NormalLaw, TakesNoMemoryAndKnowsItsShare) {
    if (!GUDGEON_COUNTS_ALLOCATIONS)
        GTEST_SKIP() << "allocations are not counted in this build";
    for (const Case& c : all_laws()) {
        SCOPED_TRACE(c.name);
        const NormalLaw law = compile_law(c.law, journal);
        double sum = 0;
        EXPECT_EQ(test::count_allocations([&] {
                      for (const double depth : {1e-4, 1.1e-3, 2e-3})
                          sum += at(law, {depth, 0.1, 0.2, 0.2}).force;
                  }),
                  0);
        EXPECT_GT(sum, 0);
        const NormalForce whole = at(law, {1e-4, 0.1, 0.2, 0.2}), part = 0.125 * whole;
        EXPECT_EQ(part.force, whole.force / 8);
        EXPECT_EQ(part.by_depth, whole.by_depth / 8);
        EXPECT_EQ(part.by_rate, whole.by_rate / 8);
        EXPECT_EQ(part.elastic, whole.elastic / 8);
        EXPECT_EQ(part.energy, whole.energy / 8);
    }
}

// --- refusals ---

void expect_refused(const ContactLaw& law, const ContactGeometry& g, const std::string& member,
                    const std::string& word) {
    const auto problem = refusal(law, &g);
    ASSERT_TRUE(problem) << member;
    EXPECT_EQ(problem->member, member);
    EXPECT_NE(problem->problem.find(word), std::string::npos) << problem->problem;
    EXPECT_FALSE(problem->allowed.empty());
    EXPECT_THROW(compile_law(law, g), LawError);
}

TEST(NormalLawRefusal, CylinderOutsideItsClearances) {
    ContactLaw law = hysteretic("cylinder", 1e9, 0.9);
    expect_refused(law, {0.01, 0.01, 0.02, 0.004e-3, false}, "/kind", "0.004 mm");
    expect_refused(law, {0.021, 0.01, 0.02, 11e-3, false}, "/kind", "11 mm");
    expect_refused(law, {0.01, 0.01, 0.02, 0, false}, "/kind", "clearance");
    expect_refused(law, {0.01, 0.01, 0.02, 1e-4, true}, "/kind", "rotation");
    law.stiffness.reset();
    law.materials = {{{207e9, 0.3}, {207e9, 0.3}}};
    expect_refused(law, {0.011, 0.01, 0, 1e-3, false}, "/stiffness", "length");
    for (const double clearance : {0.005e-3, 10e-3}) {
        const ContactGeometry g{0.02, 0.02 - clearance, 0.02, clearance, false};
        EXPECT_FALSE(refusal(law, &g));
    }
}

TEST(NormalLawRefusal, Members) {
    expect_refused(named("herz"), {}, "/kind", "herz");
    expect_refused(named("hertz"), {}, "/stiffness", "neither");
    expect_refused(hysteretic("flores", 1e6, 0), {}, "/restitution", "0");
    expect_refused(hysteretic("flores", 1e6, 1.1), {}, "/restitution", "1.1");
    expect_refused(hysteretic("flores", -1, 0.5), {}, "/stiffness", "-1");
    expect_refused(hysteretic("flores", std::nan(""), 0.5), {}, "/stiffness", "nan");
    expect_refused(hysteretic("kelvin-voigt", 1e6, 0.5), {}, "/speed", "needs");
    expect_refused(hysteretic("linear", 1e6, 0.5), {}, "/restitution", "no restitution");
    EXPECT_EQ(refusal(hysteretic("linear", 1e6, 0.5))->allowed, "stiffness, damping");
    expect_refused(named("tabulated"), {}, "/table", "needs");
    ContactLaw law = hysteretic("hertz", 1e6, 1);
    law.exponent = 0.9;
    expect_refused(law, {}, "/exponent", "0.9");
    law = linear(1, -1);
    expect_refused(law, {}, "/damping", "-1");
    law = tabulated();
    law.table.y[2] = 10;
    expect_refused(law, {}, "/table/y/2", "10 after 20");
    law.table = {{1e-3, 2e-3}, {0, 1}};
    expect_refused(law, {}, "/table/x/0", "starts");
    law.table = {{0, 0}, {0, 1}};
    expect_refused(law, {}, "/table/x/1", "0 after 0");
    law.table = {{0, 1}, {0, 0}};
    expect_refused(law, {}, "/table/y", "no force");
}

TEST(NormalLawRefusal, MaterialsAndGeometry) {
    ContactLaw law = named("hertz");
    law.materials = {{{207e9, 0.3}, {0, 0.3}}};
    expect_refused(law, journal, "/materials/1/young", "0 Pa");
    law.materials = {{{207e9, 0.6}, {207e9, 0.3}}};
    expect_refused(law, journal, "/materials/0/poisson", "0.6");
    law.materials = {{{207e9, 0.3}, {207e9, 0.3}}};
    EXPECT_FALSE(refusal(law));
    EXPECT_FALSE(refusal(law, &journal));
    expect_refused(law, {}, "/stiffness", "round");
    expect_refused(law, {0.01, 0.01, 0, 0, false}, "/stiffness", "clearance");
    expect_refused(law, {0.011, 0.01, 0, 1e-3, true}, "/stiffness", "rotation");
    law.exponent = 1.4;
    expect_refused(law, journal, "/exponent", "materials");
}

TEST(NormalLawRefusal, Blends) {
    ContactLaw law = blend(hysteretic("flores", 1e6, 2), true);
    expect_refused(law, {}, "/hard/restitution", "2");
    law.width = 0;
    expect_refused(law, {}, "/width", "0");
    law = blend(blend(tabulated(), true), true);
    expect_refused(law, {}, "/hard", "no blend");
    law = blend(tabulated(), true);
    law.stiffness.reset();
    expect_refused(law, {}, "/stiffness", "neither");
    law.hard.clear();
    expect_refused(law, {}, "/hard", "needs");
    law = blend(hysteretic("cylinder", 1e6, 0.5), true); // the hard surfaces are thickness further apart
    expect_refused(law, {0.0195, 0.01, 0, 9.5e-3, false}, "/hard/kind", "10.5 mm");
}

TEST(NormalLawRefusal, TheListIsWhatCompiles) {
    std::vector<std::string> names;
    for (const NormalLawInfo& k : normal_law_kinds()) {
        names.emplace_back(k.name);
        EXPECT_FALSE(k.summary.empty());
    }
    EXPECT_EQ(names, (std::vector<std::string>{"hertz", "lankarani-nikravesh", "cylinder", "hunt-crossley",
                                               "flores", "kelvin-voigt", "linear", "tabulated", "blend"}));
}

} // namespace
} // namespace gudgeon

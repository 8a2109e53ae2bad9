// Normal laws against what is known of them: restitution that comes out of free impacts, stiffness from
// materials and geometry, an elastic cylinder in a cylindrical hole.
#include "contact/normal_law.hpp"

#include "tests/solvers/reference_table.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

namespace gudgeon {
namespace {

struct Impact {
    double restitution = 0;
    double depth = 0;      // m, the greatest
    double dissipated = 0; // J, integral of (force - elastic) rate
};

// Free flight of a mass into the law and out again: classical Runge-Kutta over (depth, rate, dissipated).
Impact impact(const NormalLaw& law, double mass, double speed) {
    struct State {
        double depth, rate, lost;
    };
    const auto rates = [&](const State& s) -> State {
        const NormalForce f = law.evaluate({s.depth, s.rate, speed});
        return {s.rate, -f.force / mass, s.depth > 0 ? (f.force - f.elastic) * s.rate : 0};
    };
    const auto add = [](const State& s, const State& d, double h) -> State {
        return {s.depth + h * d.depth, s.rate + h * d.rate, s.lost + h * d.lost};
    };
    const auto step = [&](const State& s, double h) -> State {
        const State k1 = rates(s), k2 = rates(add(s, k1, h / 2)), k3 = rates(add(s, k2, h / 2));
        const State k4 = rates(add(s, k3, h));
        return add(add(add(add(s, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
    };
    const double h = law.depth_of_energy(mass * speed * speed / 2) / speed / 5000;
    Impact out;
    State s{0, speed, 0};
    for (int i = 0; i < 1000000; ++i) {
        const State next = step(s, h);
        // vertex of the parabola through the two last states
        if (s.rate > 0 && next.rate <= 0)
            out.depth = s.depth + 0.5 * s.rate * h * s.rate / (s.rate - next.rate);
        if (next.depth <= 0) {
            double low = 0, high = h;
            for (int k = 0; k < 60; ++k) {
                const double middle = (low + high) / 2;
                (step(s, middle).depth > 0 ? low : high) = middle;
            }
            const State end = step(s, low);
            out.restitution = -end.rate / speed;
            out.dissipated = end.lost;
            return out;
        }
        s = next;
    }
    ADD_FAILURE() << "the contact never ends";
    return out;
}

NormalLaw law_of(const std::string& kind, double stiffness, double restitution, double exponent = 1.5) {
    ContactLaw law;
    law.kind = kind;
    law.stiffness = stiffness;
    law.restitution = restitution;
    law.exponent = exponent;
    return compile_law(law, {});
}

struct InOut {
    double in, out;
};

void expect_restitution(const std::string& kind, std::initializer_list<InOut> facts) {
    struct Scene {
        double mass, stiffness, exponent, speed;
    };
    for (const auto& [in, out] : facts)
        for (const Scene& s : {Scene{1, 5e6, 1.5, 0.14}, Scene{0.02, 1e11, 1.5, 30},
                               Scene{300, 1e4, 1.1, 1e-4}, Scene{1, 1e8, 2, 2}}) {
            const Impact x = impact(law_of(kind, s.stiffness, in, s.exponent), s.mass, s.speed);
            EXPECT_NEAR(x.restitution, out, 1e-3) << kind << ' ' << in;
            const double energy = 0.5 * s.mass * s.speed * s.speed;
            EXPECT_NEAR(x.dissipated / energy, 1 - x.restitution * x.restitution, 1e-6);
        }
}

TEST(NormalLawFacts, RestitutionThatComesOut) {
    expect_restitution("lankarani-nikravesh", {{0.9, 0.913}, {0.5, 0.725}, {0.3, 0.684}});
    expect_restitution("flores", {{0.9, 0.894}, {0.5, 0.470}, {0.3, 0.256}});
    expect_restitution("lankarani-nikravesh", {{1, 1}});
    expect_restitution("flores", {{1, 1}});
}

TEST(NormalLawFacts, LankaraniNikraveshAgainstTheClosedForm) {
    const testing_data::ReferenceTable table("r4_restitution.csv");
    const auto& in = table["e_nominal"];
    ASSERT_EQ(in.size(), 9u);
    for (std::size_t i = 0; i < in.size(); ++i)
        EXPECT_NEAR(impact(law_of("lankarani-nikravesh", 5e6, in[i]), 1, 0.14).restitution,
                    table["e_effective"][i], 1e-6);
}

// G(u) = u/chi - ln(1 + chi u)/chi^2, G(-r) = G(1), for any chi.
TEST(NormalLawFacts, HuntCrossleyAgainstTheClosedForm) {
    for (const double in : {0.3, 0.5, 0.8}) {
        const double chi = 1.5 * (1 - in);
        const double r = impact(law_of("hunt-crossley", 5e6, in), 1, 0.14).restitution;
        EXPECT_NEAR(-chi * r - std::log(1 - chi * r), chi - std::log(1 + chi), 1e-6);
    }
}

// Fast approach: K d in, K d e out, so the speeds are as sqrt(e).
TEST(NormalLawFacts, KelvinVoigtGivesTheRootOfItsRestitution) {
    ContactLaw law;
    law.kind = "kelvin-voigt";
    law.stiffness = 1e5;
    law.restitution = 0.25;
    law.speed = 1e-4;
    EXPECT_NEAR(impact(compile_law(law, {}), 1, 1).restitution, 0.5, 1e-3);
}

TEST(NormalLawFacts, LinearDamperAsAnOscillator) {
    // Leaves where the force vanishes, before the depth does: with zeta = c / (2 sqrt(K m)) and
    // tan(angle) = 2 zeta sqrt(1 - zeta^2) / (1 - 2 zeta^2), e = exp(-zeta (pi - angle) / sqrt(1 - zeta^2)).
    ContactLaw law;
    law.kind = "linear";
    law.stiffness = 1e4;
    law.damping = 40; // m = 1: zeta = 0.2
    const double zeta = 0.2, root = std::sqrt(1 - zeta * zeta);
    const double angle = std::atan2(2 * zeta * root, 1 - 2 * zeta * zeta);
    EXPECT_NEAR(impact(compile_law(law, {}), 1, 0.5).restitution,
                std::exp(-zeta / root * (std::numbers::pi - angle)), 1e-5);
}

// A 1 kg journal falling through 1 mm: closed forms of the greatest depth and the restitution.
TEST(NormalLawFacts, GreatestDepthOfAnImpact) {
    const double speed = std::sqrt(2 * 9.81 * 1e-3);
    const Impact ln = impact(law_of("lankarani-nikravesh", 5e6, 0.75), 1, speed);
    EXPECT_NEAR(ln.depth, 0.000439157530872034, 1e-9);
    EXPECT_NEAR(ln.restitution, 0.819933801467916, 1e-7);
    const Impact cylinder = impact(law_of("lankarani-nikravesh", 7605870936.725915, 0.75, 1.1661), 1, speed);
    EXPECT_NEAR(cylinder.depth, 4.23897790364138e-6, 1e-11);
    EXPECT_NEAR(cylinder.restitution, 0.819933801467916, 1e-7);
}

ContactLaw steel(const std::string& kind) {
    ContactLaw law;
    law.kind = kind;
    law.materials = {{{207e9, 0.3}, {207e9, 0.3}}};
    return law;
}

TEST(NormalLawFacts, CylinderInNewtonAndMetre) {
    const NormalLaw law = compile_law(steel("cylinder"), {0.011, 0.01, 0.02, 1e-3, false});
    const double one_metre = law.evaluate({1, 0, 1}).force; // K
    EXPECT_NEAR(one_metre, 7605870936.725915, 1e-5);
    EXPECT_NEAR(law.evaluate({1, 0, 1}).by_depth / one_metre, 1.1661, 1e-15);
    EXPECT_NEAR(law.evaluate({1e-3, 0, 1}).force, 2414620.879120879, 1e-8);
    // 0.1 mm: Y = 1.51 ln(100)^-0.151, n = Y 0.1^-0.005
    EXPECT_NEAR(Cylinder::exponent_of(1e-4), 1.51 * std::pow(std::log(100), -0.151) * std::pow(0.1, -0.005),
                1e-15);
    EXPECT_NEAR(Cylinder::exponent_of(0.3495399e-3), Cylinder::exponent_of(0.3495401e-3), 1e-5);
}

TEST(NormalLawFacts, SocketStiffness) {
    // E* = 2e11 / (2 * 0.91), sqrt(0.02 * 0.0199 / 1e-4) = 1.99499373...
    ContactLaw law = steel("lankarani-nikravesh");
    law.materials = {{{2e11, 0.3}, {2e11, 0.3}}};
    const ContactGeometry g{0.02, 0.0199, 0, 1e-4, false};
    const double k = 4.0 / 3 * 1.0989010989010989e11 * 1.9949937343260002;
    for (const char* kind : {"hertz", "lankarani-nikravesh", "hunt-crossley", "flores"}) {
        law.kind = kind;
        EXPECT_NEAR(compile_law(law, g).evaluate({1e-4, 0, 1}).force, k * 1e-6, 1e-9 * k * 1e-6) << kind;
    }
    // Different materials: 1/E* = 0.91/2e11 + 0.75/1e10
    law.materials = {{{2e11, 0.3}, {1e10, 0.5}}};
    EXPECT_NEAR(compile_law(law, g).evaluate({1e-4, 0, 1}).force,
                4.0 / 3 / (0.91 / 2e11 + 0.75 / 1e10) * 1.9949937343260002 * 1e-6, 1e-3);
}

// Johnson, Contact Mechanics, internal cylinder: delta = F/(pi E* L) (ln(4 pi E* dR L / F) - 1).
TEST(NormalLawFacts, CylinderAgainstJohnson) {
    const double modulus = 207e9 / (2 * (1 - 0.09)), length = 0.01;
    for (double clearance = 1e-5; clearance <= 1.001e-3; clearance *= std::pow(10, 1.0 / 16)) {
        const NormalLaw law =
            compile_law(steel("cylinder"), {0.02, 0.02 - clearance, length, clearance, false});
        for (double force = 100; force <= 5001; force *= std::pow(50, 1.0 / 16)) {
            const double johnson =
                force / (std::numbers::pi * modulus * length) *
                (std::log(4 * std::numbers::pi * modulus * clearance * length / force) - 1);
            EXPECT_NEAR(law.depth_of_force(force) / johnson, 1, 0.15) << clearance << ' ' << force;
        }
    }
}

} // namespace
} // namespace gudgeon

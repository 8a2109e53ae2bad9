// Runs against reference solutions that share nothing with the integrators (minimal coordinates, closed
// forms), with the error that each integrator may leave.
#pragma once

#include "core/channels.hpp"
#include "solvers/simulation.hpp"
#include "tests/solvers/reference_table.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

namespace gudgeon::test {

struct Pairing {
    std::string channel, column;
    double gear, radau; // bounds of the error over promised(): how much the mechanism blows up an error
};

struct Reference {
    std::string name, mechanism;
    std::map<std::string, std::string> parameters;
    std::string file;
    double end;
    std::vector<Pairing> pairs;
    double gear_energy, radau_energy; // the same of the energy balance, J
    double file_error = 0;            // of the reference itself
};

inline void PrintTo(const Reference& r, std::ostream* out) { *out << r.name; }

struct Errors {
    std::vector<double> largest;
    double balance = 0, phi = 0, rate = 0;
};

inline Errors run(const Reference& ref, const SimulationOptions& options) {
    const testing_data::ReferenceTable table(ref.file);
    Simulation sim(build_mechanism(ref.mechanism, ref.parameters), options);
    std::vector<Channels> channels;
    for (const Pairing& pair : ref.pairs)
        channels.emplace_back(sim.system(), std::vector<std::string>{pair.channel});
    Errors errors{std::vector<double>(ref.pairs.size(), 0), 0, 0, 0};
    Workspace ws = make_workspace(sim.system());
    for (std::size_t i = 0; i < table.rows() && table["t"][i] <= ref.end; ++i) {
        const double t = table["t"][i];
        if (t > 0) {
            const StepOutcome outcome = sim.advance_past(t, ref.end);
            EXPECT_TRUE(outcome.ok) << outcome.message;
        }
        const Sample& sample = sim.sample_at(t);
        for (std::size_t k = 0; k < channels.size(); ++k) {
            double value = 0;
            channels[k].read(sample, {&value, 1});
            errors.largest[k] = std::max(errors.largest[k], std::abs(value - table[ref.pairs[k].column][i]));
        }
        errors.balance = std::max(errors.balance, std::abs(sample.balance));
        ws.angles = sample.state.angles;
        set_motion(sim.system(), sample.state.q, sample.state.u, ws);
        evaluate_constraints(sim.system(), t, nullptr, false, ws);
        errors.phi = std::max(errors.phi, ws.phi.cwiseAbs().maxCoeff());
        errors.rate = std::max(errors.rate, ws.rate.cwiseAbs().maxCoeff());
    }
    if (options.integrator != "rk4") { // Baumgarte's terms keep them less well
        EXPECT_LT(sim.statistics().constraint_position_max, 1e-10);
        EXPECT_LT(sim.statistics().constraint_velocity_max, 1e-10);
    }
    return errors;
}

inline Errors run(const Reference& ref, const std::string& integrator, double tol,
                  Formulation formulation = Formulation::saddle_point) {
    SimulationOptions options;
    options.integrator = integrator;
    options.integration.formulation = formulation;
    options.integration.rtol = options.integration.atol = tol;
    return run(ref, options);
}

inline std::vector<Reference> references() {
    const std::map<std::string, std::string> four{{"links", "4"}, {"thin", "1"}},
        sixteen{{"links", "16"}, {"thin", "1"}};
    return {
        {"SliderCrankFirstTurn",
         "slider-crank",
         {},
         "r1_slider_crank_ideal.csv",
         0.5,
         {{"slider.x", "x", 1, 0.02},
          {"slider.vx", "xd", 50, 1.5},
          {"slider.ax", "xdd", 2e3, 60},
          {"crank.wx", "thetad", 800, 40},
          {"crank.alx", "thetadd", 6e4, 800},
          {"A.angle", "theta", 50, 0.6},
          {"B.fx", "FBx", 4500, 150},
          {"B.fy", "FBy", 4500, 50},
          {"B.fz", "FBz", 4500, 50},
          {"C.fx", "FCx", 4500, 150},
          {"C.fy", "FCy", 4500, 40},
          {"C.fz", "FCz", 4500, 50}},
         12,
         1.5},
        {"SliderCrank",
         "slider-crank",
         {},
         "r1_slider_crank_ideal.csv",
         5,
         {{"slider.x", "x", 400, 5},
          {"rod.e0", "e0", 300, 3},
          {"rod.e1", "e1", 500, 5},
          {"rod.e2", "e2", 1500, 15},
          {"rod.e3", "e3", 2500, 30}},
         100,
         2},
        {"HeavyTop",
         "heavy-top",
         {},
         "r7_slow_top_b.csv",
         2,
         {{"top.x", "cx", 30, 3},
          {"top.y", "cy", 20, 1.5},
          {"top.z", "cz", 40, 3},
          {"top.e0", "e0", 70, 6},
          {"top.e1", "e1", 50, 4},
          {"top.e2", "e2", 50, 4},
          {"top.e3", "e3", 60, 5}},
         120,
         15},
        {"ChainOfFour",
         "chain",
         four,
         "r5_chain_N4.csv",
         1,
         {{"tip.x", "tip_x", 4, 0.15},
          {"tip.z", "tip_z", 4, 0.2},
          {"link4.wy", "omega_N", 80, 10},
          {"link1.wy", "omega_1", 40, 3}},
         200,
         40},
        {"ChainOfSixteen",
         "chain",
         sixteen,
         "r5_chain_N16.csv",
         1,
         {{"tip.x", "tip_x", 2, 0.08}, {"tip.z", "tip_z", 4, 0.0008}, {"link1.wy", "omega_1", 25, 1.5}},
         600,
         20},
        // until the first stop is reached, at 0.329 s
        {"TriplePendulum",
         "triple-pendulum",
         {},
         "r3_Z_LN.csv",
         0.329,
         {{"J1.angle", "q1", 2, 0.3},
          {"J2.slide", "s", 2, 0.1},
          {"J2.angle", "phi", 1, 0.15},
          {"J3.angle", "psi", 2, 0.5}},
         3,
         0.2},
        {"SuspensionChainOfOne",
         "suspension-chain",
         {},
         "suspension_chain_N1.csv",
         5,
         {{"chassis0.z", "chassis0.z", 1, 0.03}},
         1e4,
         100,
         1e-8},
        {"SuspensionChainOfFour",
         "suspension-chain",
         {{"units", "4"}},
         "suspension_chain_N4.csv",
         5,
         {{"chassis0.z", "chassis0.z", 1, 0.03},
          {"chassis1.z", "chassis1.z", 1, 0.03},
          {"chassis2.z", "chassis2.z", 1, 0.03},
          {"chassis3.z", "chassis3.z", 1, 0.03}},
         2e4,
         150,
         1e-8},
    };
}

/// Runs at 1e-4, 1e-6 and 1e-8. share: of the errors allowed.
inline void expect_agreement(const Reference& ref, const std::string& integrator,
                             Formulation formulation = Formulation::saddle_point, double share = 1) {
    const bool gear = integrator == "gear";
    Errors before;
    for (const double tol : {1e-4, 1e-6, 1e-8}) {
        SCOPED_TRACE(testing::Message() << "tolerance " << tol);
        const Errors errors = run(ref, integrator, tol, formulation);
        // gear: an error per step of tol at order 5; radau: held for a formula of order 3
        const double promised = gear ? std::pow(tol, 5.0 / 6) : tol;
        const double fall = 8;
        for (std::size_t k = 0; k < ref.pairs.size(); ++k) {
            const Pairing& pair = ref.pairs[k];
            const double bound = share * (gear ? pair.gear : pair.radau) * promised;
            EXPECT_LT(errors.largest[k], bound + ref.file_error) << pair.channel;
            if (!before.largest.empty()) {
                EXPECT_LT(errors.largest[k], before.largest[k] / fall + ref.file_error) << pair.channel;
            }
        }
        EXPECT_LT(errors.balance, share * (gear ? ref.gear_energy : ref.radau_energy) * promised);
        if (before.balance > 0) {
            EXPECT_LT(errors.balance, before.balance / fall);
        }
        EXPECT_LT(errors.phi, 1e-12);
        EXPECT_LT(errors.rate, 1e-12);
        before = errors;
    }
}

} // namespace gudgeon::test

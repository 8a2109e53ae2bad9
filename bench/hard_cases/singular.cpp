// Singular positions: rows that are independent elsewhere repeat each other for an instant, and branches of
// the motion cross. What goes through must stay on the branch it came by.
#include "bench/hard_cases/bricard.hpp"
#include "bench/hard_cases/cases.hpp"
#include "bench/hard_cases/singular_models.hpp"
#include "bench/hard_cases/truths.hpp"

#include <fmt/format.h>

namespace gudgeon::hard {

namespace {

constexpr double g = 9.81;

// Flat some 20 times in 20 s. Upright, with 1 rad/s, the cranks turn slowest: every pass there blows errors
// up by their largest rate over the smallest, and what is left is a lag that grows with the turns.
void chain_of_loops(Trial& trial, int loops, double end) {
    const Circulation truth{crank_pull(loops), 1};
    double off = 0;
    trial.run(build_mechanism("four-bar", {{"loops", std::to_string(loops)}}), 1e-7, {end, 0.05},
              [&](const Simulation& sim, const Sample& sample) {
                  const Circulation::Now a = truth.at(sample.state.t);
                  const Vec3 arm(a.sine, 0, a.cosine);
                  for (int k = 0; k <= loops; ++k) {
                      const int crank = sim.system().body_index(fmt::format("crank{}", k));
                      off = std::max(off, 2 * (sample.motion[crank].r - Vec3(k, 0, 0) - arm / 2).norm());
                  }
              });
    trial.hold("off the exact branch, m", off, 1e-3);
}

/// A circulating motion of one coordinate: (J(x)/2) x'^2 + V(x) = E, x' > 0, by the classical Runge-Kutta
/// rule.
template <class Inertia, class Potential> class OneWay {
  public:
    OneWay(double x, double rate, Inertia inertia, Potential potential)
        : x_(x), inertia_(inertia), potential_(potential),
          energy_(inertia(x) * rate * rate / 2 + potential(x)) {}
    double rate(double x) const { return std::sqrt(2 * (energy_ - potential_(x)) / inertia_(x)); }
    /// Times must not decrease.
    double at(double t) {
        const int n = static_cast<int>(std::ceil((t - t_) / 1e-3));
        const double h = n > 0 ? (t - t_) / n : 0;
        for (int i = 0; i < n; ++i) {
            const double a = rate(x_), b = rate(x_ + h / 2 * a), c = rate(x_ + h / 2 * b),
                         d = rate(x_ + h * c);
            x_ += h / 6 * (a + 2 * b + 2 * c + d);
        }
        t_ = t;
        return x_;
    }

  private:
    double x_, t_ = 0;
    Inertia inertia_;
    Potential potential_;
    double energy_;
};

// Folded, the slider's pin lies on the crank's axis, and crank and rod could go on turning about it together,
// the slider at rest. Faster and slower there than elsewhere by a factor of two at most: errors do not grow.
void equal_crank_and_rod(Trial& trial) {
    const double tolerance = 1e-7, angle = 0.5, rate = 4, end = 5;
    const auto inertia = [](double f) {
        const double c = std::cos(f), s = std::sin(f);
        return 0.25 + 1.0 / 12 + (2.25 * s * s + 0.25 * c * c + 1.0 / 12) + 4 * s * s;
    };
    const auto potential = [](double f) { return g * std::sin(f); };
    for (const bool in_space : {false, true}) {
        OneWay truth(angle, rate, inertia, potential);
        double off = 0, turns = 0;
        trial.run(equal_bars(angle, rate, in_space), tolerance, {end, 0.02},
                  [&](const Simulation&, const Sample& sample) {
                      const double f = truth.at(sample.state.t), c = std::cos(f), s = std::sin(f);
                      turns = f / (2 * pi);
                      off = std::max({off, (sample.motion[0].r - Vec3(c, 0, s) / 2).norm(),
                                      (sample.motion[1].r - Vec3(3 * c, 0, s) / 2).norm(),
                                      (sample.motion[2].r - Vec3(2 * c, 0, 0)).norm()});
                  });
        // an error of the rate goes on: it grows with the time itself
        trial.hold(in_space ? "in space, m" : "in the plane, m", off, allowance(tolerance, turns, 2, turns));
    }
}

// Twice in each turn the axes of the cross are those of the shafts: the second shaft is held by nothing but
// its way there, though gravity pulls at it; the first one turns on evenly.
void gimbal(Trial& trial) {
    const double tolerance = 1e-7, rate = 3, end = 6;
    double lag = 0, swung = 0;
    trial.run(square_shafts(0.5, rate), tolerance, {end, 0.05}, [&](const Simulation&, const Sample& sample) {
        const Mat3 turned =
            rotation(Vec4(std::cos(rate * sample.state.t / 2), std::sin(rate * sample.state.t / 2), 0, 0));
        lag = std::max(lag, (sample.motion[0].A - turned).norm());
        swung = std::max(swung, (sample.motion[1].A - Mat3::Identity()).norm());
    });
    const double turns = rate * end / (2 * pi);
    trial.hold("first shaft, rad", lag, allowance(tolerance, turns, 1));
    trial.hold("second shaft, rad", swung, 1e-9);
}

// All the way round its closed curve and again, whatever gravity does.
void bricard(Trial& trial) {
    const double tolerance = 1e-7, start = 0, rate = 6, end = 5;
    OneWay truth(
        start, rate, [](double psi) { return Bricard::inertia(psi); },
        [](double psi) { return g * Bricard::height(psi); });
    double off = 0, open = 0, turns = 0, wrong = 0;
    trial.run(Bricard::model(start, rate), tolerance, {end, 0.02},
              [&](const Simulation& sim, const Sample& sample) {
                  const double psi = truth.at(sample.state.t);
                  const Bricard::Pose exact = Bricard::pose(psi);
                  open = std::max(open, exact.open);
                  turns = psi / (2 * pi);
                  for (int i = 0; i < Bricard::bars; ++i)
                      off = std::max(off, (sample.motion[i].r - exact.bar[i].centre).norm());
                  wrong =
                      std::max(wrong, std::abs(static_cast<double>(sim.redundancy().dependent.size()) - 1) +
                                          std::abs(sim.redundancy().dof - 1.0));
              });
    trial.hold("repeated rows other than 1, freedoms other than 1", wrong, 0);
    trial.hold("the exact linkage, open by, m", open, 1e-12);
    trial.hold("off the exact motion, m", off, allowance(tolerance, turns, 2, turns));
    trial.hold("constraints, m, m/s",
               std::max(trial.work().constraint_position_max, trial.work().constraint_velocity_max), 1e-10);
}

} // namespace

std::vector<HardCase> singular_cases() {
    std::vector<HardCase> out;
    for (const auto& [loops, end, slow] : {std::tuple(2, 20.0, false), {10, 20.0, true}, {40, 20.0, true}})
        out.push_back(
            {fmt::format("FlatLoops{}", loops),
             fmt::format("{} parallelograms in a row for {} s, flat together some {} times", loops, end, end),
             [loops = loops, end = end](Trial& trial) { chain_of_loops(trial, loops, end); }, slow});
    out.push_back(
        {"EqualCrankAndRod", "a slider-crank that folds: crank as long as the rod", equal_crank_and_rod});
    out.push_back(
        {"Gimbal", "two shafts at a right angle: the axes of their cross fall into theirs", gimbal});
    out.back().indefinite =
        "next to the singular position the multipliers grow as one over the distance, and their part "
        "of the matrix makes it indefinite";
    out.push_back({"Bricard", "Bricard's six bars along a cube: no freedom by count, one in truth", bricard});
    return out;
}

} // namespace gudgeon::hard

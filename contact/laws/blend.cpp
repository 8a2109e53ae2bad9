#include "contact/laws/blend.hpp"

#include <array>
#include <span>
#include <utility>

namespace gudgeon {
namespace {

// Gauss-Legendre, four points: exact to degree 7. On a ramp: cubic table times cubic weight.
template <class F> double integrate_panel(F&& f, double a, double b) {
    constexpr std::array<double, 2> x{0.339981043584856264802665759103, 0.861136311594052575223946488893};
    constexpr std::array<double, 2> w{0.652145154862546142626936050778, 0.347854845137453857373063949222};
    const double middle = (a + b) / 2, half = (b - a) / 2;
    double sum = 0;
    for (std::size_t i = 0; i < 2; ++i)
        sum += w[i] * (f(middle - half * x[i]) + f(middle + half * x[i]));
    return half * sum;
}

template <class F> double integrate(F&& f, double a, double b, std::span<const double> knots) {
    double sum = 0;
    for (const double knot : knots) {
        if (knot <= a)
            continue;
        if (knot >= b)
            break;
        sum += integrate_panel(f, a, knot);
        a = knot;
    }
    return sum + integrate_panel(f, a, b);
}

CurveValue elastic_part(const Linear& law, double depth) { return PowerLaw{law.stiffness, 1}(depth); }
CurveValue elastic_part(const Tabulated& law, double depth) { return law.data->curve(depth); }

std::span<const double> knots_of(const Linear&) { return {}; }
std::span<const double> knots_of(const Tabulated& law) { return law.data->knots; }

double elastic_factor(const SingleLaw& law, double start_speed) {
    return std::visit(
        [start_speed](const auto& x) {
            if constexpr (requires { x.elastic_factor(start_speed); })
                return x.elastic_factor(start_speed);
            else
                return 1.0;
        },
        law);
}

} // namespace

Blend::Blend(Bushing bushing, SingleLaw hard, double thickness, double width, bool smooth)
    : bushing_(std::move(bushing)), hard_(std::move(hard)), thickness_(thickness), width_(width),
      smooth_(smooth) {
    bushing_thickness_ =
        std::visit([this](const auto& x) { return elastic_part(x, thickness_).integral; }, bushing_);
    bushing_energy_ = bushing_thickness_ + bushing_ramp_energy(width_);
    // A start well above the least speed: the elastic factor is 1.
    const NormalForce end = std::visit([this](const auto& x) { return x({width_, 0, 1}); }, hard_);
    hard_missing_ = end.energy - hard_ramp_energy(width_, end);
}

Blend::Weight Blend::weight(double s) const {
    const double x = s / width_;
    if (smooth_)
        return {x * x * (3 - 2 * x), 6 * x * (1 - x) / width_};
    return {x, 1 / width_};
}

double Blend::bushing_ramp_energy(double s) const {
    return std::visit(
        [this, s](const auto& law) {
            return integrate(
                [&](double d) { return (1 - weight(d - thickness_).value) * elastic_part(law, d).value; },
                thickness_, thickness_ + s, knots_of(law));
        },
        bushing_);
}

// For e = K s^n: int x s^n = s^(n+1) x / (n+2), int x^2 s^n = s^(n+1) x^2 / (n+3), ...
double Blend::hard_ramp_energy(double s, const NormalForce& hard) const {
    if (const auto* table = std::get_if<Tabulated>(&hard_))
        return integrate([&](double d) { return weight(d).value * elastic_part(*table, d).value; }, 0, s,
                         knots_of(*table));
    const double n = std::get<PowerLaw>(loading_of(hard_)).exponent;
    const double x = s / width_;
    return hard.elastic * s * (smooth_ ? x * x * (3 / (n + 3) - 2 * x / (n + 4)) : x / (n + 2));
}

NormalForce Blend::operator()(const Indentation& outer, const Indentation& inner) const {
    const double s = inner.depth;
    if (s >= width_) {
        NormalForce hard = std::visit([&](const auto& x) { return x(inner); }, hard_);
        hard.energy += bushing_energy_ - elastic_factor(hard_, inner.start_speed) * hard_missing_;
        return hard;
    }
    const NormalForce soft = std::visit([&](const auto& x) { return x(outer); }, bushing_);
    if (!(s > 0))
        return soft;
    const NormalForce hard = std::visit([&](const auto& x) { return x(inner); }, hard_);
    const auto [w, slope] = weight(s);
    return {(1 - w) * soft.force + w * hard.force,
            (1 - w) * soft.by_depth + w * hard.by_depth + slope * (hard.force - soft.force),
            (1 - w) * soft.by_rate + w * hard.by_rate, (1 - w) * soft.elastic + w * hard.elastic,
            bushing_thickness_ + bushing_ramp_energy(s) + hard_ramp_energy(s, hard)};
}

Blend Blend::loading() const {
    const Loading curve = loading_of(hard_);
    if (const auto* power = std::get_if<PowerLaw>(&curve))
        return {bushing_, Hertz(power->stiffness, power->exponent), thickness_, width_, smooth_};
    return *this;
}

} // namespace gudgeon

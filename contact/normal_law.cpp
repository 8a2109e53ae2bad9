#include "contact/normal_law.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace gudgeon {
namespace {

// --- the list ---

enum Member : unsigned {
    stiffness = 1,
    exponent = 2,
    restitution = 4,
    speed = 8,
    damping = 16,
    materials = 32,
    table = 64,
    blending = 128, // thickness, width, smooth (in files: blend), hard
};
constexpr unsigned elastic_members = stiffness | exponent | materials;
constexpr unsigned hysteretic_members = elastic_members | restitution;

double modulus(const std::array<Material, 2>& m) {
    return composite_modulus(m[0].young, m[0].poisson, m[1].young, m[1].poisson);
}

double socket_or_given(const ContactLaw& law, const ContactGeometry& g) {
    return law.stiffness ? *law.stiffness
                         : socket_stiffness(modulus(law.materials.value()), g.bearing_radius,
                                            g.journal_radius, g.clearance);
}

template <class Law> SingleLaw make_hysteretic(const ContactLaw& law, const ContactGeometry& g) {
    return Law(socket_or_given(law, g), law.exponent.value_or(1.5), law.restitution.value_or(1));
}

SingleLaw make_hertz(const ContactLaw& law, const ContactGeometry& g) {
    return Hertz(socket_or_given(law, g), law.exponent.value_or(1.5));
}

SingleLaw make_cylinder(const ContactLaw& law, const ContactGeometry& g) {
    const double n = law.exponent ? *law.exponent : Cylinder::exponent_of(g.clearance);
    const double k = law.stiffness
                         ? *law.stiffness
                         : Cylinder::stiffness_of(modulus(law.materials.value()), g.length, g.clearance);
    return Cylinder(k, n, law.restitution.value_or(1));
}

SingleLaw make_kelvin_voigt(const ContactLaw& law, const ContactGeometry&) {
    return KelvinVoigt{law.stiffness.value(), law.restitution.value(), law.speed.value()};
}

SingleLaw make_linear(const ContactLaw& law, const ContactGeometry&) {
    return Linear{law.stiffness.value(), law.damping.value_or(0)};
}

SingleLaw make_tabulated(const ContactLaw& law, const ContactGeometry&) {
    return Tabulated(law.table, law.damping.value_or(0));
}

constexpr std::array<NormalLawInfo, 9> kinds{{
    {"hertz", "K d^n, elastic; stiffness or materials", elastic_members, make_hertz},
    {"lankarani-nikravesh", "K d^n (1 + 3(1 - e^2)/4 d'/d'(-)); stiffness or materials, restitution",
     hysteretic_members, make_hysteretic<LankaraniNikravesh>},
    {"cylinder", "AP 44-48, clearance 0.005-10 mm; stiffness or materials and length, restitution",
     hysteretic_members, make_cylinder},
    {"hunt-crossley", "K d^n (1 + 3(1 - e)/2 d'/d'(-)); stiffness or materials, restitution",
     hysteretic_members, make_hysteretic<HuntCrossley>},
    {"flores", "K d^n (1 + 8(1 - e)/(5 e) d'/d'(-)); stiffness or materials, restitution", hysteretic_members,
     make_hysteretic<Flores>},
    {"kelvin-voigt", "K d in compression, K d e in restitution (AP 54); stiffness, restitution, speed",
     stiffness | restitution | speed, make_kelvin_voigt},
    {"linear", "K d + c d'; stiffness, damping", stiffness | damping, make_linear},
    {"tabulated", "table(d) + c d'; table, damping", table | damping, make_tabulated},
    {"blend",
     "linear or tabulated over a thickness, then over a width another law; stiffness or table, "
     "damping, thickness, width, hard",
     stiffness | damping | table | blending, nullptr},
}};

const NormalLawInfo* find_kind(std::string_view name) {
    const auto* it =
        std::find_if(kinds.begin(), kinds.end(), [name](const auto& k) { return k.name == name; });
    return it == kinds.end() ? nullptr : it;
}

// --- refusals ---

using Problem = std::optional<LawError>;

struct Given {
    std::string_view name;
    Member member;
    bool present;
};

std::array<Given, 11> given(const ContactLaw& law) {
    return {{{"stiffness", stiffness, law.stiffness.has_value()},
             {"exponent", exponent, law.exponent.has_value()},
             {"restitution", restitution, law.restitution.has_value()},
             {"speed", speed, law.speed.has_value()},
             {"damping", damping, law.damping.has_value()},
             {"materials", materials, law.materials.has_value()},
             {"table", table, !law.table.empty()},
             {"thickness", blending, law.thickness.has_value()},
             {"width", blending, law.width.has_value()},
             {"blend", blending, law.smooth},
             {"hard", blending, !law.hard.empty()}}};
}

Problem refuse_kind(const ContactLaw& law) {
    if (find_kind(law.kind))
        return std::nullopt;
    std::string names;
    for (const auto& k : kinds)
        names += (names.empty() ? "" : ", ") + std::string(k.name);
    return LawError("/kind", fmt::format("there is no normal law '{}'", law.kind), names);
}

Problem refuse_extra(const ContactLaw& law, unsigned takes) {
    std::string allowed;
    std::string_view extra;
    for (const Given& g : given(law)) {
        if (takes & g.member)
            allowed += (allowed.empty() ? "" : ", ") + std::string(g.name);
        else if (g.present && extra.empty())
            extra = g.name;
    }
    if (extra.empty())
        return std::nullopt;
    return LawError(fmt::format("/{}", extra), fmt::format("the law '{}' has no {}", law.kind, extra),
                    allowed);
}

Problem refuse_missing(const ContactLaw& law, std::initializer_list<std::string_view> needed) {
    for (const Given& g : given(law))
        if (!g.present && std::find(needed.begin(), needed.end(), g.name) != needed.end())
            return LawError(fmt::format("/{}", g.name),
                            fmt::format("the law '{}' needs its {}", law.kind, g.name), "give it");
    return std::nullopt;
}

Problem check(std::string_view name, const std::optional<double>& x, bool (*good)(double),
              std::string_view allowed) {
    if (!x || (std::isfinite(*x) && good(*x)))
        return std::nullopt;
    return LawError(fmt::format("/{}", name), fmt::format("a {} of {}", name, *x), std::string(allowed));
}

bool positive(double x) { return x > 0; }

Problem refuse_materials(const ContactLaw& law) {
    if (!law.materials)
        return std::nullopt;
    for (std::size_t i = 0; i < 2; ++i) {
        const Material& m = (*law.materials)[i];
        if (!(std::isfinite(m.young) && m.young > 0))
            return LawError(fmt::format("/materials/{}/young", i), fmt::format("a modulus of {} Pa", m.young),
                            "more than 0");
        if (!(m.poisson > -1 && m.poisson <= 0.5))
            return LawError(fmt::format("/materials/{}/poisson", i),
                            fmt::format("a Poisson ratio of {}", m.poisson), "more than -1, at most 0.5");
    }
    return std::nullopt;
}

Problem refuse_table(const ContactLaw& law) {
    const auto& [x, y] = law.table;
    if (law.table.empty())
        return std::nullopt;
    if (law.stiffness)
        return LawError("/stiffness", "a stiffness beside a table", "one of them");
    if (const auto p = find_problem(law.table))
        return LawError("/table" + p->where, p->problem, p->allowed);
    if (x[0] != 0 || y[0] != 0)
        return LawError(x[0] != 0 ? "/table/x/0" : "/table/y/0",
                        fmt::format("the table starts at ({}, {})", x[0], y[0]), "(0, 0)");
    for (std::size_t i = 1; i < y.size(); ++i)
        if (y[i] < y[i - 1])
            return LawError(fmt::format("/table/y/{}", i), fmt::format("{} after {}", y[i], y[i - 1]),
                            "a force that does not fall with the depth");
    if (y.back() == 0)
        return LawError("/table/y", "the table has no force", "more than 0 at its end");
    return std::nullopt;
}

Problem refuse_values(const ContactLaw& law) {
    constexpr std::string_view above_zero = "more than 0";
    if (auto p = check("stiffness", law.stiffness, positive, above_zero))
        return p;
    if (auto p = check(
            "exponent", law.exponent, [](double n) { return n >= 1; }, "at least 1"))
        return p;
    if (auto p = check(
            "restitution", law.restitution, [](double e) { return e > 0 && e <= 1; },
            "more than 0, at most 1"))
        return p;
    if (auto p = check("speed", law.speed, positive, above_zero))
        return p;
    if (auto p = check(
            "damping", law.damping, [](double c) { return c >= 0; }, "0 or more"))
        return p;
    if (auto p = check("thickness", law.thickness, positive, above_zero))
        return p;
    if (auto p = check("width", law.width, positive, above_zero))
        return p;
    if (auto p = refuse_materials(law))
        return p;
    return refuse_table(law);
}

Problem refuse_needs(const ContactLaw& law, unsigned takes) {
    if (takes & blending) {
        if (auto p = refuse_missing(law, {"thickness", "width", "hard"}))
            return p;
        if (law.hard.size() != 1 || law.hard[0].kind == "blend")
            return LawError("/hard", "the hard part is one law that is no blend", "one law");
        if (!law.stiffness && law.table.empty())
            return LawError("/stiffness", "the bushing has neither stiffness nor table", "one of them");
        return std::nullopt;
    }
    if (takes & materials) {
        if (!law.stiffness && !law.materials)
            return LawError("/stiffness", "neither stiffness nor materials", "one of them");
        if (!law.stiffness && law.exponent)
            return LawError("/exponent", "an exponent for a stiffness made of materials",
                            "the law's own, or give the stiffness in N/m^exponent");
        return std::nullopt;
    }
    if (takes & table)
        return refuse_missing(law, {"table"});
    if (takes & speed)
        return refuse_missing(law, {"stiffness", "restitution", "speed"});
    return refuse_missing(law, {"stiffness"});
}

Problem refuse_cylinder(const ContactLaw& law, const ContactGeometry& g) {
    if (g.rotation)
        return LawError("/kind", "the law 'cylinder' on a rotation", "a radial motion");
    if (!Cylinder::knows(g.clearance))
        return LawError(
            "/kind",
            fmt::format("the law 'cylinder' with a radial clearance of {:.6g} mm", 1e3 * g.clearance),
            "a clearance from 0.005 to 10 mm");
    if (!law.stiffness && !(g.length > 0))
        return LawError("/stiffness", "a stiffness made of materials without the length of the bearing",
                        "a stiffness, or a bearing with a length");
    return std::nullopt;
}

Problem refuse_geometry(const ContactLaw& law, const ContactGeometry& g) {
    if (law.kind == "cylinder")
        return refuse_cylinder(law, g);
    const NormalLawInfo* kind = find_kind(law.kind);
    if (!(kind->takes & materials) || law.stiffness)
        return std::nullopt;
    constexpr auto allowed = "a stiffness, or a round bearing with a clearance";
    if (g.rotation)
        return LawError("/stiffness", "a stiffness made of materials on a rotation", "a stiffness");
    if (!(g.bearing_radius > 0 && g.journal_radius > 0))
        return LawError("/stiffness", "a stiffness made of materials where nothing is round", allowed);
    if (!(g.clearance > 0))
        return LawError("/stiffness",
                        fmt::format("a stiffness made of materials with a clearance of {} m", g.clearance),
                        allowed);
    return std::nullopt;
}

/// Of the hard part of a blend.
ContactGeometry beyond(const ContactGeometry& g, double thickness) {
    ContactGeometry out = g;
    if (g.bearing_radius > 0)
        out.bearing_radius += thickness;
    out.clearance += thickness;
    return out;
}

// --- depths ---

/// Least x with f(x) >= target in the first of the growing intervals that reaches it.
template <class F> double invert(F&& f, double target, double first, double second) {
    double low = 0, high = first;
    for (bool grown = false; f(high) < target; grown = true) {
        if (high > 1e100)
            return std::numeric_limits<double>::infinity();
        low = high;
        high = grown ? 2 * high : second;
    }
    for (int i = 0; i < 2000; ++i) {
        const double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high)
            break;
        (f(middle) < target ? low : high) = middle;
    }
    return high;
}

template <class OfPower, class OfForce>
double inverse(const SingleLaw& law, const Blend* blend, double target, OfPower&& of_power, OfForce&& part) {
    if (!(target > 0))
        return 0;
    if (blend) {
        const Blend loading = blend->loading();
        const double thickness = loading.thickness();
        return invert(
            [&](double d) {
                return part(loading({d, 0, 1}, {d - thickness, 0, 1}));
            },
            target, thickness, thickness + loading.width());
    }
    const Loading curve = loading_of(law);
    if (const auto* power = std::get_if<PowerLaw>(&curve))
        return of_power(*power);
    const Tabulated& table = *std::get<const Tabulated*>(curve);
    const double end = table.data->knots.back();
    return invert([&](double d) { return part(table({d, 0, 1})); }, target, end, 2 * end);
}

} // namespace

LawError::LawError(std::string member_, std::string problem_, std::string allowed_)
    : std::invalid_argument(fmt::format("{}: {}; allowed: {}", member_, problem_, allowed_)),
      member(std::move(member_)), problem(std::move(problem_)), allowed(std::move(allowed_)) {}

NormalLaw::NormalLaw(Blend blend) : law_(Linear{}), blend_(std::make_shared<const Blend>(std::move(blend))) {}

double NormalLaw::depth_of_energy(double energy) const {
    return inverse(
        law_, blend_.get(), energy,
        [energy](const PowerLaw& p) {
            return std::pow((p.exponent + 1) * energy / p.stiffness, 1 / (p.exponent + 1));
        },
        [](const NormalForce& f) { return f.energy; });
}

double NormalLaw::depth_of_force(double force) const {
    return inverse(
        law_, blend_.get(), force,
        [force](const PowerLaw& p) { return std::pow(force / p.stiffness, 1 / p.exponent); },
        [](const NormalForce& f) { return f.force; });
}

std::span<const NormalLawInfo> normal_law_kinds() { return kinds; }

std::optional<LawError> refusal(const ContactLaw& law, const ContactGeometry* geometry) {
    if (auto p = refuse_kind(law))
        return p;
    const unsigned takes = find_kind(law.kind)->takes;
    if (auto p = refuse_extra(law, takes))
        return p;
    if (auto p = refuse_values(law))
        return p;
    if (auto p = refuse_needs(law, takes))
        return p;
    if (geometry)
        if (auto p = refuse_geometry(law, *geometry))
            return p;
    if (!law.hard.empty()) {
        const ContactGeometry inner = beyond(geometry ? *geometry : ContactGeometry{}, *law.thickness);
        if (const auto p = refusal(law.hard[0], geometry ? &inner : nullptr))
            return LawError("/hard" + p->member, p->problem, p->allowed);
    }
    return std::nullopt;
}

NormalLaw compile_law(const ContactLaw& law, const ContactGeometry& geometry) {
    if (const auto p = refusal(law, &geometry))
        throw *p;
    if (const auto* kind = find_kind(law.kind); kind->make)
        return NormalLaw(kind->make(law, geometry));
    const ContactLaw& inner = law.hard[0];
    const SingleLaw hard = find_kind(inner.kind)->make(inner, beyond(geometry, *law.thickness));
    const double c = law.damping.value_or(0);
    const Blend::Bushing bushing = law.table.empty() ? Blend::Bushing(Linear{law.stiffness.value(), c})
                                                     : Blend::Bushing(Tabulated(law.table, c));
    return NormalLaw(Blend(bushing, hard, *law.thickness, *law.width, law.smooth));
}

} // namespace gudgeon

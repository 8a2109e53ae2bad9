#include "core/validate_laws.hpp"

#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>

namespace gudgeon {

namespace {

/// A normal law: its members, those that must be there with '!'. Of those with '|' exactly one is given.
struct LawKind {
    std::string_view name;
    std::vector<std::string> members;
};

const std::vector<LawKind>& law_kinds() {
    static const std::vector<LawKind> kinds{
        {"hertz", {"|stiffness", "|materials", "exponent"}},
        {"lankarani-nikravesh", {"|stiffness", "|materials", "exponent", "restitution"}},
        {"cylinder", {"|stiffness", "|materials", "exponent", "restitution"}},
        {"kelvin-voigt", {"!stiffness", "!restitution", "!speed"}},
        {"hunt-crossley", {"|stiffness", "|materials", "exponent", "restitution"}},
        {"flores", {"|stiffness", "|materials", "exponent", "restitution"}},
        {"linear", {"!stiffness", "damping"}},
        {"tabulated", {"!table", "damping"}},
        {"blend", {"|stiffness", "|table", "damping", "!thickness", "!width", "!hard"}},
    };
    return kinds;
}

struct FrictionKind {
    std::string_view name;
    std::vector<std::string> members; // besides mu_k
};

const std::vector<FrictionKind>& friction_kinds() {
    static const std::vector<FrictionKind> kinds{
        {"coulomb", {"!speed"}},
        {"coulomb-smooth", {"!speed"}},
        {"lugre", {"!sigma0", "sigma1", "sigma2", "mu_s", "speed", "exponent"}},
        {"dahl", {"!sigma0"}},
    };
    return kinds;
}

template <class T>
const T& find_kind(const Checker& check, const std::string& at, const std::string& kind,
                   const std::vector<T>& kinds, const char* what) {
    const auto found = std::ranges::find(kinds, kind, &T::name);
    if (found != kinds.end())
        return *found;
    std::vector<std::string> names;
    for (const T& entry : kinds)
        names.emplace_back(entry.name);
    check.refuse(at + "/kind", fmt::format("unknown {} '{}'", what, kind),
                 suggestion(kind, names) + listed(names));
}

struct Given {
    const char* name;
    bool given;
};

std::string bare(const std::string& member) { return member.substr(member.find_first_not_of("!|")); }

/// What is given is used by the kind, what the kind needs is given.
void check_members(const Checker& check, const std::string& at, const std::string& kind,
                   const std::vector<std::string>& members, std::span<const Given> all) {
    std::vector<std::string> names, either, found;
    for (const std::string& member : members) {
        names.push_back(bare(member));
        if (member[0] == '|')
            either.push_back(names.back());
    }
    for (const auto& [name, given] : all) {
        if (given && std::ranges::find(names, name) == names.end())
            check.refuse(at + '/' + name, fmt::format("'{}' is not used by the kind '{}'", name, kind),
                         listed(names));
        if (given && std::ranges::find(either, name) != either.end())
            found.emplace_back(name);
        if (!given && std::ranges::find(members, '!' + std::string(name)) != members.end())
            check.refuse(at + '/' + name, fmt::format("'{}' is missing", name),
                         fmt::format("'{}' is required by the kind '{}'", name, kind));
    }
    if (!either.empty() && found.empty())
        check.refuse(at + '/' + either[0], fmt::format("'{}' is missing", fmt::join(either, "' and '")),
                     "one of the two");
    if (found.size() > 1)
        check.refuse(at + '/' + found[1], fmt::format("'{}' beside '{}'", found[1], found[0]),
                     "one of the two");
}

void check_material(const Checker& check, const std::string& at, const Material& material) {
    check.positive(at, "young", material.young);
    check.not_negative(at, "poisson", material.poisson);
    if (material.poisson >= 0.5)
        check.refuse(at + "/poisson", fmt::format("the Poisson ratio {}", material.poisson),
                     "from 0 to less than 0.5");
}

void check_materials(const Checker& check, const std::string& at, const std::array<Material, 2>& sides) {
    const bool one = sides[0].young == sides[1].young && sides[0].poisson == sides[1].poisson;
    for (std::size_t i = 0; i < 2; ++i)
        check_material(check, at + (one ? "/material" : fmt::format("/materials/{}", i)), sides[i]);
}

/// Force against penetration: starts at (0, 0) and never falls.
void check_force_table(const Checker& check, const std::string& at, const Table& table) {
    check.table(at, "table", table);
    for (const auto& [axis, first] : {std::pair{"x", table.x[0]}, std::pair{"y", table.y[0]}})
        if (first != 0)
            check.refuse(fmt::format("{}/table/{}/0", at, axis),
                         fmt::format("a force table that starts at ({}, {})", table.x[0], table.y[0]),
                         "tables that start at (0, 0)");
    for (std::size_t i = 1; i < table.y.size(); ++i)
        if (table.y[i] < table.y[i - 1])
            check.refuse(fmt::format("{}/table/y/{}", at, i),
                         fmt::format("the force falls from {} to {}", table.y[i - 1], table.y[i]),
                         "forces that do not fall with the penetration");
    if (table.y.back() == 0)
        check.refuse(at + "/table/y", "a table without force", "more than 0 at its end");
}

void check_restitution(const Checker& check, const std::string& at, double restitution) {
    check.finite(at, "restitution", restitution);
    if (restitution <= 0 || restitution > 1)
        check.refuse(at + "/restitution", fmt::format("the restitution {}", restitution),
                     "more than 0, at most 1");
}

void check_values(const Checker& check, const std::string& at, const ContactLaw& law) {
    if (law.stiffness)
        check.positive(at, "stiffness", *law.stiffness);
    if (law.exponent) {
        check.finite(at, "exponent", *law.exponent);
        if (*law.exponent < 1)
            check.refuse(at + "/exponent", fmt::format("the exponent {}", *law.exponent), "1 or more");
    }
    if (law.restitution)
        check_restitution(check, at, *law.restitution);
    if (law.speed)
        check.positive(at, "speed", *law.speed);
    if (law.damping)
        check.not_negative(at, "damping", *law.damping);
    if (law.materials)
        check_materials(check, at, *law.materials);
    if (!law.table.empty() || !law.table.y.empty())
        check_force_table(check, at, law.table);
    if (law.thickness)
        check.positive(at, "thickness", *law.thickness);
    if (law.width)
        check.positive(at, "width", *law.width);
}

void check_hard(const Checker& check, const std::string& at, const ContactLaw& law, const LawPlace& place) {
    if (law.hard.size() > 1)
        check.refuse(at + "/hard", fmt::format("{} laws", law.hard.size()), "one law");
    if (law.hard.empty())
        return;
    if (law.hard[0].kind == "blend")
        check.refuse(at + "/hard/kind", "a 'blend' in a 'blend'", "any other kind");
    check_law(check, at + "/hard", law.hard[0], place);
}

} // namespace

void check_law(const Checker& check, const std::string& at, const ContactLaw& law, const LawPlace& place) {
    const LawKind& kind = find_kind(check, at, law.kind, law_kinds(), "normal law");
    const Given given[]{{"stiffness", law.stiffness.has_value()},
                        {"materials", law.materials.has_value()},
                        {"exponent", law.exponent.has_value()},
                        {"restitution", law.restitution.has_value()},
                        {"speed", law.speed.has_value()},
                        {"damping", law.damping.has_value()},
                        {"table", !law.table.empty() || !law.table.y.empty()},
                        {"thickness", law.thickness.has_value()},
                        {"width", law.width.has_value()},
                        {"blend", law.smooth},
                        {"hard", !law.hard.empty()}};
    auto members = kind.members;
    if (kind.name == "blend")
        members.emplace_back("blend");
    if (kind.name == "cylinder" && !place.cylinders)
        check.refuse(at + "/kind", fmt::format("the law 'cylinder' in {}", place.name),
                     "another law: this one is for a cylinder in a cylinder");
    check_members(check, at, law.kind, members, given);
    if (law.materials && law.exponent)
        check.refuse(at + "/exponent",
                     fmt::format("the exponent {} of a stiffness from materials", *law.exponent),
                     "the law's own, or 'stiffness'");
    if (law.materials && kind.name != "cylinder" && !place.radii)
        check.refuse(at + "/materials", fmt::format("materials in {}, which has no radii", place.name),
                     "'stiffness' instead");
    check_values(check, at, law);
    check_hard(check, at, law, place);
}

void check_friction_law(const Checker& check, const std::string& at, const Friction& friction) {
    const Friction otherwise;
    const FrictionKind& kind = find_kind(check, at, friction.kind, friction_kinds(), "friction law");
    const Given given[]{{"speed", friction.speed.has_value()},
                        {"mu_s", friction.statics.has_value()},
                        {"exponent", friction.exponent != otherwise.exponent},
                        {"sigma0", friction.sigma0.has_value()},
                        {"sigma1", friction.sigma1 != 0},
                        {"sigma2", friction.sigma2 != 0}};
    check_members(check, at, friction.kind, kind.members, given);
    if (friction.sigma0) { // the bristle's deflection is at most mu / sigma0
        check.positive(at, "mu_k", friction.kinetic);
        check.positive(at, "sigma0", *friction.sigma0);
    }
    check.not_negative(at, "mu_k", friction.kinetic);
    if (friction.statics) {
        check.finite(at, "mu_s", *friction.statics);
        if (*friction.statics < friction.kinetic)
            check.refuse(at + "/mu_s",
                         fmt::format("{} is less than 'mu_k' {}", *friction.statics, friction.kinetic),
                         "'mu_k' or more");
        if (*friction.statics > friction.kinetic && !friction.speed)
            check.refuse(at + "/speed", "'speed' is missing",
                         "the Stribeck speed where 'mu_s' exceeds 'mu_k'");
    }
    if (friction.speed)
        check.positive(at, "speed", *friction.speed);
    check.positive(at, "exponent", friction.exponent);
    check.not_negative(at, "sigma1", friction.sigma1);
    check.not_negative(at, "sigma2", friction.sigma2);
    if (friction.normal_force)
        check.not_negative(at, "normal_force", *friction.normal_force);
    if (friction.radius)
        check.positive(at, "radius", *friction.radius);
}

namespace {

void refuse_coordinate(const Checker& check, const std::string& at, const Friction& friction,
                       const char* place) {
    if (friction.coordinate)
        check.refuse(at + "/coordinate",
                     fmt::format("the coordinate '{}' in the friction of {}", *friction.coordinate, place),
                     "no coordinate here");
}

} // namespace

void refuse_radius_and_coordinate(const Checker& check, const std::string& at, const Friction& friction,
                                  const char* place) {
    if (friction.radius)
        check.refuse(at + "/radius",
                     fmt::format("the radius {} in the friction of {}", *friction.radius, place),
                     "no radius here");
    refuse_coordinate(check, at, friction, place);
}

void refuse_coordinate_and_force(const Checker& check, const std::string& at, const Friction& friction,
                                 const char* place) {
    refuse_coordinate(check, at, friction, place);
    if (friction.normal_force)
        check.refuse(at + "/normal_force",
                     fmt::format("the normal force {} in {}", *friction.normal_force, place),
                     "no normal force: the contact has its own");
}

} // namespace gudgeon

#include "core/reader_parts.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

namespace {

std::optional<double> read_number(const JsonInput& in, const char* key) {
    return in.has(key) ? std::optional(in.at(key).number()) : std::nullopt;
}

Material read_material(const JsonInput& in) {
    in.expect_keys({"young", "poisson"});
    return {in.at("young").number(), in.at("poisson").number()};
}

/// "material" of both bodies, or "materials": [of the bearing, of the journal].
std::optional<std::array<Material, 2>> read_materials(const JsonInput& in) {
    if (in.has("material")) {
        if (in.has("materials"))
            in.at("materials").refuse("'materials' beside 'material'", "one of the two");
        const Material both = read_material(in.at("material"));
        return std::array<Material, 2>{both, both};
    }
    if (!in.has("materials"))
        return std::nullopt;
    const auto sides = in.at("materials").items(2, "materials: [of the bearing, of the journal]");
    return std::array<Material, 2>{read_material(sides[0]), read_material(sides[1])};
}

ContactLaw read_law(const JsonInput& in) {
    in.expect_keys({"kind", "stiffness", "exponent", "restitution", "speed", "damping", "material",
                    "materials", "table", "thickness", "width", "blend", "hard"});
    ContactLaw law;
    law.kind = in.at("kind").text();
    law.stiffness = read_number(in, "stiffness");
    law.exponent = read_number(in, "exponent");
    law.restitution = read_number(in, "restitution");
    law.speed = read_number(in, "speed");
    law.damping = read_number(in, "damping");
    law.materials = read_materials(in);
    if (in.has("table"))
        law.table = read_table(in.at("table"));
    law.thickness = read_number(in, "thickness");
    law.width = read_number(in, "width");
    if (in.has("blend")) {
        if (law.kind != "blend")
            in.at("blend").refuse(fmt::format("'blend' in a law of kind '{}'", law.kind),
                                  "'blend' for the kind 'blend' only");
        law.smooth = in.at("blend").choice({"sum", "smooth"}) == 1;
    }
    if (in.has("hard"))
        law.hard.push_back(read_law(in.at("hard")));
    return law;
}

std::optional<ContactLaw> read_other_law(const JsonInput& in, const char* key) {
    return in.has(key) ? std::optional(read_law(in.at(key))) : std::nullopt;
}

int read_count(const JsonInput& in) {
    const double value = in.number();
    if (value != std::floor(value) || std::abs(value) > 1e6)
        in.refuse(fmt::format("{} is no whole number up to a million", value), "whole numbers from 1");
    return static_cast<int>(value);
}

/// Number and radii of the strips: a profile has one radius for each.
void read_strips(const JsonInput& in, Clearance& out) {
    if (in.has("profile"))
        out.profile = in.at("profile").numbers();
    if (in.has("profile") && out.profile.empty()) // means "no profile" in the model
        in.at("profile").refuse("a profile of 0 radii", "a radius for each strip");
    if (in.has("strips"))
        out.strips = read_count(in.at("strips"));
    else if (in.has("profile"))
        out.strips = static_cast<int>(out.profile.size());
}

Fidelity read_motion_fidelity(const JsonInput& in) {
    return static_cast<Fidelity>(in.choice({"perfect", "bushing", "clearance", "free"}));
}

} // namespace

void read_fidelity(const JsonInput& in, Joint& joint) {
    if (!in.is_object()) {
        joint.fidelity = static_cast<Fidelity>(in.choice({"perfect", "bushing", "clearance"}));
        return;
    }
    in.expect_keys({"radial", "axial", "misalignment", "rotation"});
    for (std::size_t i = 0; i < motion_names.size(); ++i)
        if (const std::string key(motion_names[i]); in.has(key.c_str()))
            joint.motions[i] = read_motion_fidelity(in.at(key.c_str()));
}

Clearance read_clearance(const JsonInput& in) {
    in.expect_keys({"model", "radial", "axial", "rotation", "misalignment", "radius", "length",
                    "journal_length", "strips", "profile", "section", "law", "axial_law", "rotation_law",
                    "friction"});
    Clearance out;
    if (in.has("model"))
        out.model = in.at("model").text();
    out.radial = read_number(in, "radial");
    out.axial = read_number(in, "axial");
    out.rotation = read_number(in, "rotation");
    out.misalignment = read_number(in, "misalignment");
    out.radius = read_number(in, "radius");
    out.length = read_number(in, "length");
    out.journal_length = read_number(in, "journal_length");
    read_strips(in, out);
    if (in.has("section")) {
        const auto sides = in.at("section").items(2, "numbers: width along h, height along t");
        out.section = {sides[0].number(), sides[1].number()};
    }
    out.law = read_law(in.at("law"));
    out.axial_law = read_other_law(in, "axial_law");
    out.rotation_law = read_other_law(in, "rotation_law");
    if (in.has("friction"))
        out.friction = read_friction(in.at("friction"));
    return out;
}

Stop read_stop(const JsonInput& in) {
    in.expect_keys({"lower", "upper", "law", "friction"});
    Stop out{read_number(in, "lower"), read_number(in, "upper"), read_law(in.at("law")), {}};
    if (in.has("friction"))
        out.friction = read_friction(in.at("friction"));
    return out;
}

Friction read_friction(const JsonInput& in) {
    in.expect_keys({"kind", "mu_k", "mu_s", "speed", "exponent", "sigma0", "sigma1", "sigma2", "normal_force",
                    "radius", "coordinate"});
    Friction out;
    out.kind = in.at("kind").text();
    out.kinetic = in.at("mu_k").number();
    out.statics = read_number(in, "mu_s");
    out.speed = read_number(in, "speed");
    out.exponent = in.number("exponent", out.exponent);
    out.sigma0 = read_number(in, "sigma0");
    out.sigma1 = in.number("sigma1", 0);
    out.sigma2 = in.number("sigma2", 0);
    out.normal_force = read_number(in, "normal_force");
    out.radius = read_number(in, "radius");
    if (in.has("coordinate"))
        out.coordinate = in.at("coordinate").text();
    return out;
}

void read_contacts(const JsonInput& in, Joint& joint) {
    if (in.has("clearance"))
        joint.clearance = read_clearance(in.at("clearance"));
    if (in.has("bearing")) {
        const bool on_b = in.at("bearing").choice({"a", "b"}) == 1;
        if (!joint.clearance)
            in.at("bearing").refuse("'bearing' without 'clearance'", "'bearing' beside 'clearance'");
        joint.clearance->bearing_on_b = on_b;
    }
    if (in.has("stops"))
        for (const auto& [coordinate, stop] : in.at("stops").members())
            joint.stops.emplace(coordinate, read_stop(stop));
    if (!in.has("friction"))
        return;
    const JsonInput friction = in.at("friction");
    if (friction.is_array())
        for (const JsonInput& item : friction.items())
            joint.friction.push_back(read_friction(item));
    else
        joint.friction.push_back(read_friction(friction));
}

} // namespace gudgeon

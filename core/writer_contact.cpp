#include "core/joint_motions.hpp"
#include "core/writer_parts.hpp"

namespace gudgeon {

using Json = nlohmann::ordered_json;

namespace {

constexpr std::array<const char*, 4> fidelity_names{"perfect", "bushing", "clearance", "free"};

const char* name_of(Fidelity fidelity) { return fidelity_names[static_cast<std::size_t>(fidelity)]; }

void put(Json& out, const char* key, const std::optional<double>& value) {
    if (value)
        out[key] = *value;
}

Json to_json(const Material& material) { return {{"young", material.young}, {"poisson", material.poisson}}; }

void put_materials(Json& out, const std::array<Material, 2>& sides) {
    if (sides[0].young == sides[1].young && sides[0].poisson == sides[1].poisson)
        out["material"] = to_json(sides[0]);
    else
        out["materials"] = Json::array({to_json(sides[0]), to_json(sides[1])});
}

Json to_json(const ContactLaw& law) {
    Json out{{"kind", law.kind}};
    put(out, "stiffness", law.stiffness);
    put(out, "exponent", law.exponent);
    put(out, "restitution", law.restitution);
    put(out, "speed", law.speed);
    put(out, "damping", law.damping);
    if (law.materials)
        put_materials(out, *law.materials);
    if (!law.table.empty())
        out["table"] = to_json(law.table);
    put(out, "thickness", law.thickness);
    put(out, "width", law.width);
    if (law.smooth)
        out["blend"] = "smooth";
    if (!law.hard.empty())
        out["hard"] = to_json(law.hard.front());
    return out;
}

Json to_json(const Clearance& clearance) {
    Json out = Json::object();
    const Clearance otherwise;
    if (clearance.model != otherwise.model)
        out["model"] = clearance.model;
    put(out, "radial", clearance.radial);
    put(out, "axial", clearance.axial);
    put(out, "rotation", clearance.rotation);
    put(out, "misalignment", clearance.misalignment);
    put(out, "radius", clearance.radius);
    put(out, "length", clearance.length);
    put(out, "journal_length", clearance.journal_length);
    if (!clearance.profile.empty())
        out["profile"] = clearance.profile;
    else if (clearance.strips != otherwise.strips)
        out["strips"] = clearance.strips;
    if (clearance.section)
        out["section"] = *clearance.section;
    out["law"] = to_json(clearance.law);
    if (clearance.axial_law)
        out["axial_law"] = to_json(*clearance.axial_law);
    if (clearance.rotation_law)
        out["rotation_law"] = to_json(*clearance.rotation_law);
    if (clearance.friction)
        out["friction"] = to_json(*clearance.friction);
    return out;
}

Json to_json(const Stop& stop) {
    Json out = Json::object();
    put(out, "lower", stop.lower);
    put(out, "upper", stop.upper);
    out["law"] = to_json(stop.law);
    if (stop.friction)
        out["friction"] = to_json(*stop.friction);
    return out;
}

} // namespace

Json to_json(const Table& table) { return {{"x", table.x}, {"y", table.y}}; }

Json to_json(const Friction& friction) {
    const Friction otherwise;
    Json out{{"kind", friction.kind}, {"mu_k", friction.kinetic}};
    put(out, "mu_s", friction.statics);
    put(out, "speed", friction.speed);
    if (friction.exponent != otherwise.exponent)
        out["exponent"] = friction.exponent;
    put(out, "sigma0", friction.sigma0);
    if (friction.sigma1 != 0)
        out["sigma1"] = friction.sigma1;
    if (friction.sigma2 != 0)
        out["sigma2"] = friction.sigma2;
    put(out, "normal_force", friction.normal_force);
    put(out, "radius", friction.radius);
    if (friction.coordinate)
        out["coordinate"] = *friction.coordinate;
    return out;
}

void put_fidelity(Json& out, const Joint& joint) {
    if (!is_mixed(joint)) {
        if (joint.fidelity != Fidelity::perfect)
            out["fidelity"] = name_of(joint.fidelity);
        return;
    }
    // Motions that are not listed are perfect.
    Json& words = out["fidelity"] = Json::object();
    for (std::size_t i = 0; i < joint.motions.size(); ++i)
        if (joint.motions[i] ||
            (holds_motion(joint.kind, static_cast<Motion>(i)) && joint.fidelity != Fidelity::perfect))
            words[std::string(motion_names[i])] = name_of(joint.holds(static_cast<Motion>(i)));
}

void put_contacts(Json& out, const Joint& joint) {
    if (joint.clearance) {
        out["clearance"] = to_json(*joint.clearance);
        if (joint.clearance->bearing_on_b)
            out["bearing"] = "b";
    }
    for (const auto& [coordinate, stop] : joint.stops)
        out["stops"][coordinate] = to_json(stop);
    if (joint.friction.size() == 1)
        out["friction"] = to_json(joint.friction.front());
    else
        for (const Friction& friction : joint.friction)
            out["friction"].push_back(to_json(friction));
}

} // namespace gudgeon

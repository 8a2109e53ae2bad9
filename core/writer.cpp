#include "core/writer.hpp"

#include "core/joint_kinds.hpp"
#include "core/writer_parts.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>

namespace gudgeon {

using Json = nlohmann::ordered_json;

namespace {

Json json(const Vec3& v) { return {v[0], v[1], v[2]}; }

Json json(const std::array<Vec3, 2>& sides) { return Json::array({json(sides[0]), json(sides[1])}); }

Json json(const Mat3& inertia) {
    if (inertia == Mat3(inertia.diagonal().asDiagonal()))
        return json(Vec3(inertia.diagonal()));
    Json rows = Json::array();
    for (int i = 0; i < 3; ++i)
        rows.push_back(json(Vec3(inertia.row(i))));
    return rows;
}

struct FunctionWriter {
    Json operator()(const ConstantFunction& f) const { return {{"kind", "constant"}, {"value", f.value}}; }
    Json operator()(const HarmonicFunction& f) const {
        return {{"kind", "harmonic"},
                {"amplitude", f.amplitude},
                {"frequency", f.frequency},
                {"phase", f.phase},
                {"offset", f.offset}};
    }
    Json operator()(const SmoothStepFunction& f) const {
        return {{"kind", "smooth-step"}, {"start", f.start}, {"end", f.end}, {"from", f.from}, {"to", f.to}};
    }
    Json operator()(const RampFunction& f) const {
        return {{"kind", "ramp"}, {"value", f.value}, {"rate", f.rate}, {"start", f.start}};
    }
    Json operator()(const TableFunction& f) const {
        return {{"kind", "table"}, {"x", f.table().x}, {"y", f.table().y}};
    }
};

Json json(const TimeFunction& f) { return std::visit(FunctionWriter{}, f); }

Json json(const Bushing& bushing); // for put_if

/// What is left at its default is not written.
void put_unless_zero(Json& out, const char* key, const Vec3& v) {
    if (!v.isZero(0))
        out[key] = json(v);
}

template <class Optional> void put_if(Json& out, const char* key, const Optional& value) {
    if (!value)
        return;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(*value)>, double>)
        out[key] = *value;
    else
        out[key] = json(*value);
}

void put_frame(Json& out, bool body_frame) {
    if (body_frame)
        out["frame"] = "body";
}

void put_sides(Json& out, const char* one, const char* two, bool body_frame,
               const std::array<Vec3, 2>& sides) {
    if (!body_frame && sides[0] == sides[1])
        out[one] = json(sides[0]);
    else
        out[two] = json(sides);
}

Json json(const Body& body) {
    Json out{{"name", body.name}};
    if (body.fixed)
        out["fixed"] = true;
    if (!body.fixed || body.mass != 0)
        out["mass"] = body.mass;
    if (!body.fixed || !body.inertia.isZero(0))
        out["inertia"] = json(body.inertia);
    out["position"] = json(body.position);
    const Vec4& p = body.orientation;
    out["orientation"] = {p[0], p[1], p[2], p[3]};
    put_unless_zero(out, "velocity", body.velocity);
    put_unless_zero(out, "angular_velocity", body.angular_velocity);
    put_if(out, "start_position", body.start_position);
    if (body.start_orientation) {
        const Vec4& s = *body.start_orientation;
        out["start_orientation"] = {s[0], s[1], s[2], s[3]};
    }
    if (!body.hold.empty())
        out["hold"] = body.hold;
    return out;
}

Json json(const Bushing& bushing) {
    Json out{{"stiffness", bushing.stiffness}, {"damping", bushing.damping}, {"preload", bushing.preload}};
    static constexpr std::array<const char*, 6> axis{"x", "y", "z", "rx", "ry", "rz"};
    for (std::size_t i = 0; i < 6; ++i)
        if (!bushing.tables[i].empty())
            out["tables"][axis[i]] = to_json(bushing.tables[i]);
    out["axes"] = bushing.global_axes ? "global" : "joint";
    return out;
}

Json json(const Joint& joint) {
    Json out{{"name", joint.name}, {"kind", joint_kind(joint.kind).name}, {"bodies", joint.bodies}};
    put_frame(out, joint.body_frame);
    put_sides(out, "point", "points", joint.body_frame, joint.points);
    if (joint.axes) {
        if (joint.kind == JointKind::universal && !joint.body_frame) {
            out["axis"] = json((*joint.axes)[0]);
            out["axis2"] = json((*joint.axes)[1]);
        } else {
            put_sides(out, "axis", "axes", joint.body_frame, *joint.axes);
        }
    }
    if (joint.references)
        put_sides(out, "reference", "references", joint.body_frame, *joint.references);
    put_if(out, "length", joint.length);
    put_fidelity(out, joint);
    put_if(out, "bushing", joint.bushing);
    put_contacts(out, joint);
    if (!joint.start_angles.empty())
        out["start_angles"] = joint.start_angles;
    if (joint.cut)
        out["cut"] = true;
    for (const auto& [coordinate, function] : joint.drives)
        out["drives"][coordinate] = json(function);
    return out;
}

void put_spring(Json& out, double stiffness, double damping, const Table& table) {
    if (table.empty())
        out["stiffness"] = stiffness;
    else
        out["table"] = to_json(table);
    out["damping"] = damping;
}

struct ForceWriter {
    Json operator()(const SpringDamper& f) const {
        Json out{{"name", f.name}, {"kind", "spring-damper"}, {"bodies", f.bodies}};
        put_frame(out, f.body_frame);
        out["points"] = json(f.points);
        put_spring(out, f.stiffness, f.damping, f.table);
        put_if(out, "free_length", f.free_length);
        put_if(out, "preload", f.preload);
        put_if(out, "actuator", f.actuator);
        return out;
    }

    Json operator()(const TorsionSpring& f) const {
        Json out{
            {"name", f.name}, {"kind", "torsion-spring"}, {"joint", f.joint}, {"coordinate", f.coordinate}};
        put_spring(out, f.stiffness, f.damping, f.table);
        out["free_angle"] = f.free_angle;
        return out;
    }

    Json operator()(const Tyre& f) const {
        Json out{{"name", f.name}, {"kind", "tyre"}, {"body", f.body}};
        put_frame(out, f.body_frame);
        out["point"] = json(f.point);
        out["stiffness"] = f.stiffness;
        out["damping"] = f.damping;
        out["preload"] = f.preload;
        put_if(out, "reference", f.reference);
        put_if(out, "road", f.road);
        if (!f.profile.empty())
            out["profile"] = to_json(f.profile);
        return out;
    }

    Json operator()(const FrictionForce& f) const {
        Json out{{"name", f.name}, {"kind", "friction"}, {"bodies", f.bodies}};
        put_frame(out, f.body_frame);
        put_sides(out, "point", "points", f.body_frame, f.points);
        out["axis"] = json(f.axis);
        out["friction"] = to_json(f.friction);
        return out;
    }

    Json operator()(const AppliedForce& f) const {
        Json out{{"name", f.name}, {"kind", f.torque ? "torque" : "force"}, {"body", f.body}};
        if (!f.torque) {
            put_frame(out, f.body_frame);
            out["point"] = json(f.point);
        }
        out["vector"] = json(f.vector);
        if (f.follows)
            out["axes"] = "body";
        put_if(out, "time", f.time);
        return out;
    }
};

Json json(const Force& force) { return std::visit(ForceWriter{}, force); }

Json json(const Marker& marker) {
    Json out{{"name", marker.name}, {"body", marker.body}};
    put_frame(out, marker.body_frame);
    out["point"] = json(marker.point);
    return out;
}

template <class T> Json list(const std::vector<T>& items) {
    Json out = Json::array();
    for (const T& item : items) {
        if constexpr (requires { item.piece; })
            if (item.piece)
                continue; // written as part of its beam
        out.push_back(json(item));
    }
    return out;
}

/// Arrays of numbers and small objects stay on one line.
void print(std::string& out, const Json& value, int indent) {
    const std::string line = value.dump(-1, ' ', false, Json::error_handler_t::replace);
    if (!value.is_structured() || value.empty() || line.size() + static_cast<std::size_t>(indent) <= 100) {
        out += line;
        return;
    }
    const std::string inner(static_cast<std::size_t>(indent) + 2, ' ');
    out += value.is_array() ? "[" : "{";
    const char* separator = "\n";
    for (const auto& [key, member] : value.items()) {
        out += separator + inner;
        if (value.is_object())
            out += Json(key).dump(-1, ' ', false, Json::error_handler_t::replace) + ": ";
        print(out, member, indent + 2);
        separator = ",\n";
    }
    out += '\n' + std::string(static_cast<std::size_t>(indent), ' ') + (value.is_array() ? "]" : "}");
}

} // namespace

Json to_json(const Model& model) {
    Json out{{"gudgeon", 1}, {"name", model.name}, {"gravity", json(model.gravity)}};
    if (!model.parameters.empty())
        out["parameters"] = model.parameters;
    out["bodies"] = list(model.bodies);
    const auto put_list = [&](const char* key, Json items) {
        if (!items.empty())
            out[key] = std::move(items);
    };
    put_list("joints", list(model.joints));
    put_list("forces", list(model.forces));
    put_list("markers", list(model.markers));
    for (const Beam& beam : model.beams)
        out["beams"].push_back(to_json(beam, model));
    if (const Model::Onset& onset = model.onset; onset.depth || onset.force || onset.energy) {
        Json& member = out["onset"] = Json::object();
        put_if(member, "depth", onset.depth);
        put_if(member, "force", onset.force);
        put_if(member, "energy", onset.energy);
    }
    put_if(out, "end", model.end);
    put_if(out, "every", model.every);
    return out;
}

std::string write_model(const Model& model) {
    std::string out;
    print(out, to_json(model), 0);
    return out + '\n';
}

} // namespace gudgeon

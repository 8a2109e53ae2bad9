#include "core/joint_kinds.hpp"
#include "core/reader_parts.hpp"

#include <fmt/format.h>

namespace gudgeon {

namespace {

JointKind read_kind(const JsonInput& in) {
    const std::string name = in.text();
    if (const JointKindInfo* info = find_joint_kind(name))
        return info->kind;
    std::vector<std::string> names;
    for (const JointKindInfo& info : joint_kinds())
        names.emplace_back(info.name);
    in.refuse(fmt::format("unknown joint kind {}", in.shown()), suggestion(name, names) + listed(names));
}

std::array<double, 6> read_six(const JsonInput& in) {
    const auto parts = in.items(6, "numbers: 3 translations, 3 rotations");
    std::array<double, 6> out{};
    for (std::size_t i = 0; i < 6; ++i)
        out[i] = parts[i].number();
    return out;
}

Bushing read_bushing(const JsonInput& in) {
    in.expect_keys({"stiffness", "damping", "preload", "tables", "axes"});
    Bushing bushing;
    bushing.stiffness = read_six(in.at("stiffness"));
    if (in.has("damping"))
        bushing.damping = read_six(in.at("damping"));
    if (in.has("preload"))
        bushing.preload = read_six(in.at("preload"));
    bushing.global_axes = in.has("axes") && in.at("axes").choice({"joint", "global"}) == 1;
    if (in.has("tables")) {
        const JsonInput tables = in.at("tables");
        tables.expect_keys({"x", "y", "z", "rx", "ry", "rz"});
        std::size_t i = 0;
        for (const char* axis : {"x", "y", "z", "rx", "ry", "rz"}) {
            if (tables.has(axis))
                bushing.tables[i] = read_table(tables.at(axis));
            ++i;
        }
    }
    return bushing;
}

/// A direction of both sides: one vector for both (global only) or a pair.
std::optional<std::array<Vec3, 2>> read_pair(const JsonInput& in, const char* one, const char* two,
                                             bool body_frame) {
    if (in.has(two)) {
        if (in.has(one))
            in.at(one).refuse(fmt::format("'{}' beside '{}'", one, two), "one of the two");
        const auto sides = in.at(two).items(2, "vectors: [of a, of b]");
        return std::array<Vec3, 2>{sides[0].vector(), sides[1].vector()};
    }
    if (!in.has(one))
        return std::nullopt;
    if (body_frame)
        in.at(one).refuse("one vector in two body frames",
                          fmt::format("'{}': [in a, in b] with \"frame\": \"body\"", two));
    const Vec3 v = in.at(one).vector();
    return std::array<Vec3, 2>{v, v};
}

void read_axes(const JsonInput& in, Joint& joint) {
    joint.axes = read_pair(in, "axis", "axes", joint.body_frame);
    if (!in.has("axis2")) {
        if (joint.kind == JointKind::universal && joint.axes && !in.has("axes"))
            in.at("axis2"); // refuses: missing
        return;
    }
    if (joint.kind != JointKind::universal)
        in.at("axis2").refuse(fmt::format("'axis2' of a {} joint", joint_kind(joint.kind).name),
                              "'axis2' for universal joints only");
    if (in.has("axes"))
        in.at("axis2").refuse("'axis2' beside 'axes'", "one of the two");
    if (joint.body_frame)
        in.at("axis2").refuse("'axis2' with \"frame\": \"body\"", "'axes': [axis in a, axis2 in b]");
    in.at("axis");
    (*joint.axes)[1] = in.at("axis2").vector();
}

} // namespace

Joint read_joint(const JsonInput& in) {
    in.expect_keys({"name",      "kind",    "bodies",    "frame",      "point",  "points",       "axis",
                    "axis2",     "axes",    "reference", "references", "length", "fidelity",     "bushing",
                    "clearance", "bearing", "stops",     "friction",   "drives", "start_angles", "cut"});
    Joint joint;
    joint.name = in.at("name").text();
    joint.kind = read_kind(in.at("kind"));
    joint.bodies = read_body_pair(in);
    joint.body_frame = read_body_frame(in);
    joint.points = read_points(in, joint.body_frame);
    read_axes(in, joint);
    joint.references = read_pair(in, "reference", "references", joint.body_frame);
    if (in.has("length"))
        joint.length = in.at("length").number();
    if (in.has("fidelity"))
        read_fidelity(in.at("fidelity"), joint);
    if (joint.fidelity == Fidelity::bushing || in.has("bushing"))
        joint.bushing = read_bushing(in.at("bushing"));
    read_contacts(in, joint);
    joint.cut = in.has("cut") && in.at("cut").flag();
    if (in.has("start_angles"))
        for (const auto& [coordinate, angle] : in.at("start_angles").members())
            joint.start_angles.emplace(coordinate, angle.number());
    if (in.has("drives"))
        for (const auto& [coordinate, function] : in.at("drives").members())
            joint.drives.emplace(coordinate, read_time_function(function));
    return joint;
}

} // namespace gudgeon

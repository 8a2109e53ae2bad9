#include "core/reader.hpp"

#include "core/reader_parts.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <sstream>
#include <utility>

namespace gudgeon {

namespace {

Mat3 read_inertia(const JsonInput& in) {
    const auto rows = in.items(3, "principal values, or 3 rows of 3 numbers");
    Mat3 inertia = Mat3::Zero();
    const bool matrix = rows[0].is_array();
    for (int i = 0; i < 3; ++i) {
        if (matrix)
            inertia.row(i) = rows[i].vector();
        else
            inertia(i, i) = rows[i].number();
    }
    return inertia;
}

Model::Onset read_onset(const JsonInput& in) {
    in.expect_keys({"depth", "force", "energy"});
    Model::Onset onset;
    for (const auto& [key, value] : in.members())
        (key == "depth" ? onset.depth : key == "force" ? onset.force : onset.energy) = value.number();
    if (in.size() == 0)
        in.refuse("an onset without a threshold", "one of depth, force, energy");
    return onset;
}

void check_version(const JsonInput& root) {
    const JsonInput version = root.at("gudgeon");
    if (version.literal() != 1)
        version.refuse(fmt::format("unknown version {} of the format", version.shown()), "1");
}

std::map<std::string, double> read_parameters(const nlohmann::ordered_json& document,
                                              const std::string& source,
                                              const std::map<std::string, double>& overrides) {
    std::map<std::string, double> parameters;
    const JsonInput::Context none{source, {}};
    const JsonInput root(document, "", none);
    if (root.is_object() && root.has("parameters"))
        for (const auto& [name, value] : root.at("parameters").members())
            parameters[name] = value.literal();
    std::vector<std::string> names;
    for (const auto& entry : parameters)
        names.push_back(entry.first);
    for (const auto& [name, value] : overrides) {
        if (!parameters.contains(name))
            throw ModelError(source, "/parameters", fmt::format("the model has no parameter '{}'", name),
                             suggestion(name, names) + listed(names));
        if (!std::isfinite(value))
            throw ModelError(source, "/parameters/" + name, fmt::format("{} is not finite", value),
                             "finite numbers");
        parameters[name] = value;
    }
    return parameters;
}

template <class T>
std::vector<T> read_list(const JsonInput& root, const char* key, T (*read)(const JsonInput&)) {
    std::vector<T> out;
    if (root.has(key))
        for (const JsonInput& item : root.at(key).items())
            out.push_back(read(item));
    return out;
}

} // namespace

Vec4 read_orientation(const JsonInput& in) {
    const auto parts = in.items(4, "Euler parameters (e0, e1, e2, e3)");
    Vec4 p;
    for (int i = 0; i < 4; ++i)
        p[i] = parts[i].number();
    const double norm = p.stableNorm();
    if (norm == 0)
        in.refuse(fmt::format("{} is no direction", in.shown()), "4 numbers that are not all zero");
    return std::abs(p.squaredNorm() - 1) < 1e-14 ? p : Vec4(p / norm);
}

Body read_body(const JsonInput& in) {
    in.expect_keys({"name", "mass", "inertia", "position", "orientation", "velocity", "angular_velocity",
                    "fixed", "hold", "start_position", "start_orientation"});
    Body body;
    body.name = in.at("name").text();
    body.fixed = in.has("fixed") && in.at("fixed").flag();
    if (!body.fixed || in.has("mass"))
        body.mass = in.at("mass").number();
    if (!body.fixed || in.has("inertia"))
        body.inertia = read_inertia(in.at("inertia"));
    if (in.has("position"))
        body.position = in.at("position").vector();
    if (in.has("orientation"))
        body.orientation = read_orientation(in.at("orientation"));
    if (in.has("velocity"))
        body.velocity = in.at("velocity").vector();
    if (in.has("angular_velocity"))
        body.angular_velocity = in.at("angular_velocity").vector();
    if (in.has("start_position"))
        body.start_position = in.at("start_position").vector();
    if (in.has("start_orientation"))
        body.start_orientation = read_orientation(in.at("start_orientation"));
    if (in.has("hold"))
        for (const JsonInput& item : in.at("hold").items())
            body.hold.push_back(item.text());
    return body;
}

Marker read_marker(const JsonInput& in) {
    in.expect_keys({"name", "body", "point", "frame"});
    return {in.at("name").text(), in.at("body").text(), read_body_frame(in), in.at("point").vector(), false};
}

bool read_body_frame(const JsonInput& in) {
    return in.has("frame") && in.at("frame").choice({"global", "body"}) == 1;
}

std::array<std::string, 2> read_body_pair(const JsonInput& in) {
    const auto names = in.at("bodies").items(2, "names: [a, b]");
    return {names[0].text(), names[1].text()};
}

std::array<Vec3, 2> read_points(const JsonInput& in, bool body_frame) {
    if (in.has("points")) {
        if (in.has("point"))
            in.at("point").refuse("'point' beside 'points'", "one of the two");
        const auto points = in.at("points").items(2, "points: [in a, in b]");
        return {points[0].vector(), points[1].vector()};
    }
    if (in.has("point") && body_frame)
        in.at("point").refuse("one point in two body frames",
                              "'points': [in a, in b] with \"frame\": \"body\"");
    const Vec3 point = in.at("point").vector();
    return {point, point};
}

Model parse_model(std::string_view text, std::string source, const std::map<std::string, double>& overrides) {
    const nlohmann::ordered_json document = parse_json(text, source);
    const JsonInput::Context context{source, read_parameters(document, source, overrides)};
    const JsonInput root(document, "", context);
    root.expect_keys({"gudgeon", "name", "gravity", "parameters", "bodies", "joints", "forces", "markers",
                      "beams", "onset", "end", "every"});
    check_version(root);

    Model model;
    model.source = std::move(source);
    model.parameters = context.parameters;
    if (root.has("name"))
        model.name = root.at("name").text();
    if (root.has("gravity"))
        model.gravity = root.at("gravity").vector();
    if (!root.has("beams"))
        root.at("bodies");
    model.bodies = read_list(root, "bodies", read_body);
    model.joints = read_list(root, "joints", read_joint);
    share_equal_parts(model);
    model.forces = read_list(root, "forces", read_force);
    model.markers = read_list(root, "markers", read_marker);
    model.beams = read_list(root, "beams", read_beam);
    if (root.has("end"))
        model.end = root.at("end").number();
    if (root.has("every"))
        model.every = root.at("every").number();
    if (root.has("onset"))
        model.onset = read_onset(root.at("onset"));
    validate(model);
    return model;
}

std::string read_model_text(const std::filesystem::path& file) {
    const std::string name = file.string();
    std::error_code error;
    if (std::filesystem::is_directory(file, error))
        throw FileError(fmt::format("{}: is a directory; allowed: a model file", name));
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        throw FileError(fmt::format("{}: cannot be opened: {}", name, std::strerror(errno)));
    std::ostringstream text;
    if (stream.peek() != std::ifstream::traits_type::eof())
        text << stream.rdbuf();
    if (stream.bad() || text.bad())
        throw FileError(fmt::format("{}: cannot be read", name));
    return std::move(text).str();
}

Model read_model(const std::filesystem::path& file, const std::map<std::string, double>& overrides) {
    return parse_model(read_model_text(file), file.string(), overrides);
}

} // namespace gudgeon

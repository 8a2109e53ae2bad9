#include "core/reader_parts.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

namespace {

BeamSection read_shape(const std::string& name, const JsonInput& in) {
    if (name == "round") {
        in.expect_keys({"diameter"});
        return RoundSection{in.at("diameter").number()};
    }
    if (name == "rectangle") {
        in.expect_keys({"width", "height"});
        return RectangleSection{in.at("width").number(), in.at("height").number()};
    }
    in.expect_keys({"outer", "inner"});
    return TubeSection{in.at("outer").number(), in.at("inner").number()};
}

BeamSection read_section(const JsonInput& in) {
    in.expect_keys({"area", "iy", "iz", "torsion", "shear", "round", "rectangle", "tube"});
    for (const char* name : {"round", "rectangle", "tube"}) {
        if (!in.has(name))
            continue;
        for (const auto& [key, member] : in.members())
            if (key != name)
                member.refuse(fmt::format("'{}' beside '{}'", key, name),
                              "one of round, rectangle, tube, or area, iy, iz, torsion");
        return read_shape(name, in.at(name));
    }
    GeneralSection section;
    section.area = in.at("area").number();
    section.iy = in.at("iy").number();
    section.iz = in.at("iz").number();
    section.torsion = in.at("torsion").number();
    if (in.has("shear")) {
        const auto factors = in.at("shear").items(2, "numbers: along y, along z");
        section.shear = {factors[0].number(), factors[1].number()};
    }
    return section;
}

BeamMaterial read_material(const JsonInput& in) {
    in.expect_keys({"young", "poisson", "density", "loss", "frequency"});
    BeamMaterial material{in.at("young").number(),
                          in.at("poisson").number(),
                          in.at("density").number(),
                          in.number("loss", 0),
                          {}};
    if (in.has("frequency"))
        material.frequency = in.at("frequency").number();
    return material;
}

int read_elements(const JsonInput& in) {
    const double number = in.number();
    if (number != std::floor(number) || !(std::abs(number) < 1e9))
        in.refuse(in.shown() + " is no number of elements", "a whole number from 1");
    return static_cast<int>(number);
}

} // namespace

Beam read_beam(const JsonInput& in) {
    in.expect_keys({"name", "points", "direction", "section", "material", "elements", "stretch", "velocity",
                    "angular_velocity", "start"});
    Beam beam;
    beam.name = in.at("name").text();
    const auto points = in.at("points").items(2, "points: [start, end]");
    beam.points = {points[0].vector(), points[1].vector()};
    if (in.has("direction"))
        beam.direction = in.at("direction").vector();
    beam.section = read_section(in.at("section"));
    beam.material = read_material(in.at("material"));
    beam.elements = read_elements(in.at("elements"));
    beam.stretch = !in.has("stretch") || in.at("stretch").flag();
    if (in.has("velocity"))
        beam.velocity = in.at("velocity").vector();
    if (in.has("angular_velocity"))
        beam.angular_velocity = in.at("angular_velocity").vector();
    if (in.has("start"))
        for (const JsonInput& pose : in.at("start").items()) {
            pose.expect_keys({"position", "orientation"});
            beam.start.push_back({pose.at("position").vector(), read_orientation(pose.at("orientation"))});
        }
    return beam;
}

} // namespace gudgeon

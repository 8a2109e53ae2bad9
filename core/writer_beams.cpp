#include "core/writer_parts.hpp"

#include <algorithm>

namespace gudgeon {

using Json = nlohmann::ordered_json;

namespace {

template <class Vector> Json numbers(const Vector& v) {
    Json out = Json::array();
    for (const double x : v)
        out.push_back(x);
    return out;
}

struct SectionWriter {
    Json operator()(const GeneralSection& s) const {
        return {{"area", s.area}, {"iy", s.iy}, {"iz", s.iz}, {"torsion", s.torsion}, {"shear", s.shear}};
    }
    Json operator()(const RoundSection& s) const { return {{"round", {{"diameter", s.diameter}}}}; }
    Json operator()(const RectangleSection& s) const {
        return {{"rectangle", {{"width", s.width}, {"height", s.height}}}};
    }
    Json operator()(const TubeSection& s) const {
        return {{"tube", {{"outer", s.outer}, {"inner", s.inner}}}};
    }
};

Json to_json(const BeamMaterial& m) {
    Json out{{"young", m.young}, {"poisson", m.poisson}, {"density", m.density}, {"loss", m.loss}};
    if (m.frequency)
        out["frequency"] = *m.frequency;
    return out;
}

Json to_json(const Beam::Pose& pose) {
    return {{"position", numbers(pose.position)}, {"orientation", numbers(pose.orientation)}};
}

/// Poses of the pieces at the start, if one of them has been moved.
std::vector<Beam::Pose> start_of(const Beam& beam, const Model& model) {
    if (!beam.expanded)
        return beam.start;
    const auto first =
        std::ranges::find_if(model.bodies, [&](const Body& b) { return b.name == beam.name + ".1"; });
    std::vector<Beam::Pose> poses;
    bool moved = false;
    for (auto body = first; body != first + beam.elements + 1; ++body) {
        moved = moved || body->start_position || body->start_orientation;
        poses.push_back({body->start_position.value_or(body->position),
                         body->start_orientation.value_or(body->orientation)});
    }
    return moved ? poses : std::vector<Beam::Pose>{};
}

} // namespace

Json to_json(const Beam& beam, const Model& model) {
    Json out{{"name", beam.name},
             {"points", Json::array({numbers(beam.points[0]), numbers(beam.points[1])})}};
    if (beam.direction)
        out["direction"] = numbers(*beam.direction);
    out["section"] = std::visit(SectionWriter{}, beam.section);
    out["material"] = to_json(beam.material);
    out["elements"] = beam.elements;
    if (!beam.stretch)
        out["stretch"] = false;
    if (!beam.velocity.isZero(0))
        out["velocity"] = numbers(beam.velocity);
    if (!beam.angular_velocity.isZero(0))
        out["angular_velocity"] = numbers(beam.angular_velocity);
    for (const Beam::Pose& pose : start_of(beam, model))
        out["start"].push_back(to_json(pose));
    return out;
}

} // namespace gudgeon

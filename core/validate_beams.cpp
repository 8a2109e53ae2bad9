// Beams: geometry, section, material, division.
#include "core/beam.hpp"
#include "core/validate_parts.hpp"

#include <fmt/format.h>

#include <cmath>

namespace gudgeon {

namespace {

constexpr int most_elements = 1000000;

struct SectionCheck {
    const Checker& check;
    std::string at;

    void operator()(const GeneralSection& s) const {
        check.positive(at, "area", s.area);
        check.positive(at, "iy", s.iy);
        check.positive(at, "iz", s.iz);
        check.positive(at, "torsion", s.torsion);
        if (s.torsion > (s.iy + s.iz) * (1 + 1e-9))
            check.refuse(at + "/torsion",
                         fmt::format("the torsion constant {} exceeds iy + iz = {}", s.torsion, s.iy + s.iz),
                         "at most iy + iz, which a circle reaches");
        for (std::size_t i = 0; i < 2; ++i) {
            const std::string index = std::to_string(i);
            check.positive(at + "/shear", index.c_str(), s.shear[i]);
            if (s.shear[i] > 1)
                check.refuse(at + "/shear/" + index, fmt::format("the shear factor {}", s.shear[i]),
                             "above 0 and at most 1");
        }
    }
    void operator()(const RoundSection& s) const { check.positive(at + "/round", "diameter", s.diameter); }
    void operator()(const RectangleSection& s) const {
        check.positive(at + "/rectangle", "width", s.width);
        check.positive(at + "/rectangle", "height", s.height);
    }
    void operator()(const TubeSection& s) const {
        check.positive(at + "/tube", "outer", s.outer);
        check.not_negative(at + "/tube", "inner", s.inner);
        if (s.inner >= s.outer)
            check.refuse(at + "/tube/inner",
                         fmt::format("the inner diameter {} is not below the outer {}", s.inner, s.outer),
                         "an inner diameter below the outer");
    }
};

void check_material(const Checker& check, const std::string& at, const BeamMaterial& m) {
    check.positive(at, "young", m.young);
    check.not_negative(at, "poisson", m.poisson);
    if (m.poisson > 0.5)
        check.refuse(at + "/poisson", fmt::format("Poisson's ratio {}", m.poisson), "from 0 to 0.5");
    check.positive(at, "density", m.density);
    check.not_negative(at, "loss", m.loss);
    if (m.frequency)
        check.positive(at, "frequency", *m.frequency);
}

void check_direction(const Checker& check, const std::string& at, const Beam& beam) {
    if (!beam.direction)
        return;
    check.direction(at + "/direction", *beam.direction);
    const Vec3 x = (beam.points[1] - beam.points[0]).normalized();
    if (x.cross(beam.direction->normalized()).norm() < 1e-6)
        check.refuse(at + "/direction", fmt::format("{} is along the beam", shown(*beam.direction)),
                     "a direction across the beam");
}

/// What follows from good numbers may still overflow or vanish.
void check_elements(const Checker& check, const std::string& at, const Beam& beam) {
    const ElementStiffness k = element_stiffness(beam);
    const double mass = beam.material.density * section_properties(beam.section, beam.material.poisson).area *
                        (beam.points[1] - beam.points[0]).norm() / beam.elements;
    for (const double x : {k.displacement.maxCoeff(), k.rotation.maxCoeff(), mass})
        if (!std::isfinite(x) || x <= 0)
            check.refuse(at + "/section", fmt::format("elements with a stiffness or a mass of {}", x),
                         "sections, materials and lengths of which all stiffnesses and masses are numbers");
}

void check_start(const Checker& check, const std::string& at, const Beam& beam) {
    if (!beam.start.empty() && beam.start.size() != static_cast<std::size_t>(beam.elements) + 1)
        check.refuse(at + "/start",
                     fmt::format("{} poses of {} rigid elements", beam.start.size(), beam.elements + 1),
                     "one pose for each rigid element");
    for (std::size_t i = 0; i < beam.start.size(); ++i) {
        const std::string pose = fmt::format("{}/start/{}", at, i);
        check.finite(pose, "position", beam.start[i].position);
        const Vec4& p = beam.start[i].orientation;
        if (!p.allFinite() || !(p.norm() > 1e-100 && p.norm() < 1e100))
            check.refuse(pose + "/orientation", "Euler parameters without a direction",
                         "four finite numbers that are not all zero");
    }
}

} // namespace

void check_beams(const Checker& check) {
    const auto& beams = check.model().beams;
    for (std::size_t i = 0; i < beams.size(); ++i) {
        const Beam& beam = beams[i];
        const std::string at = fmt::format("/beams/{}", i);
        for (std::size_t side = 0; side < 2; ++side)
            check.finite(at, fmt::format("points/{}", side), beam.points[side]);
        const double length = (beam.points[1] - beam.points[0]).stableNorm();
        if (length < 1e-100 || length > 1e100)
            check.refuse(
                at + "/points",
                fmt::format("{} and {} lie {} m apart", shown(beam.points[0]), shown(beam.points[1]), length),
                "two points with a distance");
        check_direction(check, at, beam);
        std::visit(SectionCheck{check, at + "/section"}, beam.section);
        check_material(check, at + "/material", beam.material);
        if (beam.elements < 1 || beam.elements > most_elements)
            check.refuse(at + "/elements", fmt::format("{} elements", beam.elements),
                         fmt::format("a whole number from 1 to {}", most_elements));
        check_elements(check, at, beam);
        check.finite(at, "velocity", beam.velocity);
        check.finite(at, "angular_velocity", beam.angular_velocity);
        check_start(check, at, beam);
    }
}

} // namespace gudgeon

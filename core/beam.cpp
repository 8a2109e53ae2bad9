#include "core/beam.hpp"

#include "core/relative_motion.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace gudgeon {

namespace {

/// Saint-Venant's torsion constant of a rectangle, sides a >= b.
double rectangle_torsion(double a, double b) {
    double sum = 0;
    for (int n = 29; n > 0; n -= 2) // small terms first; the next one is below 1e-7 of their sum
        sum += std::tanh(n * pi * a / (2 * b)) / std::pow(n, 5);
    return a * b * b * b / 3 * (1 - 192 * b / (std::pow(pi, 5) * a) * sum);
}

struct Properties {
    double nu;

    SectionProperties operator()(const GeneralSection& s) const {
        return {s.area, s.iy, s.iz, s.torsion, s.shear};
    }
    SectionProperties operator()(const RoundSection& s) const { return (*this)(TubeSection{s.diameter, 0}); }
    SectionProperties operator()(const RectangleSection& s) const {
        const double w = s.width, h = s.height, k = 10 * (1 + nu) / (12 + 11 * nu);
        return {w * h,
                w * h * h * h / 12,
                h * w * w * w / 12,
                rectangle_torsion(std::max(w, h), std::min(w, h)),
                {k, k}};
    }
    SectionProperties operator()(const TubeSection& s) const {
        const double m = s.inner / s.outer, q = (1 + m * m) * (1 + m * m);
        const double area = pi / 4 * (s.outer * s.outer - s.inner * s.inner);
        const double i = area * (s.outer * s.outer + s.inner * s.inner) / 16;
        const double k = 6 * (1 + nu) * q / ((7 + 6 * nu) * q + (20 + 12 * nu) * m * m);
        return {area, i, i, 2 * i, {k, k}};
    }
};

double length_of(const Beam& beam) { return (beam.points[1] - beam.points[0]).norm(); }

/// First bending frequency of the beam hinged at both ends about its softer axis, rad/s.
double first_bending(const BeamMaterial& material, const SectionProperties& s, double length) {
    const double wave = pi / length;
    return wave * wave * std::sqrt(material.young * std::min(s.iy, s.iz) / (material.density * s.area));
}

Vec4 parameters_of(const Mat3& axes) {
    const Eigen::Quaterniond q(axes);
    const Vec4 p(q.w(), q.x(), q.y(), q.z());
    return (p[0] < 0 ? -p : p).normalized();
}

/// Middles and lengths of the rigid elements along the beam.
double piece_length(const Beam& beam, int i) {
    const double d = length_of(beam) / beam.elements;
    return i == 0 || i == beam.elements ? d / 2 : d;
}

double piece_middle(const Beam& beam, int i) {
    const double d = length_of(beam) / beam.elements;
    return i == 0 ? d / 4 : i == beam.elements ? length_of(beam) - d / 4 : i * d;
}

std::string piece_name(const Beam& beam, int i) { return fmt::format("{}.{}", beam.name, i + 1); }

Body piece(const Beam& beam, const Mat3& axes, const SectionProperties& s, int i) {
    const double length = piece_length(beam, i), line = beam.material.density * length;
    const double arm = piece_middle(beam, i) - length_of(beam) / 2;
    Body body;
    body.name = piece_name(beam, i);
    body.piece = true;
    body.mass = line * s.area;
    const double slender = body.mass * length * length / 12;
    body.inertia = Vec3(line * (s.iy + s.iz), line * s.iy + slender, line * s.iz + slender).asDiagonal();
    body.position = beam.points[0] + piece_middle(beam, i) * axes.col(0);
    body.orientation = parameters_of(axes);
    body.velocity = beam.velocity + axes * beam.angular_velocity.cross(Vec3(arm, 0, 0));
    body.angular_velocity = beam.angular_velocity;
    if (!beam.start.empty()) {
        body.start_position = beam.start[static_cast<std::size_t>(i)].position;
        body.start_orientation = beam.start[static_cast<std::size_t>(i)].orientation;
    }
    return body;
}

/// Joint frame of the element: h, t and b along the beam's y, z and x.
Joint element(const Beam& beam, const Bushing& bushing, int i) {
    Joint joint;
    joint.name = fmt::format("{}.sde{}", beam.name, i + 1);
    joint.piece = true;
    joint.kind = JointKind::rigid;
    joint.bodies = {piece_name(beam, i), piece_name(beam, i + 1)};
    joint.body_frame = true;
    joint.points = {Vec3(piece_length(beam, i) / 2, 0, 0), Vec3(-piece_length(beam, i + 1) / 2, 0, 0)};
    joint.axes = {Vec3::UnitX(), Vec3::UnitX()};
    joint.references = {Vec3::UnitY(), Vec3::UnitY()};
    joint.bushing = bushing;
    if (beam.stretch) {
        joint.fidelity = Fidelity::bushing;
    } else {
        joint.motions[static_cast<std::size_t>(Motion::misalignment)] = Fidelity::bushing;
        joint.motions[static_cast<std::size_t>(Motion::rotation)] = Fidelity::bushing;
    }
    return joint;
}

Bushing element_bushing(const Beam& beam) {
    const ElementStiffness k = element_stiffness(beam);
    Bushing bushing;
    bushing.stiffness = {k.displacement[1], k.displacement[2], k.displacement[0],
                         k.rotation[1],     k.rotation[2],     k.rotation[0]};
    for (std::size_t i = 0; i < 6; ++i)
        bushing.damping[i] = k.relaxation * bushing.stiffness[i];
    return bushing;
}

void expand(Model& model, Beam& beam) {
    const Mat3 axes = beam_axes(beam);
    const SectionProperties section = section_properties(beam.section, beam.material.poisson);
    for (int i = 0; i <= beam.elements; ++i)
        model.bodies.push_back(piece(beam, axes, section, i));
    const Bushing bushing = element_bushing(beam);
    for (int i = 0; i < beam.elements; ++i)
        model.joints.push_back(element(beam, bushing, i));
    const double half = piece_length(beam, 0) / 2;
    model.markers.push_back({beam.name + ".start", piece_name(beam, 0), true, {-half, 0, 0}, true});
    model.markers.push_back({beam.name + ".end", piece_name(beam, beam.elements), true, {half, 0, 0}, true});
    beam.expanded = true;
}

/// Calls rename(name) for every name of a body in joints, forces and markers.
template <class Rename> void for_each_body_name(Model& model, const Rename& rename) {
    for (Joint& joint : model.joints)
        for (std::string& name : joint.bodies)
            rename(name);
    for (Force& force : model.forces)
        std::visit(
            [&](auto& f) {
                if constexpr (requires { f.bodies; })
                    for (std::string& name : f.bodies)
                        rename(name);
                else if constexpr (requires { f.body; })
                    rename(f.body);
            },
            force);
    for (Marker& marker : model.markers)
        rename(marker.body);
}

} // namespace

SectionProperties section_properties(const BeamSection& section, double poisson) {
    return std::visit(Properties{poisson}, section);
}

ElementStiffness element_stiffness(const Beam& beam) {
    const BeamMaterial& m = beam.material;
    const SectionProperties s = section_properties(beam.section, m.poisson);
    const double d = length_of(beam) / beam.elements, shear = m.young / (2 * (1 + m.poisson));
    const double omega = m.frequency ? 2 * pi * *m.frequency : first_bending(m, s, length_of(beam));
    return {Vec3(m.young * s.area, shear * s.area * s.shear[0], shear * s.area * s.shear[1]) / d,
            Vec3(shear * s.torsion, m.young * s.iy, m.young * s.iz) / d, m.loss / omega};
}

Mat3 beam_axes(const Beam& beam) {
    const Vec3 along = beam.points[1] - beam.points[0];
    const Mat3 triad = beam.direction ? joint_triad(along, *beam.direction) : joint_triad(along);
    Mat3 axes;
    axes << triad.col(2), triad.col(0), triad.col(1);
    return axes;
}

bool has_unexpanded_beams(const Model& model) { return !std::ranges::all_of(model.beams, &Beam::expanded); }

void expand_beams(Model& model) {
    std::map<std::string, std::string, std::less<>> ends;
    for (Beam& beam : model.beams) {
        if (beam.expanded)
            continue;
        ends[beam.name + ".start"] = piece_name(beam, 0);
        ends[beam.name + ".end"] = piece_name(beam, beam.elements);
        expand(model, beam);
    }
    if (ends.empty())
        return;
    for_each_body_name(model, [&](std::string& name) {
        if (const auto end = ends.find(name); end != ends.end())
            name = end->second;
    });
    share_equal_parts(model);
}

} // namespace gudgeon

#include "core/beam.hpp"
#include "core/validate_parts.hpp"
#include "core/words.hpp"

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace gudgeon {

namespace {

std::string message(const std::string& source, const std::string& pointer, const std::string& problem,
                    const std::string& allowed) {
    return fmt::format("{}: {}{}{}; allowed: {}", source.empty() ? "model" : source, pointer,
                       pointer.empty() ? "" : ": ", problem, allowed);
}

/// Pieces of beams have a dot in their names, which nothing else may have.
bool is_name(const std::string& name, bool dot = false) {
    const auto good = [dot](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
               c == '-' || (dot && c == '.');
    };
    return !name.empty() && std::ranges::all_of(name, good);
}

/// Bodies, joints, forces, markers and beams share the names of the output columns.
class Names {
  public:
    explicit Names(const Checker& check) : check_(check) {}

    void add(const std::string& at, const std::string& name, bool piece = false) {
        const std::string pointer = at + "/name";
        if (!is_name(name, piece))
            check_.refuse(pointer, name.empty() ? "an empty name" : fmt::format("the name '{}'", name),
                          "letters, digits, _ and -");
        if (name == "ground" || name == "t" || name == "energy")
            check_.refuse(pointer, fmt::format("the name '{}' is taken", name),
                          "names other than ground, t, energy");
        if (const auto [first, is_new] = seen_.emplace(name, at); !is_new)
            check_.refuse(pointer, fmt::format("the name '{}' is that of {} already", name, first->second),
                          "a different name for every body, joint, force, marker and beam");
    }

  private:
    const Checker& check_;
    std::map<std::string, std::string> seen_;
};

void check_names(const Checker& check) {
    const Model& m = check.model();
    // The name of a model becomes that of a directory.
    if (m.name.empty() || m.name == "." || m.name == ".." || std::ranges::any_of(m.name, [](char c) {
            return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 32;
        }))
        check.refuse("/name", fmt::format("the name '{}'", m.name), "a name that can be that of a directory");
    Names names(check);
    for (std::size_t i = 0; i < m.bodies.size(); ++i)
        names.add(fmt::format("/bodies/{}", i), m.bodies[i].name, m.bodies[i].piece);
    for (std::size_t i = 0; i < m.joints.size(); ++i)
        names.add(fmt::format("/joints/{}", i), m.joints[i].name, m.joints[i].piece);
    for (std::size_t i = 0; i < m.forces.size(); ++i)
        names.add(fmt::format("/forces/{}", i),
                  std::visit([](const auto& f) { return f.name; }, m.forces[i]));
    for (std::size_t i = 0; i < m.markers.size(); ++i)
        names.add(fmt::format("/markers/{}", i), m.markers[i].name, m.markers[i].piece);
    for (std::size_t i = 0; i < m.beams.size(); ++i)
        names.add(fmt::format("/beams/{}", i), m.beams[i].name);
}

void check_symmetric(const Checker& check, const std::string& at, const Mat3& inertia) {
    const double scale = inertia.cwiseAbs().maxCoeff();
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) {
            if (!std::isfinite(inertia(i, j)))
                check.refuse(at, fmt::format("{} is not finite", inertia(i, j)), "finite numbers");
            if (std::abs(inertia(i, j) - inertia(j, i)) > 1e-9 * scale)
                check.refuse(at, fmt::format("not symmetric: {} against {}", inertia(i, j), inertia(j, i)),
                             "a symmetric matrix");
        }
}

/// Principal moments of a real body are positive and none exceeds the sum of the others (it reaches
/// the sum for a lamina or a thin bar).
void check_inertia(const Checker& check, const std::string& at, const Mat3& inertia) {
    check_symmetric(check, at, inertia);
    Vec3 principal = inertia.diagonal();
    double round_off = 0;
    if (inertia != Mat3(principal.asDiagonal())) {
        // Scaled, so that the solver sees no extreme numbers.
        const double scale = inertia.cwiseAbs().maxCoeff();
        const Eigen::SelfAdjointEigenSolver<Mat3> solver(inertia / scale, Eigen::EigenvaluesOnly);
        principal = solver.eigenvalues() * scale;
        round_off = 1e-14 * scale;
    }
    if (principal.minCoeff() <= round_off)
        check.refuse(at, fmt::format("the principal moment {:.12g} is not positive", principal.minCoeff()),
                     "principal moments above 0");
    std::sort(principal.data(), principal.data() + 3);
    if (principal[2] - principal[1] - principal[0] > 1e-9 * principal[2])
        check.refuse(at,
                     fmt::format("the principal moment {:.12g} exceeds the sum of {:.12g} and {:.12g}",
                                 principal[2], principal[0], principal[1]),
                     "principal moments of which none exceeds the sum of the others");
}

void check_hold(const Checker& check, const std::string& at, const Body& body) {
    static const std::vector<std::string> known{"x",  "y",  "z",  "rx", "ry", "rz",
                                                "vx", "vy", "vz", "wx", "wy", "wz"};
    for (std::size_t i = 0; i < body.hold.size(); ++i) {
        const auto entry = body.hold.begin() + static_cast<std::ptrdiff_t>(i);
        if (std::ranges::find(known, *entry) == known.end())
            check.refuse(fmt::format("{}/hold/{}", at, i), fmt::format("unknown coordinate '{}'", *entry),
                         listed(known));
        if (std::find(body.hold.begin(), entry, *entry) != entry)
            check.refuse(fmt::format("{}/hold/{}", at, i), fmt::format("'{}' is repeated", *entry),
                         "each coordinate once");
    }
}

void check_body(const Checker& check, const std::string& at, const Body& body) {
    if (!body.fixed) {
        check.positive(at, "mass", body.mass);
        check_inertia(check, at + "/inertia", body.inertia);
    }
    check.finite(at, "position", body.position);
    for (int i = 0; i < 4; ++i)
        if (!std::isfinite(body.orientation[i]))
            check.refuse(fmt::format("{}/orientation/{}", at, i),
                         fmt::format("{} is not finite", body.orientation[i]), "finite numbers");
    if (body.start_position && !body.start_position->allFinite())
        check.refuse(at + "/start_position", "it is not finite", "finite numbers");
    if (body.start_orientation &&
        !(body.start_orientation->allFinite() && body.start_orientation->norm() > 1e-100 &&
          body.start_orientation->norm() < 1e100))
        check.refuse(at + "/start_orientation", "Euler parameters without a direction",
                     "four finite numbers that are not all zero");
    if (const double norm = body.orientation.stableNorm(); norm < 1e-100 || norm > 1e100)
        check.refuse(at + "/orientation", fmt::format("Euler parameters of length {}", norm),
                     "4 numbers that are not all zero");
    check.finite(at, "velocity", body.velocity);
    check.finite(at, "angular_velocity", body.angular_velocity);
    if (body.fixed && !body.velocity.isZero(0))
        check.refuse(at + "/velocity",
                     fmt::format("the fixed body has the velocity {}", shown(body.velocity)),
                     "(0, 0, 0) or a body that is not fixed");
    if (body.fixed && !body.angular_velocity.isZero(0))
        check.refuse(at + "/angular_velocity",
                     fmt::format("the fixed body has the angular velocity {}", shown(body.angular_velocity)),
                     "(0, 0, 0) or a body that is not fixed");
    check_hold(check, at, body);
}

void check_bodies(const Checker& check) {
    const auto& bodies = check.model().bodies;
    for (std::size_t i = 0; i < bodies.size(); ++i)
        check_body(check, fmt::format("/bodies/{}", i), bodies[i]);
    if (has_unexpanded_beams(check.model()))
        return;
    if (bodies.empty())
        check.refuse("/bodies", "the model has no bodies: []", "at least one body that is not fixed");
    if (std::ranges::all_of(bodies, &Body::fixed))
        check.refuse("/bodies", "every body is fixed", "at least one body that is not fixed");
}

void check_parameters(const Checker& check) {
    for (const auto& [name, value] : check.model().parameters) {
        if (!is_name(name))
            check.refuse("/parameters/" + name, fmt::format("the name '{}'", name),
                         "letters, digits, _ and -");
        check.finite("/parameters", name.c_str(), value);
    }
}

void check_onset(const Checker& check, const Model::Onset& onset) {
    std::vector<std::string> given;
    const auto threshold = [&](const char* member, const std::optional<double>& value) {
        if (!value)
            return;
        check.positive("/onset", member, *value);
        if (!given.empty())
            check.refuse(fmt::format("/onset/{}", member), fmt::format("'{}' beside '{}'", member, given[0]),
                         "one of depth, force, energy");
        given.emplace_back(member);
    };
    threshold("depth", onset.depth);
    threshold("force", onset.force);
    threshold("energy", onset.energy);
}

void check_between_bodies(const Checker& check) {
    check_joints(check);
    check_forces(check);
    const auto& markers = check.model().markers;
    for (std::size_t i = 0; i < markers.size(); ++i) {
        const std::string at = fmt::format("/markers/{}", i);
        check.body_exists(at + "/body", markers[i].body);
        check.finite(at, "point", markers[i].point);
    }
}

} // namespace

ModelError::ModelError(std::string source, std::string pointer, std::string problem, std::string allowed)
    : std::runtime_error(message(source, pointer, problem, allowed)), pointer_(std::move(pointer)),
      problem_(std::move(problem)), allowed_(std::move(allowed)) {}

void validate(const Model& model) {
    const Checker check(model);
    check_parameters(check);
    check.finite("", "gravity", model.gravity);
    check_names(check);
    check_bodies(check);
    check_beams(check);
    if (has_unexpanded_beams(model)) { // joints and forces may name their pieces
        Model whole = model;
        expand_beams(whole);
        check_between_bodies(Checker(whole));
    } else {
        check_between_bodies(check);
    }
    check_onset(check, model.onset);
    if (model.end)
        check.positive("", "end", *model.end);
    if (model.every)
        check.positive("", "every", *model.every);
}

} // namespace gudgeon

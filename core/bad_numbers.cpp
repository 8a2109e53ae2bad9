#include "core/bad_numbers.hpp"

#include "core/assembly.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>

namespace gudgeon {

namespace {

std::string numbers(const Vec3& x) { return fmt::format("({:.6g}, {:.6g}, {:.6g})", x[0], x[1], x[2]); }

/// Position and velocities, as they were when something went wrong.
std::string body_state(const System& system, const Workspace& ws, int body) {
    if (body < 0 || body >= system.moving)
        return "";
    const BodyMotion& m = ws.motion[body];
    return fmt::format("; body '{}' at {} m, velocity {} m/s, angular velocity {} rad/s",
                       system.body_names[body], numbers(m.r), numbers(m.v), numbers(m.w));
}

std::string element(const System& system, const Workspace& ws, const ForceBatch& batch,
                    const ElementName& x) {
    const std::string name = x.joint >= 0      ? fmt::format(" of joint '{}'", system.joints[x.joint].name)
                             : !x.name.empty() ? fmt::format(" '{}'", x.name)
                                               : "";
    return fmt::format("{}{} between '{}' and '{}'{}{}", batch.kind(), name, system.body_names[x.a],
                       system.body_names[x.b], body_state(system, ws, x.a), body_state(system, ws, x.b));
}

std::string bad_motion(const System& system, const Workspace& ws) {
    for (int i = 0; i < system.moving; ++i) {
        const BodyMotion& m = ws.motion[i];
        if (!m.r.allFinite() || !m.p.allFinite() || !m.v.allFinite() || !m.w.allFinite())
            return fmt::format("the motion of body '{}'{}", system.body_names[i], body_state(system, ws, i));
        if (!ws.external.segment<6>(6 * i).allFinite())
            return fmt::format("the load set on body '{}'", system.body_names[i]);
    }
    return "";
}

std::string bad_constraint(const System& system, const Evaluation& e, Workspace& ws) {
    VecX gamma = VecX::Zero(system.row_count());
    for (const auto& batch : system.constraints)
        batch->acceleration_rhs(e, gamma.data());
    for (int r = 0; r < system.row_count(); ++r)
        if (!std::isfinite(ws.phi[r]) || !std::isfinite(ws.rate[r]) || !std::isfinite(gamma[r]))
            return constraint_name(system, r) + body_state(system, ws, system.rows[r].b);
    for (int r = 0; r < system.row_count(); ++r)
        if (!std::isfinite(ws.lambda[r]))
            return "the reaction of " + constraint_name(system, r) + body_state(system, ws, system.rows[r].b);
    return "";
}

std::string bad_part(const System& system, double t, Workspace& ws) {
    if (std::string found = bad_motion(system, ws); !found.empty())
        return found;
    const Evaluation e = evaluation(system, ws, t);
    for (const auto& batch : system.forces)
        if (const auto x = batch->find_bad(e))
            return element(system, ws, *batch, *x);
    evaluate_forces(system, t, ws);
    evaluate_constraints(system, t, nullptr, false, ws);
    if (std::string found = bad_constraint(system, e, ws); !found.empty())
        return found;
    for (int i = 0; i < system.moving; ++i)
        if (!ws.f.segment<6>(6 * i).allFinite())
            return fmt::format("the force on body '{}'{}", system.body_names[i], body_state(system, ws, i));
    if (!ws.z.allFinite())
        return "a friction state";
    return "";
}

} // namespace

std::string find_bad_number(const System& system, double t, Workspace& ws) {
    const std::string part = bad_part(system, t, ws);
    return part.empty() ? part : fmt::format("no finite number at t = {:.9g} s: {}", t, part);
}

std::string constraint_name(const System& system, int row) {
    const RowRecord& r = system.rows[row];
    return fmt::format("joint '{}' ({}) between '{}' and '{}'", system.joints[r.joint].name, r.direction,
                       system.body_names[r.a], system.body_names[r.b]);
}

std::string unknown_name(const System& system, int unknown) {
    static constexpr std::array<const char*, 6> part{"vx", "vy", "vz", "wx", "wy", "wz"};
    if (unknown < 0)
        return "an unknown that is not known";
    if (unknown < system.velocities())
        return fmt::format("body '{}' ({})", system.body_names[unknown / 6], part[unknown % 6]);
    return constraint_name(system, unknown - system.velocities());
}

std::string contact_name(const System& system, int channel) {
    const ContactChannel& c = system.contacts[channel];
    const std::string number = c.number > 0 ? fmt::format(" {}", c.number) : "";
    return fmt::format("joint '{}' ({}{})", system.joints[c.joint].name, c.place, number);
}

} // namespace gudgeon

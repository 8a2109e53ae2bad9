#include "app/run_record.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

namespace {

using nlohmann::ordered_json;

/// CPU seconds by phase: wall-clock shares of the time loop, scaled to the CPU time it took.
ordered_json phases(const PhaseTimes& now, const RunRecord& record) {
    const PhaseTimes& before = record.setup_phases;
    const std::pair<const char*, double> spent[] = {
        {"evaluate", now.evaluate - before.evaluate},
        {"assemble", now.assemble - before.assemble},
        {"factor", now.factor - before.factor},
        {"solve", now.solve - before.solve},
        {"control", now.control - before.control},
        {"contact", now.contact - before.contact},
        {"output", now.output - before.output + record.write_seconds}};
    const double scale = record.wall_seconds > 0 ? record.cpu_seconds / record.wall_seconds : 0;
    ordered_json out{{"setup", record.setup_seconds}};
    double rest = record.cpu_seconds;
    for (const auto& [name, seconds] : spent) {
        out[name] = scale * seconds;
        rest -= scale * seconds;
    }
    out["other"] = std::max(rest, 0.0);
    return out;
}

ordered_json assembly_json(const System& system, const AssemblyReport& report) {
    ordered_json changes = ordered_json::object();
    for (const AssemblyReport::Change& c : report.changes)
        changes[system.body_names[c.body]] = {{"shift", c.shift},
                                              {"turn", c.turn},
                                              {"velocity", c.velocity},
                                              {"angular_velocity", c.angular_velocity}};
    return {{"position_before", report.position_before},
            {"velocity_before", report.velocity_before},
            {"position_after", report.position_after},
            {"velocity_after", report.velocity_after},
            {"changes", changes}};
}

ordered_json settings(const RunArguments& given, const SimulationOptions& used, const OutputGrid& grid) {
    ordered_json typed(given.given);
    if (given.given.empty())
        typed = ordered_json::object();
    if (!given.channels.empty())
        typed["--channels"] = given.channels;
    const IntegratorOptions& o = used.integration;
    ordered_json out{{"integrator", used.integrator},
                     {"formulation", formulation_name(o.formulation)},
                     {"rtol", o.rtol},
                     {"atol", o.atol},
                     {"step", o.step},
                     {"max_order", o.max_order},
                     {"end", grid.end()},
                     {"every", grid.every()},
                     {"threads", o.threads},
                     {"onset", onset_name(o.onset)},
                     {"start", given.start}};
    return {{"given", typed}, {"used", out}};
}

void add_counts(ordered_json& out, const Statistics& s) {
    out["steps"] = s.steps;
    out["rejected_error"] = s.rejected_error;
    out["rejected_newton"] = s.rejected_newton;
    out["rejected_contact"] = s.rejected_contact;
    out["deep_starts"] = s.deep_starts;
    out["softened_at"] = s.softened_at; // null: never
    out["newton_sweeps"] = s.newton_sweeps;
    out["constraint_polish"] = s.constraint_polish;
    out["evaluations"] = s.evaluations;
    out["factorisations"] = s.factorisations;
    out["refactorisations"] = s.refactorisations;
    out["cholmod_factorisations"] = s.cholmod_factorisations;
    out["cholmod_solves"] = s.cholmod_solves;
    out["cholmod_iterations"] = s.cholmod_iterations;
    out["klu_fallbacks"] = s.klu_fallbacks;
    out["order_histogram"] = s.order_histogram;
    out["smallest_step"] = s.smallest_step; // null before the first step
    out["largest_step"] = s.largest_step;
    out["nnz_matrix"] = s.nnz_matrix;
    out["nnz_factors"] = s.nnz_factors;
    out["constraint_position_max"] = s.constraint_position_max;
    out["constraint_velocity_max"] = s.constraint_velocity_max;
}

bool rotations_only(const System& system, int joint) {
    return std::ranges::none_of(system.contacts,
                                [&](const ContactChannel& c) { return c.joint == joint && !c.rotation; });
}

ordered_json rank_changes_json(const Simulation& sim) {
    ordered_json out = ordered_json::array();
    for (const RankChange& change : sim.rank_changes())
        out.push_back({{"t", change.t},
                       {"redundant", change.now.dependent.size()},
                       {"dof", change.now.dof},
                       {"lines", change.now.lines(sim.system())}});
    return out;
}

ordered_json contacts_json(const Simulation& sim, double reached) {
    const System& system = sim.system();
    const State state = sim.state();
    ordered_json out = ordered_json::object();
    for (std::size_t i = 0; i < system.contact_joints.size(); ++i) {
        const ContactHistory& h = state.history[i];
        const bool turns = rotations_only(system, system.contact_joints[i]);
        out[system.joints[system.contact_joints[i]].name] = {
            {"impacts", h.impacts},
            {"deepest", turns ? h.deepest_angle : h.deepest},
            {"peak_force", turns ? h.peak_moment : h.peak_force},
            {"share", reached > 0 ? h.touching / reached : 0.0},
            {"energy_lost", state.work[2 + static_cast<Eigen::Index>(i)]}};
        if (!turns && h.peak_moment > 0) {
            auto& joint = out[system.joints[system.contact_joints[i]].name];
            joint["deepest_angle"] = h.deepest_angle;
            joint["peak_moment"] = h.peak_moment;
        }
    }
    return out;
}

// Which method ran from when on, and why it was chosen.
ordered_json uses_json(const Simulation& sim) {
    ordered_json out = ordered_json::array();
    for (const IntegratorUse& use : sim.integrator_uses())
        out.push_back({{"from", use.from}, {"integrator", use.name}, {"why", use.why}});
    return out;
}

} // namespace

void RunRecord::visit(Archive& archive) {
    archive(samples, columns, balance_max, setup_seconds, cpu_seconds, wall_seconds, write_seconds,
            setup_phases, restarts);
}

const char* status_name(RunRecord::Status status) {
    switch (status) {
    case RunRecord::Status::ok:
        return "ok";
    case RunRecord::Status::interrupted:
        return "interrupted";
    case RunRecord::Status::failed:
        break;
    }
    return "failed";
}

ordered_json summary(const RunArguments& arguments, const SimulationOptions& used, const LoadedModel& loaded,
                     const Simulation& sim, const OutputGrid& grid, const RunRecord& record) {
    const System& system = sim.system();
    const Statistics& statistics = sim.statistics();
    const IntegratorOptions& options = used.integration;
    ordered_json out{{"model", loaded.model.name},
                     {"source", loaded.model.source},
                     {"version", GUDGEON_VERSION},
                     {"parameters", loaded.parameters},
                     {"status", status_name(record.status)},
                     {"reason", record.reason},
                     {"end", grid.end()},
                     {"reached", record.reached},
                     {"every", grid.every()},
                     {"samples", record.samples},
                     {"columns", record.columns},
                     {"integrator", sim.integrator_name()},
                     {"integrators_used", uses_json(sim)},
                     {"restarts", record.restarts},
                     {"formulation", sim.formulation()},
                     {"linear_solver", sim.linear_solver()},
                     {"rtol", options.rtol},
                     {"atol", options.atol},
                     {"threads", options.threads},
                     {"settings", settings(arguments, used, grid)},
                     {"bodies", system.model.bodies.size()},
                     {"bodies_fixed", system.model.bodies.size() - static_cast<std::size_t>(system.moving)},
                     {"unknowns", system.velocities() + system.row_count()},
                     {"constraint_rows", system.row_count()},
                     {"dof", sim.redundancy().dof},
                     {"redundant", sim.redundancy().dependent.size()},
                     {"redundant_lines", sim.redundancy().lines(system)},
                     {"reaction_length", reaction_length(system)},
                     {"rank_changes", rank_changes_json(sim)},
                     {"assembly", assembly_json(system, sim.assembly())},
                     {"notices", sim.notices()}};
    if (sim.statics())
        out["equilibrium"] = statics_json(system, *sim.statics());
    add_counts(out, statistics);
    out["energy_balance_max"] = record.balance_max;
    out["cpu_seconds"] = record.cpu_seconds;
    out["cpu_seconds_by_phase"] = phases(statistics.seconds, record);
    out["wall_seconds"] = record.wall_seconds;
    out["contacts"] = contacts_json(sim, record.reached);
    return out;
}

std::string assembly_report(const System& system, const AssemblyReport& report) {
    constexpr double noticeable = 1e-9;
    std::vector<AssemblyReport::Change> changes;
    const auto size = [](const AssemblyReport::Change& c) {
        return std::max({c.shift, c.turn, c.velocity, c.angular_velocity});
    };
    for (const AssemblyReport::Change& c : report.changes)
        if (size(c) > noticeable)
            changes.push_back(c);
    if (changes.empty())
        return "";
    std::ranges::stable_sort(changes, std::ranges::greater{}, size);
    std::string text = fmt::format(
        "The start was assembled: constraints violated by {:.3g} m (speeds {:.3g} m/s) "
        "as given, {:.3g} m ({:.3g} m/s) now.\n",
        report.position_before, report.velocity_before, report.position_after, report.velocity_after);
    constexpr std::size_t most = 8;
    for (std::size_t i = 0; i < std::min(changes.size(), most); ++i) {
        const AssemblyReport::Change& c = changes[i];
        text += fmt::format(
            "  {}: moved {:.3g} m, turned {:.3g} rad, velocity {:.3g} m/s, angular velocity {:.3g} rad/s\n",
            system.body_names[c.body], c.shift, c.turn, c.velocity, c.angular_velocity);
    }
    if (changes.size() > most)
        text += fmt::format("  and {} bodies more\n", changes.size() - most);
    return text;
}

ordered_json statics_json(const System& system, const StaticsReport& report) {
    ordered_json moved = ordered_json::object(), neutral = ordered_json::array();
    for (const AssemblyReport::Change& c : report.moved)
        moved[system.body_names[c.body]] = {{"shift", c.shift}, {"turn", c.turn}};
    for (const NeutralDirection& n : report.neutral) {
        ordered_json bodies = ordered_json::object();
        for (int i = 0; i < system.moving; ++i)
            if (const Vec6 x = n.direction.segment<6>(6 * i); !x.isZero(1e-12))
                bodies[system.body_names[i]] = std::vector<double>(x.begin(), x.end());
        neutral.push_back({{"motion", n.words}, {"direction", bodies}});
    }
    return {{"residual", report.residual},
            {"force_scale", report.force_scale},
            {"relative_residual", report.relative_residual()},
            {"constraint_position_max", report.constraint},
            {"energy_before", report.energy_before},
            {"energy_after", report.energy_after},
            {"steps", report.steps},
            {"relaxation_steps", report.relaxation_steps},
            {"factorisations", report.factorisations},
            {"unstable", report.unstable},
            {"neutral", neutral},
            {"moved", moved}};
}

std::string equilibrium_report(const System& system, const StaticsReport& report) {
    std::vector<AssemblyReport::Change> moved = report.moved;
    std::ranges::stable_sort(moved, std::ranges::greater{},
                             [](const AssemblyReport::Change& c) { return std::max(c.shift, c.turn); });
    std::string text = fmt::format(
        "Equilibrium: {:.2g} of {:.4g} N (N m) left over after {} steps{}; energy {:.6g} J, "
        "{:.3g} J below the start.\n",
        report.residual, report.force_scale, report.steps,
        report.relaxation_steps ? fmt::format(" and {} of relaxation", report.relaxation_steps) : "",
        report.energy_after, report.energy_before - report.energy_after);
    constexpr std::size_t most = 8;
    for (std::size_t i = 0; i < std::min(moved.size(), most); ++i)
        text += fmt::format("  {}: moved {:.3g} m, turned {:.3g} rad\n", system.body_names[moved[i].body],
                            moved[i].shift, moved[i].turn);
    if (moved.size() > most)
        text += fmt::format("  and {} bodies more\n", moved.size() - most);
    return text;
}

std::string notice_report(const std::vector<std::string>& notices) {
    std::string text;
    for (const std::string& notice : notices)
        text += fmt::format("Notice: {}.\n", notice);
    return text;
}

/// "gear (saddle-point, blocks)", "auto: erk (tree), an open tree ..."
std::string method_in_words(const Simulation& sim) {
    const std::string solver = sim.linear_solver();
    const std::string how = solver == "none" ? "(" + std::string(sim.formulation()) + ")"
                                             : fmt::format("({}, {})", sim.formulation(), solver);
    std::string text = fmt::format("{} {}", sim.integrator_name(), how);
    if (const std::vector<IntegratorUse> uses = sim.integrator_uses();
        sim.integrator_name() == std::string("auto"))
        for (const IntegratorUse& use : uses)
            text += fmt::format("; {} since {:.6g} s: {}", use.name, use.from, use.why);
    return text;
}

std::string run_report(const LoadedModel& loaded, const Simulation& sim, const RunRecord& record,
                       const std::filesystem::path& folder) {
    const Statistics& s = sim.statistics();
    std::string text = fmt::format(
        "{}: {:.6g} s simulated by {} in {:.3g} s of CPU time, {:.3g} s to set up\n", loaded.model.name,
        record.reached, method_in_words(sim), record.cpu_seconds, record.setup_seconds);
    if (record.status == RunRecord::Status::interrupted)
        text += "  interrupted; what was computed is written\n";
    for (const double t : record.restarts)
        text += fmt::format("  {} started anew from the checkpoint at t = {:.9g} s: the same within the "
                            "tolerances, not to the last bit\n",
                            sim.integrator_name(), t);
    text += fmt::format(
        "  steps: {}, rejected: {} by error, {} by Newton, {} by contact; a step took {:.2f} sweeps and "
        "{:.2f} solves to close the constraints\n",
        s.steps, s.rejected_error, s.rejected_newton, s.rejected_contact,
        static_cast<double>(s.newton_sweeps) / static_cast<double>(std::max(s.steps, 1L)),
        static_cast<double>(s.constraint_polish) / static_cast<double>(std::max(s.steps, 1L)));
    if (const std::size_t repeated = sim.redundancy().dependent.size(); repeated > 0)
        text +=
            fmt::format("  {} of {} constraint rows repeat others ({} degrees of freedom): least reactions, "
                        "moments compared by {:.3g} m\n",
                        repeated, sim.redundancy().rows, sim.redundancy().dof, reaction_length(sim.system()));
    for (const RankChange& change : sim.rank_changes())
        text += fmt::format("  at t = {:.6g} s {} rows repeat others, {} degrees of freedom\n", change.t,
                            change.now.dependent.size(), change.now.dof);
    long impacts = 0;
    for (const ContactHistory& h : sim.state().history)
        impacts += h.impacts;
    if (!sim.system().contact_joints.empty())
        text +=
            fmt::format("  {} starts of contact in {} joints\n", impacts, sim.system().contact_joints.size());
    if (s.deep_starts > 0)
        text += fmt::format("  {} of them deeper than the threshold, where forces are too large: with "
                            "rk4 or bayo take a smaller --step\n",
                            s.deep_starts);
    text += fmt::format(
        "  constraints violated by at most {:.2g} m and {:.2g} m/s; energy balance within {:.2g} J\n",
        s.constraint_position_max, s.constraint_velocity_max, record.balance_max);
    text += fmt::format("  {} times x {} columns in {}, trajectory.h5; summary.json\n", record.samples,
                        record.columns, (folder / "trajectory.csv").string());
    return text;
}

} // namespace gudgeon

#include "app/rest.hpp"

#include "app/exit_codes.hpp"
#include "app/file_tools.hpp"
#include "app/load_model.hpp"
#include "app/numbers.hpp"
#include "app/run_record.hpp"
#include "contact/standard_forces.hpp"
#include "core/writer.hpp"
#include "solvers/consistent.hpp"
#include "solvers/modes.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t most_lines = 40; // of a table on the terminal

ordered_json numbers(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

struct Assembled {
    LoadedModel loaded;
    System system;
    State state;
};

Assembled assemble(const RestArguments& arguments, bool friction, const Console& console) {
    LoadedModel loaded = load_model(arguments.model);
    System system =
        compile(friction ? loaded.model : without_friction(loaded.model), standard_force_builders());
    State state = initial_state(system);
    const AssemblyReport report = assemble_start(system, state);
    if (!report.ok)
        throw AssemblyError("the mechanism cannot be assembled: " + report.message(system), report);
    if (!arguments.quiet)
        console.out << assembly_report(system, report);
    return {std::move(loaded), std::move(system), std::move(state)};
}

StaticsReport settle(const System& system, State& state) {
    StaticsReport report = find_equilibrium(system, state);
    if (!report.ok)
        throw EquilibriumError(report.message, report);
    return report;
}

/// What to know of modes about a state at rest that does not stay there; empty: nothing.
std::vector<std::string> unrest(const System& system, const State& state) {
    constexpr double at_rest = 1e-6; // m/s, rad/s; m/s2, rad/s2
    if (system.moving == 0 || state.u.cwiseAbs().maxCoeff() > at_rest)
        return {};
    Workspace ws = make_workspace(system);
    ws.remember(state);
    ConsistentSolver consistent(system);
    consistent.soften();
    VecX acceleration, lambda;
    if (!consistent.accelerations(state.t, state.q, state.u, ws, acceleration, lambda))
        return {};
    Eigen::Index most;
    const double largest = acceleration.cwiseAbs().maxCoeff(&most);
    if (largest <= at_rest)
        return {};
    return {fmt::format("the state is no equilibrium: '{}' accelerates by {:.3g} {}; --start equilibrium "
                        "linearises about one",
                        system.body_names[most / 6], largest, most % 6 < 3 ? "m/s2" : "rad/s2")};
}

/// Rows of a table, the first few of them.
class Table {
  public:
    explicit Table(std::string head) : text_(std::move(head)) {}
    void add(const std::string& line) {
        if (++lines_ <= most_lines)
            text_ += line;
    }
    std::string text(const char* file) const {
        return lines_ <= most_lines ? text_
                                    : text_ + fmt::format("  and {} more: {}\n", lines_ - most_lines, file);
    }

  private:
    std::string text_;
    std::size_t lines_ = 0;
};

std::string tables(const System& system, const State& state, const RestForces& forces) {
    const auto row = [](const std::string& name, const Vec3& x, const Vec3& y) {
        return fmt::format("  {:<16} {:>11.5g} {:>11.5g} {:>11.5g} {:>11.5g} {:>11.5g} {:>11.5g}\n", name,
                           x.x(), x.y(), x.z(), y.x(), y.y(), y.z());
    };
    const auto head = [](const char* what, const char* columns) {
        return fmt::format("{}\n  {:<16} {}\n", what, "", columns);
    };
    Table poses(head("poses: mass centre (m), rotation vector (rad)",
                     "          x           y           z          rx          ry          rz"));
    for (int i = 0; i < system.moving; ++i) {
        const Vec4 p = state.q.segment<4>(7 * i + 3);
        const Eigen::AngleAxisd turn(rotation(p));
        poses.add(row(system.body_names[i], state.q.segment<3>(7 * i), turn.angle() * turn.axis()));
    }
    constexpr const char* wrench = "         fx          fy          fz          mx          my          mz";
    Table joints(head("joints: force and moment (N, N m) on the second body at its joint point", wrench));
    for (std::size_t j = 0; j < system.joints.size(); ++j)
        joints.add(row(system.joints[j].name, forces.joint[j].force, forces.joint[j].moment));
    Table named(head("forces: force (N) and moment about the mass centre (N m) on a body", wrench));
    for (const RestForces::Named& force : forces.forces)
        named.add(row(force.name, force.wrench.force, force.wrench.moment));
    Table contacts("contacts: penetration (m or rad), normal force (N or N m), places that touch\n");
    for (std::size_t i = 0; i < forces.contact.size(); ++i)
        contacts.add(fmt::format("  {:<16} {:>11.5g} {:>11.5g} {:>5}\n",
                                 system.joints[system.contact_joints[i]].name, forces.contact[i].penetration,
                                 forces.contact[i].normal_force, forces.contact[i].touching));
    std::string text = poses.text("statics.json");
    if (!system.joints.empty())
        text += joints.text("statics.json");
    if (!forces.forces.empty())
        text += named.text("statics.json");
    if (!forces.contact.empty())
        text += contacts.text("statics.json");
    return text;
}

ordered_json results(const Assembled& at, const StaticsReport& report, const RestForces& forces) {
    const System& system = at.system;
    ordered_json out{{"model", at.loaded.model.name},
                     {"source", at.loaded.model.source},
                     {"version", GUDGEON_VERSION},
                     {"parameters", at.loaded.parameters},
                     {"friction", "left out: the equilibrium without it"}};
    out.update(statics_json(system, report));
    ordered_json bodies = ordered_json::object(), joints = bodies, named = bodies, contacts = bodies;
    for (int i = 0; i < system.moving; ++i) {
        const Vec4 p = at.state.q.segment<4>(7 * i + 3);
        bodies[system.body_names[i]] = {{"position", numbers(at.state.q.segment<3>(7 * i))},
                                        {"orientation", {p[0], p[1], p[2], p[3]}}};
    }
    for (std::size_t j = 0; j < system.joints.size(); ++j) {
        ordered_json& joint = joints[system.joints[j].name];
        joint = {{"force", numbers(forces.joint[j].force)}, {"moment", numbers(forces.joint[j].moment)}};
        for (const JointCoordinate& c : system.joints[j].coordinates)
            if (c.kind == JointCoordinate::Kind::angle)
                joint[c.name] = at.state.angles.value[c.index];
    }
    for (const RestForces::Named& force : forces.forces)
        named[force.name] = {{"body", force.body},
                             {"force", numbers(force.wrench.force)},
                             {"moment", numbers(force.wrench.moment)}};
    for (std::size_t i = 0; i < forces.contact.size(); ++i)
        contacts[system.joints[system.contact_joints[i]].name] = {
            {"penetration", forces.contact[i].penetration},
            {"normal_force", forces.contact[i].normal_force},
            {"touching", forces.contact[i].touching}};
    out["bodies"] = bodies;
    out["joints"] = joints;
    out["forces"] = named;
    out["contacts"] = contacts;
    return out;
}

std::string mode_table(const System& system, const ModesReport& report) {
    Table table(fmt::format("  {:>4} {:<11} {:>12} {:>12} {:>12} {:>10}  {}\n", "mode", "kind", "Hz", "rad/s",
                            "damping", "", "moves most"));
    for (std::size_t k = 0; k < report.modes.size(); ++k) {
        const Mode& mode = report.modes[k];
        Eigen::Index most;
        mode.shape.cwiseAbs().maxCoeff(&most);
        table.add(fmt::format("  {:>4} {:<11} {:>12.6g} {:>12.6g} {:>12.4g} {:>10}  {} {} {}\n", k + 1,
                              mode_kind_name(mode.kind), mode.hertz(), mode.omega(), mode.damping(),
                              mode.kind == Mode::Kind::unstable ? "GROWS" : "", system.body_names[most / 6],
                              most % 6 < 3 ? "along" : "about its", "xyz"[most % 3]));
    }
    return table.text("modes.json");
}

ordered_json modes_json(const Assembled& at, const RestArguments& arguments, const ModesReport& report,
                        const std::vector<std::string>& notices) {
    ordered_json list = ordered_json::array();
    const auto parts = [](const Eigen::Vector3cd& v) {
        return ordered_json{{"re", numbers(v.real())}, {"im", numbers(v.imag())}};
    };
    for (const Mode& mode : report.modes) {
        ordered_json shape = ordered_json::object();
        for (int i = 0; i < at.system.moving; ++i)
            shape[at.system.body_names[i]] = {{"translation", parts(mode.shape.segment<3>(6 * i))},
                                              {"rotation", parts(mode.shape.segment<3>(6 * i + 3))}};
        list.push_back({{"kind", mode_kind_name(mode.kind)},
                        {"hertz", mode.hertz()},
                        {"omega", mode.omega()},
                        {"damped_omega", mode.damped_omega()},
                        {"damping_ratio", mode.damping()},
                        {"root", {mode.root.real(), mode.root.imag()}},
                        {"shape", shape}});
    }
    return {{"model", at.loaded.model.name},
            {"source", at.loaded.model.source},
            {"version", GUDGEON_VERSION},
            {"parameters", at.loaded.parameters},
            {"start", arguments.start},
            {"friction", "left out"},
            {"solver", report.solver},
            {"neutral", report.neutral},
            {"unstable", report.unstable},
            {"notices", notices},
            {"modes", list}};
}

std::string modes_csv(const System& system, const ModesReport& report) {
    std::string out =
        "mode,kind,hertz,omega,damping_ratio,root_re,root_im,body,x_re,x_im,y_re,y_im,z_re,z_im,"
        "rx_re,rx_im,ry_re,ry_im,rz_re,rz_im\n";
    for (std::size_t k = 0; k < report.modes.size(); ++k) {
        const Mode& mode = report.modes[k];
        for (int i = 0; i < system.moving; ++i) {
            out += fmt::format("{},{}", k + 1, mode_kind_name(mode.kind));
            for (const double x :
                 {mode.hertz(), mode.omega(), mode.damping(), mode.root.real(), mode.root.imag()})
                append_number(out += ',', x);
            out += ',' + system.body_names[i];
            for (int c = 0; c < 6; ++c) {
                append_number(out += ',', mode.shape[6 * i + c].real());
                append_number(out += ',', mode.shape[6 * i + c].imag());
            }
            out += '\n';
        }
    }
    return out;
}

} // namespace

int statics(const RestArguments& arguments, const Console& console) {
    Assembled at = assemble(arguments, true, console);
    const StaticsReport report = settle(at.system, at.state);
    const RestForces forces = rest_forces(at.system, at.state, standard_force_builders());
    const fs::path folder = arguments.out.value_or(at.loaded.model.name);
    make_folder(folder);
    write_atomically(folder / "statics.json",
                     results(at, report, forces).dump(2, ' ', false, ordered_json::error_handler_t::replace) +
                         '\n');
    write_atomically(folder / "equilibrium.json", write_model(model_at(at.system, at.state)));
    if (!arguments.quiet)
        console.out << equilibrium_report(at.system, report) << notice_report(report.notices())
                    << tables(at.system, at.state, forces)
                    << fmt::format("written: {}, equilibrium.json\n", (folder / "statics.json").string());
    return Exit::ok;
}

int modes(const RestArguments& arguments, const Console& console) {
    Assembled at = assemble(arguments, false, console);
    if (arguments.start == "equilibrium") {
        const StaticsReport report = settle(at.system, at.state);
        if (!arguments.quiet)
            console.out << equilibrium_report(at.system, report);
    }
    ModesOptions options;
    options.count = arguments.count;
    const ModesReport report = find_modes(at.system, at.state, options);
    const std::vector<std::string> notices = unrest(at.system, at.state);
    const fs::path folder = arguments.out.value_or(at.loaded.model.name);
    make_folder(folder);
    write_atomically(folder / "modes.json",
                     modes_json(at, arguments, report, notices)
                             .dump(2, ' ', false, ordered_json::error_handler_t::replace) +
                         '\n');
    write_atomically(folder / "modes.csv", modes_csv(at.system, report));
    if (!arguments.quiet)
        console.out << notice_report(notices) << mode_table(at.system, report)
                    << fmt::format("{} neutral, {} unstable; written: {}, modes.csv\n", report.neutral,
                                   report.unstable, (folder / "modes.json").string());
    return Exit::ok;
}

} // namespace gudgeon

#include "app/check.hpp"

#include "app/exit_codes.hpp"
#include "app/load_model.hpp"
#include "app/run_record.hpp"
#include "contact/standard_forces.hpp"
#include "core/channels.hpp"
#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"
#include "core/spanning_tree.hpp"
#include "solvers/notices.hpp"
#include "solvers/redundancy.hpp"
#include "solvers/singular_position.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

namespace gudgeon {

namespace {

std::string counted(const std::map<std::string, int>& kinds) {
    int all = 0;
    std::vector<std::string> words;
    for (const auto& [name, count] : kinds) {
        all += count;
        words.push_back(fmt::format("{} {}", count, name));
    }
    return words.empty() ? "0" : fmt::format("{} ({})", all, fmt::join(words, ", "));
}

const char* fidelity_words(const Joint& joint) {
    return is_wholly_perfect(joint)                ? ""
           : is_mixed(joint)                       ? " (mixed)"
           : joint.fidelity == Fidelity::clearance ? " clearance"
                                                   : " bushing";
}

std::string joints_of(const System& system) {
    std::map<std::string, int> kinds;
    for (const Joint& joint : system.model.joints)
        ++kinds[fmt::format("{}{}{}", joint_kind(joint.kind).name, fidelity_words(joint),
                            joint.stops.empty() ? "" : " with stops")];
    return counted(kinds);
}

std::string forces_of(const System& system) {
    std::map<std::string, int> kinds;
    for (const auto& batch : system.forces)
        kinds[batch->kind()] += batch->size();
    return counted(kinds);
}

void print_sizes(const System& system, const LoadedModel& loaded, const Console& console) {
    const CscPattern pattern = SaddleMatrix(system).pattern();
    console.out << fmt::format(
        "model               {} ({})\n"
        "bodies              {} moving, {} fixed\n"
        "joints              {}\n"
        "forces              {}, gravity ({}, {}, {}) m/s2\n"
        "contacts            {} places in {} joints, {} friction states\n"
        "markers             {}\n"
        "unknowns            {} velocities, {} constraint rows\n"
        "matrix              {} x {}, {} nonzeros\n"
        "columns of output   {}\n",
        loaded.model.name, loaded.ready ? "ready mechanism" : loaded.model.source, system.moving,
        system.model.bodies.size() - static_cast<std::size_t>(system.moving), joints_of(system),
        forces_of(system), system.gravity.x(), system.gravity.y(), system.gravity.z(), system.channels(),
        system.contact_joints.size(), system.friction_states(), system.markers.size(), system.velocities(),
        system.row_count(), pattern.rows, pattern.cols, pattern.nonzeros(), Channels::count_all(system));
}

/// What --formulation tree makes of it.
void print_tree(const System& system, const Console& console) {
    const SpanningTree tree = spanning_tree(system);
    std::string cuts;
    for (const int joint : tree.cut_joints) {
        constexpr std::size_t most = 60;
        if (cuts.size() > most) {
            cuts += ", ...";
            break;
        }
        cuts += fmt::format("{}'{}'", cuts.empty() ? ": " : ", ", system.joints[joint].name);
    }
    console.out << fmt::format(
        "tree                {} joints, depth {}, {} free bodies, {} joint coordinates, {} speeds\n"
        "cuts                {} rows of {} joints{}\n",
        tree.tree_joints(), tree.depth, tree.links.size() - std::size_t(tree.tree_joints()), tree.coordinates,
        tree.speeds, tree.cut_rows, tree.cut_joints.size(), cuts);
}

void print_assembly(const System& system, const AssemblyReport& report, const Console& console) {
    console.out << fmt::format("violation as given  {:.3g} m or rad, {:.3g} m/s or rad/s\n",
                               report.position_before, report.velocity_before);
    console.out << fmt::format("violation assembled {:.3g} m or rad, {:.3g} m/s or rad/s\n",
                               report.position_after, report.velocity_after);
    if (report.changes.empty()) {
        console.out << "changes             none\n";
        return;
    }
    std::size_t width = 4;
    for (const AssemblyReport::Change& c : report.changes)
        width = std::max(width, system.body_names[c.body].size());
    console.out << fmt::format("changes by assembly\n  {:<{}}  {:>10}  {:>10}  {:>10}  {:>10}\n", "body",
                               width, "moved m", "turned rad", "m/s", "rad/s");
    for (const AssemblyReport::Change& c : report.changes)
        console.out << fmt::format("  {:<{}}  {:>10.3g}  {:>10.3g}  {:>10.3g}  {:>10.3g}\n",
                                   system.body_names[c.body], width, c.shift, c.turn, c.velocity,
                                   c.angular_velocity);
}

/// True where rows repeat others.
bool print_redundancy(const System& system, const State& state, const Console& console) {
    const RedundancyReport redundancy = find_redundancy(system, state);
    console.out << fmt::format("degrees of freedom  {}\nredundant rows      {}\n", redundancy.dof,
                               redundancy.dependent.size());
    if (redundancy.dependent.empty())
        return false;
    for (const std::string& line : redundancy.lines(system))
        console.out << "  " << line << '\n';
    console.out << fmt::format(
        "  reactions are shared so that the sum of force^2 + (moment/L)^2 is least, L = "
        "{:.6g} m\n",
        reaction_length(system));
    return true;
}

} // namespace

int check(const ModelArguments& arguments, const Console& console) {
    LoadedModel loaded = load_model(arguments);
    const System system = compile(take_model(loaded), standard_force_builders());
    print_sizes(system, loaded, console);
    print_tree(system, console);
    State state = initial_state(system);
    const AssemblyReport assembly = assemble_start(system, state);
    print_assembly(system, assembly, console);
    if (!assembly.ok) {
        console.err << fmt::format("{}: the mechanism cannot be assembled: {}\n", loaded.model.source,
                                   assembly.message(system));
        return Exit::assembly;
    }
    if (print_redundancy(system, state, console))
        if (const std::string why = undecided_start(system, state); !why.empty()) {
            console.err << fmt::format("{}: the mechanism cannot start: {}\n", loaded.model.source, why);
            return Exit::assembly;
        }
    for (const std::string& notice : start_notices(system, state))
        console.out << "notice              " << notice << '\n';
    return Exit::ok;
}

} // namespace gudgeon

// The one list of integrators.

#include "solvers/auto_integrator.hpp"
#include "solvers/bayo.hpp"
#include "solvers/erk.hpp"
#include "solvers/gear.hpp"
#include "solvers/ida.hpp"
#include "solvers/radau.hpp"
#include "solvers/redundancy.hpp"
#include "solvers/rk4.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace gudgeon {

namespace {
using Maker = std::unique_ptr<Integrator> (*)(const System&, const IntegratorOptions&);
const std::vector<std::pair<std::string, Maker>>& makers() {
    static const std::vector<std::pair<std::string, Maker>> list{
        {"auto", make_auto}, {"gear", make_gear}, {"radau", make_radau},
        {"ida", make_ida},   {"rk4", make_rk4},   {"erk", make_erk},
        {"erk5", make_erk5}, {"erk8", make_erk8}, {"bayo", make_bayo}};
    return list;
}

std::vector<std::string> joints_that_repeat(const System& system) {
    std::vector<std::string> names;
    for (const int row : dependent_rows(system, initial_state(system)))
        if (const std::string& name = system.joints[system.rows[row].joint].name;
            std::ranges::find(names, name) == names.end())
            names.push_back(name);
    return names;
}
} // namespace

Statistics& Statistics::operator+=(const Statistics& o) {
    for (auto count :
         {&Statistics::steps, &Statistics::rejected_error, &Statistics::rejected_newton,
          &Statistics::rejected_contact, &Statistics::deep_starts, &Statistics::newton_sweeps,
          &Statistics::constraint_polish, &Statistics::evaluations, &Statistics::factorisations,
          &Statistics::refactorisations, &Statistics::cholmod_factorisations, &Statistics::cholmod_solves,
          &Statistics::cholmod_iterations, &Statistics::klu_fallbacks})
        this->*count += o.*count;
    nnz_matrix = std::max(nnz_matrix, o.nnz_matrix);
    nnz_factors = std::max(nnz_factors, o.nnz_factors);
    for (std::size_t k = 0; k < order_histogram.size(); ++k)
        order_histogram[k] += o.order_histogram[k];
    if (std::isnan(softened_at) || o.softened_at < softened_at)
        softened_at = o.softened_at;
    smallest_step = std::min(smallest_step, o.smallest_step);
    largest_step = std::max(largest_step, o.largest_step);
    constraint_position_max = std::max(constraint_position_max, o.constraint_position_max);
    constraint_velocity_max = std::max(constraint_velocity_max, o.constraint_velocity_max);
    for (auto phase : {&PhaseTimes::evaluate, &PhaseTimes::assemble, &PhaseTimes::factor, &PhaseTimes::solve,
                       &PhaseTimes::control, &PhaseTimes::contact, &PhaseTimes::output})
        seconds.*phase += o.seconds.*phase;
    return *this;
}

void Statistics::visit(Archive& archive) {
    archive(steps, rejected_error, rejected_newton, rejected_contact, deep_starts, newton_sweeps,
            constraint_polish, evaluations, factorisations, refactorisations, nnz_matrix, nnz_factors,
            order_histogram, smallest_step, largest_step, constraint_position_max, constraint_velocity_max,
            softened_at, cholmod_factorisations, cholmod_solves, cholmod_iterations, klu_fallbacks, seconds);
}

void Integrator::visit(Archive& archive) {
    archive.section(name());
    State now = state();
    archive(now, workspace().external);
    if (archive.reading() && now.q.size() > 0) // else one that has not begun yet
        start(now);
}

const char* step_reason_name(StepReason reason) {
    switch (reason) {
    case StepReason::none:
        return "accepted";
    case StepReason::error_test:
        return "error";
    case StepReason::newton:
        return "newton";
    case StepReason::contact:
        return "contact";
    case StepReason::singular:
        return "singular";
    case StepReason::non_finite:
        return "non-finite";
    case StepReason::step_too_small:
        return "step too small";
    case StepReason::constraints:
        return "constraints";
    }
    return "";
}

const char* onset_name(Onset onset) {
    return onset == Onset::threshold ? "threshold" : onset == Onset::root ? "root" : "ignored";
}

Onset onset_named(const std::string& word) {
    for (const Onset onset : {Onset::threshold, Onset::root, Onset::ignored})
        if (word == onset_name(onset))
            return onset;
    throw std::invalid_argument(fmt::format("unknown onset '{}'; allowed: threshold, root, ignored", word));
}

const char* formulation_name(Formulation formulation) {
    switch (formulation) {
    case Formulation::saddle_point:
        return "saddle-point";
    case Formulation::saddle_point_klu:
        return "saddle-point-klu";
    case Formulation::augmented_lagrangian:
        return "augmented-lagrangian";
    case Formulation::tree:
        return "tree";
    case Formulation::automatic:
        break;
    }
    return "auto";
}

Formulation formulation_named(const std::string& word) {
    for (const Formulation f : {Formulation::saddle_point, Formulation::saddle_point_klu,
                                Formulation::augmented_lagrangian, Formulation::tree, Formulation::automatic})
        if (word == formulation_name(f))
            return f;
    throw std::invalid_argument(fmt::format(
        "unknown formulation '{}'; allowed: saddle-point, saddle-point-klu, augmented-lagrangian, tree, "
        "auto",
        word));
}

const std::vector<std::string>& integrator_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> out;
        for (const auto& [name, make] : makers())
            out.push_back(name);
        return out;
    }();
    return names;
}

bool is_explicit(const std::string& integrator) {
    return integrator == "rk4" || integrator.starts_with("erk");
}

bool works_on_tree(const std::string& integrator) {
    return integrator == "auto" || integrator == "gear" || integrator == "radau" || is_explicit(integrator);
}

std::unique_ptr<Integrator> make_integrator(const std::string& name, const System& system,
                                            const IntegratorOptions& options) {
    for (const auto& [known, make] : makers()) {
        if (known != name)
            continue;
        if (options.formulation == Formulation::tree && !works_on_tree(name))
            throw std::invalid_argument(fmt::format("formulation tree works with auto, gear, radau, rk4, "
                                                    "erk, erk5 and erk8, not with integrator {}",
                                                    name));
        if (options.formulation == Formulation::tree && options.redundant && !is_explicit(name))
            throw ModelError(
                system.model.name, "/joints",
                fmt::format("constraints of {} repeat others: formulation tree with integrator {}",
                            fmt::join(joints_that_repeat(system), ", "), name),
                "integrator rk4, erk, erk5 or erk8, or another formulation");
        return make(system, options);
    }
    throw std::invalid_argument(
        fmt::format("unknown integrator '{}'; allowed: {}", name, fmt::join(integrator_names(), ", ")));
}

} // namespace gudgeon

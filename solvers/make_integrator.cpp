// The one list of integrators.

#include "solvers/gear.hpp"
#include "solvers/ida.hpp"
#include "solvers/radau.hpp"
#include "solvers/rk4.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <stdexcept>
#include <utility>

namespace gudgeon {

namespace {
using Maker = std::unique_ptr<Integrator> (*)(const System&, const IntegratorOptions&);
const std::vector<std::pair<std::string, Maker>>& makers() {
    static const std::vector<std::pair<std::string, Maker>> list{
        {"gear", make_gear}, {"radau", make_radau}, {"ida", make_ida}, {"rk4", make_rk4}};
    return list;
}
} // namespace

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

const std::vector<std::string>& integrator_names() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> out;
        for (const auto& [name, make] : makers())
            out.push_back(name);
        return out;
    }();
    return names;
}

std::unique_ptr<Integrator> make_integrator(const std::string& name, const System& system,
                                            const IntegratorOptions& options) {
    for (const auto& [known, make] : makers())
        if (known == name)
            return make(system, options);
    throw std::invalid_argument(
        fmt::format("unknown integrator '{}'; allowed: {}", name, fmt::join(integrator_names(), ", ")));
}

} // namespace gudgeon

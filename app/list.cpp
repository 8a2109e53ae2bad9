#include "app/check.hpp"
#include "app/exit_codes.hpp"
#include "app/load_model.hpp"
#include "core/writer.hpp"
#include "models/mechanisms.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace gudgeon {

namespace {

std::string allowed(const MechanismParameter& p) {
    if (!p.choices.empty())
        return fmt::format("{}", fmt::join(p.choices, ", "));
    return fmt::format("{}{} to {}", p.integer ? "whole, " : "", p.minimum, p.maximum);
}

} // namespace

int list(const Console& console) {
    for (const Mechanism& m : mechanisms()) {
        console.out << fmt::format("{}: {}\n  {} s, output every {} s\n", m.name, m.description, m.end,
                                   m.every);
        std::size_t name = 0, value = 0, unit = 0, range = 0;
        for (const MechanismParameter& p : m.parameters) {
            name = std::max(name, p.name.size());
            value = std::max(value, p.default_value.size());
            unit = std::max(unit, p.unit.size());
            range = std::max(range, allowed(p).size());
        }
        for (const MechanismParameter& p : m.parameters)
            console.out << fmt::format("  {:<{}} = {:<{}} {:<{}}  ({}){:<{}}  {}\n", p.name, name,
                                       p.default_value, value, p.unit, unit, allowed(p), "",
                                       range - allowed(p).size(), p.help);
        console.out << '\n';
    }
    return Exit::ok;
}

int export_model(const ModelArguments& arguments, const Console& console) {
    LoadedModel loaded = load_mechanism(arguments);
    loaded.model.parameters.clear(); // they shaped the model; in the file nothing refers to them
    validate(loaded.model);
    console.out << write_model(loaded.model);
    return Exit::ok;
}

} // namespace gudgeon

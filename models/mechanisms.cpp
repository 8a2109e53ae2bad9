#include "models/mechanisms.hpp"

#include "models/builders.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

namespace gudgeon {

const std::vector<Mechanism>& mechanisms() {
    static const std::vector<Mechanism> all{
        pendulum(),         chain(),           four_bar(),         slider_crank(),
        heavy_top(),        triple_pendulum(), suspension_chain(), hmmwv_corner(),
        bouncing_journal(), tilted_journal(),  stick_slip(),       rsup(),
    };
    return all;
}

const Mechanism* find_mechanism(const std::string& name) {
    const auto& all = mechanisms();
    const auto it = std::find_if(all.begin(), all.end(), [&](const Mechanism& m) { return m.name == name; });
    return it == all.end() ? nullptr : &*it;
}

namespace {

template <class Items> std::string names_of(const Items& items) {
    std::vector<std::string> names;
    for (const auto& item : items)
        names.push_back(item.name);
    return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

/// The whole text as one finite number, or nothing.
std::optional<double> parse_number(const std::string& text) {
    double value = 0;
    const auto [rest, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc{} || rest != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::string pointer_to(const std::string& parameter) {
    std::string pointer = "/parameters/";
    for (const char c : parameter)
        pointer += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    return pointer;
}

std::string allowed_values(const MechanismParameter& p) {
    if (!p.choices.empty())
        return fmt::format("{}", fmt::join(p.choices, ", "));
    return fmt::format("{} from {} to {}{}{}", p.integer ? "a whole number" : "a number", p.minimum,
                       p.maximum, p.unit.empty() ? "" : " ", p.unit);
}

/// The default that goes with the values read so far.
const std::string& default_of(const MechanismParameter& p, const std::map<std::string, std::string>& words) {
    for (const auto& [name, word] : words)
        if (const auto other = p.default_with.find(word); other != p.default_with.end())
            return other->second;
    return p.default_value;
}

bool is_allowed(const MechanismParameter& p, const std::string& text, const std::optional<double>& value) {
    if (!p.choices.empty())
        return std::find(p.choices.begin(), p.choices.end(), text) != p.choices.end();
    return value && *value >= p.minimum && *value <= p.maximum &&
           (!p.integer || *value == std::floor(*value));
}

} // namespace

ParameterValues read_parameters(const Mechanism& mechanism,
                                const std::map<std::string, std::string>& overrides) {
    const auto& known = mechanism.parameters;
    for (const auto& [name, value] : overrides) {
        const bool found =
            std::any_of(known.begin(), known.end(), [&](const auto& p) { return p.name == name; });
        if (!found)
            throw ModelError(mechanism.name, pointer_to(name),
                             fmt::format("unknown parameter {} (value {})", name, value), names_of(known));
    }
    ParameterValues values;
    for (const MechanismParameter& p : known) {
        const auto given = overrides.find(p.name);
        const std::string& text = given == overrides.end() ? default_of(p, values.words_) : given->second;
        const std::optional<double> value = parse_number(text);
        if (!is_allowed(p, text, value))
            throw ModelError(mechanism.name, pointer_to(p.name),
                             fmt::format("{} = \"{}\" is not allowed", p.name, text), allowed_values(p));
        values.words_[p.name] = text;
        if (value)
            values.numbers_[p.name] = *value;
    }
    return values;
}

Model build_mechanism(const std::string& name, const std::map<std::string, std::string>& overrides) {
    const Mechanism* mechanism = find_mechanism(name);
    if (!mechanism)
        throw ModelError(name, "", fmt::format("there is no ready mechanism \"{}\"", name),
                         names_of(mechanisms()));
    const ParameterValues values = read_parameters(*mechanism, overrides);
    Model model = mechanism->build(values);
    model.name = mechanism->name;
    model.parameters = values.numbers();
    model.end = mechanism->end;
    model.every = mechanism->every;
    return model;
}

} // namespace gudgeon

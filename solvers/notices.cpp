#include "solvers/notices.hpp"

#include "contact/clearance.hpp"
#include "core/assembly.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace gudgeon {

namespace {

constexpr std::size_t most_lines = 8;
constexpr double resting = 1e-3; // rad/s or m/s: slower contacts that begin deep may be resting ones

std::string place_of(const ContactChannel& c) {
    return c.number > 0 ? fmt::format("{} {}", c.place, c.number) : std::string(c.place);
}

// A contact that begins inside takes its starting speed from the start, not from an approach.
std::vector<std::string> deep_starts(const System& system, const State& state) {
    Workspace ws = make_workspace(system);
    ws.remember(state);
    set_motion(system, state.q, state.u, ws);
    sample_contacts(system, state.t, ws);
    std::map<int, int> worst; // joint, channel
    for (int c = 0; c < system.channels(); ++c) {
        const ContactSample& sample = ws.samples[c];
        if (!(sample.depth > 0) || sample.elastic == 0)
            continue;
        const auto [it, fresh] = worst.try_emplace(system.contacts[c].joint, c);
        if (!fresh && sample.elastic > ws.samples[it->second].elastic)
            it->second = c;
    }
    std::vector<std::string> out;
    for (const auto& [joint, c] : worst) {
        const ContactSample& sample = ws.samples[c];
        const bool moves = std::abs(sample.rate) > resting;
        out.push_back(fmt::format(
            "joint '{}' starts {:.3g} {} deep in contact ({}), with {:.3g} J stored and a force of {:.3g}{}",
            system.joints[joint].name, sample.depth, system.contacts[c].rotation ? "rad" : "m",
            place_of(system.contacts[c]), sample.elastic, sample.force,
            moves ? fmt::format("; its damping takes the present rate {:.3g} for that of the impact",
                                std::max(sample.rate, 0.0))
                  : ""));
    }
    return out;
}

std::vector<std::string> zero_clearances(const System& system) {
    std::vector<std::string> out;
    for (const Joint& joint : system.model.joints)
        if (held_by_contact(joint, Motion::radial) && joint.clearance->radial == 0.0)
            out.push_back(
                fmt::format("joint '{}' has a clearance of zero: it touches all the time, so its law "
                            "damps nothing; 'perfect' is exact and quicker",
                            joint.name));
    return out;
}

void append(std::vector<std::string> lines, const char* more, std::vector<std::string>& out) {
    const std::size_t shown = std::min(lines.size(), most_lines);
    std::move(lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(shown), std::back_inserter(out));
    if (lines.size() > shown)
        out.push_back(fmt::format("{} joints more {}", lines.size() - shown, more));
}

} // namespace

std::vector<std::string> start_notices(const System& system, const State& state) {
    std::vector<std::string> out;
    if (system.contacts.empty())
        return out;
    append(deep_starts(system, state), "start deep in contact", out);
    append(zero_clearances(system), "have a clearance of zero", out);
    return out;
}

} // namespace gudgeon

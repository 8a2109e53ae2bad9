// gudgeon_hard_cases: the table of the hard cases. See README.md.
#include "bench/hard_cases/hard_case.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <exception>

namespace {

using namespace gudgeon::hard;

bool contains(const std::string& text, const std::string& part) {
    const auto same = [](char a, char b) {
        return std::tolower(static_cast<unsigned char>(a)) == std::tolower(static_cast<unsigned char>(b));
    };
    return std::search(text.begin(), text.end(), part.begin(), part.end(), same) != text.end();
}

std::string cell(const HardCase& hard_case, const Way& way, const Outcome& outcome, std::size_t finding) {
    if (finding >= outcome.findings.size())
        return "-";
    const Finding& f = outcome.findings[finding];
    const std::string number = fmt::format("{:.2g}", f.value);
    if (f.holds())
        return number;
    return known_miss(hard_case, way, f.what) ? number + " (known)" : "**" + number + "**";
}

std::string work(const Outcome& outcome) {
    const auto& w = outcome.work;
    std::string out =
        fmt::format("{} / {} / {:.2f}", w.steps, w.factorisations + w.refactorisations, outcome.seconds);
    if (w.klu_fallbacks > 0)
        out += fmt::format(" (KLU {})", w.klu_fallbacks);
    return out;
}

/// Lines of one case and what is to be said below the table. True: all is as it must be.
bool report(const HardCase& hard_case, const std::vector<Way>& ways, std::string& notes) {
    std::vector<Outcome> outcomes;
    std::size_t lines = 0, longest = 0;
    bool good = true;
    std::string early_ends;
    for (const Way& way : ways) {
        outcomes.push_back(run_case(hard_case, way));
        const auto wrong = complaints(hard_case, way, outcomes.back());
        for (const std::string& line : wrong)
            notes += fmt::format("- {}, {}: **{}**\n", hard_case.name, way.name(), line);
        good = good && wrong.empty();
        if (outcomes.back().findings.size() > lines) {
            lines = outcomes.back().findings.size();
            longest = outcomes.size() - 1;
        }
    }
    if (std::ranges::any_of(outcomes, [](const Outcome& o) { return !o.stopped.empty(); })) {
        early_ends = "|  | ends early | ";
        for (std::size_t w = 0; w < ways.size(); ++w)
            early_ends += std::string("| ") +
                          (outcomes[w].stopped.empty()               ? "no"
                           : known_miss(hard_case, ways[w], "stops") ? "yes (known)"
                                                                     : "**yes**") +
                          " ";
        early_ends += "|\n";
    }
    for (std::size_t k = 0; k <= lines; ++k) {
        std::string line = fmt::format("| {} ", k == 0 ? hard_case.name : "");
        if (k < lines) {
            const Finding& f = outcomes[longest].findings[k];
            line += fmt::format("| {} | {:.2g} ", f.what, f.bound);
        } else {
            fmt::print("{}", early_ends);
            line += "| steps / factorisations / CPU s | ";
        }
        for (std::size_t w = 0; w < ways.size(); ++w)
            line += "| " + (k < lines ? cell(hard_case, ways[w], outcomes[w], k) : work(outcomes[w])) + " ";
        fmt::print("{}|\n", line);
    }
    std::fflush(stdout);
    if (!hard_case.indefinite.empty())
        notes += fmt::format("- {}: KLU may take over: {}\n", hard_case.name, hard_case.indefinite);
    for (const KnownMiss& miss : hard_case.known)
        notes += fmt::format("- {}, {} ({}): {}\n", hard_case.name, miss.what,
                             miss.way.empty() ? "all" : miss.way, miss.why);
    return good;
}

int run(const std::string& filter, const std::string& integrator, bool list) {
    std::vector<Way> chosen;
    for (const Way& way : ways())
        if (integrator.empty() || way.integrator == integrator)
            chosen.push_back(way);
    if (!list) {
        std::string head = "| case | what must not exceed | its bound ", rule = "|---|---|---";
        for (const Way& way : chosen) {
            head += "| " + way.name() + " ";
            rule += "|---";
        }
        fmt::print("{}|\n{}|\n", head, rule);
    }
    std::string notes;
    bool good = true, found = false;
    for (const HardCase& hard_case : hard_cases())
        if (contains(hard_case.name, filter)) {
            found = true;
            if (list)
                fmt::print("- {}: {}\n", hard_case.name, hard_case.scene);
            else
                good = report(hard_case, chosen, notes) && good;
        }
    if (!notes.empty())
        fmt::print("\n{}", notes);
    if (!found)
        fmt::print(stderr, "gudgeon_hard_cases: no case has '{}' in its name\n", filter);
    return good && found ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    CLI::App app("Hard cases: what must hold, and what is measured");
    std::string filter, integrator;
    bool list = false;
    app.add_option("case", filter, "only cases with this in their name");
    app.add_option("--integrator", integrator, "gear or radau alone")
        ->check(CLI::IsMember({"gear", "radau"}));
    app.add_flag("--list", list, "scenes only, nothing is run");
    CLI11_PARSE(app, argc, argv);
    try {
        return run(filter, integrator, list);
    } catch (const std::exception& error) {
        fmt::print(stderr, "gudgeon_hard_cases: {}\n", error.what());
        return 1;
    }
}

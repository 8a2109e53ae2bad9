#include "app/arguments.hpp"

#include "app/exit_codes.hpp"
#include "app/numbers.hpp"
#include "core/words.hpp"
#include "solvers/integrator.hpp"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace gudgeon {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Everything as typed; numbers are read by ourselves, so that messages name value and range.
struct Typed {
    ModelArguments model;
    std::string folder;
    std::vector<std::string> parameters, channels;
    std::map<std::string, std::string> options;
    bool steps = false, contacts = false, quiet = false;
};

std::map<std::string, std::string> split_parameters(const std::vector<std::string>& assignments) {
    std::map<std::string, std::string> out;
    for (const std::string& text : assignments) {
        const std::size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
            throw UsageError("--param", fmt::format("'{}' assigns nothing", text), "name=value");
        if (!out.emplace(text.substr(0, equals), text.substr(equals + 1)).second)
            throw UsageError("--param", fmt::format("'{}' is given twice", text.substr(0, equals)),
                             "one value per parameter");
    }
    return out;
}

void add_model(CLI::App& command, Typed& typed, const char* name, const char* help) {
    command.add_option(name, typed.model.model, help)->required();
    command.add_option("--param", typed.parameters, "value of a parameter of the model; may be repeated")
        ->type_name("NAME=VALUE")
        ->allow_extra_args(false);
}

void add_text(CLI::App& command, Typed& typed, const char* name, const char* value, const char* help) {
    command
        .add_option_function<std::string>(
            name, [&typed, name](const std::string& text) { typed.options[name] = text; }, help)
        ->type_name(value);
}

void add_rest_options(CLI::App& command, Typed& typed) {
    add_text(command, typed, "--out", "DIR", "folder of the results, ./NAME by default");
    command.add_flag("--quiet", typed.quiet, "print errors only");
}

void add_modes_options(CLI::App& command, Typed& typed) {
    add_text(command, typed, "--count", "N", "modes beside the neutral ones, lowest first, 10");
    add_text(command, typed, "--start", "WORD",
             "where to linearise: as-given, or equilibrium (found first, as statics does)");
}

void add_run_options(CLI::App& command, Typed& typed) {
    const auto option = [&](const char* name, const char* value, const char* help) {
        add_text(command, typed, name, value, help);
    };
    option(
        "--integrator", "WORD",
        "auto (radau, gear or erk, as the run asks), gear, radau, ida, rk4, erk (erk5 or erk8, explicit), or "
        "bayo");
    option("--formulation", "WORD",
           "gear and radau: saddle-point (blocks), saddle-point-klu, augmented-lagrangian (CHOLMOD), tree "
           "(joint "
           "coordinates) or auto; rk4, erk: saddle-point, tree or auto");
    option("--rtol", "X", "relative error of a step, 1e-6");
    option("--atol", "X", "absolute error of a step (m, m/s, rad/s), as --rtol");
    option("--step", "S", "rk4, bayo: the step, 1e-3 s; elsewhere the largest step");
    option("--max-order", "K", "highest order of gear and ida, 1 to 5");
    option("--end", "S", "length of the run; default: of the model, else 1 s");
    option("--every", "S", "output interval; default: of the model, else a hundredth of the run");
    command
        .add_option("--channels", typed.channels,
                    "columns by name with * and ?, several divided by commas; default: all up to 2000")
        ->type_name("GLOB,...")
        ->delimiter(',')
        ->allow_extra_args(false);
    option("--checkpoint", "S", "simulated time between checkpoints, for 'gudgeon resume'; default: none");
    option("--threads", "N", "threads, 1; the results do not depend on them");
    option(
        "--start", "WORD",
        "as-given: the pose of the model, assembled where it violates the constraints; equilibrium: at rest "
        "where forces balance");
    option("--out", "DIR", "folder of the results, ./NAME by default; earlier results in it are replaced");
    option("--onset", "WORD",
           "a contact that is new in a step: threshold (it must start shallow), root (the step ends where it "
           "starts) or ignored");
    command.add_flag("--steps", typed.steps,
                     "also write steps.csv: every attempted step, its order and outcome");
    command.add_flag("--contacts", typed.contacts,
                     "also write contacts.csv: every start and end of a contact, and rejected starts");
    command.add_flag("--quiet", typed.quiet, "print errors only");
}

std::string choice(const Typed& typed, const std::string& option, const std::vector<std::string>& allowed,
                   const std::vector<std::string>& later) {
    const auto found = typed.options.find(option);
    if (found == typed.options.end())
        return allowed.front();
    const std::string& word = found->second;
    if (std::ranges::find(later, word) != later.end())
        throw UsageError(option, fmt::format("'{}' is not available in this version", word), listed(allowed));
    if (std::ranges::find(allowed, word) == allowed.end())
        throw UsageError(option, fmt::format("unknown word '{}'", word),
                         suggestion(word, allowed) + listed(allowed));
    return word;
}

std::optional<double> positive(const Typed& typed, const std::string& option, double least = 0,
                               double most = infinity) {
    const auto found = typed.options.find(option);
    if (found == typed.options.end())
        return std::nullopt;
    const std::optional<double> value = to_number(found->second);
    if (value && *value > 0 && *value >= least && *value <= most)
        return value;
    const std::string lower = least > 0 ? fmt::format("from {}", least) : "above 0";
    const std::string upper = most < infinity ? fmt::format("up to {}", most) : "finite";
    throw UsageError(option,
                     value ? fmt::format("{} is not allowed", found->second)
                           : fmt::format("'{}' is no finite number", found->second),
                     fmt::format("numbers {}, {}", lower, upper));
}

int whole(const Typed& typed, const std::string& option, int most, int fallback) {
    const auto found = typed.options.find(option);
    if (found == typed.options.end())
        return fallback;
    const std::optional<double> value = to_number(found->second);
    if (!value || *value < 1 || *value > most || *value != static_cast<int>(*value))
        throw UsageError(option, fmt::format("'{}' is not allowed", found->second),
                         fmt::format("whole numbers from 1 to {}", most));
    return static_cast<int>(*value);
}

/// Not every method has the choice.
std::string formulation(const Typed& typed, const std::string& integrator) {
    std::string word =
        choice(typed, "--formulation",
               {"saddle-point", "saddle-point-klu", "augmented-lagrangian", "tree", "auto"}, {});
    if (!typed.options.contains("--formulation"))
        return "auto";
    if (word == "tree") {
        if (!works_on_tree(integrator))
            throw UsageError("--formulation", fmt::format("'tree' with --integrator {}", integrator),
                             "--formulation tree works with auto, gear, radau, rk4, erk, erk5, erk8");
        return word;
    }
    if ((integrator == "ida" || is_explicit(integrator)) && word != "saddle-point" && word != "auto")
        throw UsageError("--formulation", fmt::format("'{}' with --integrator {}", word, integrator),
                         is_explicit(integrator) ? "saddle-point, tree or auto; others with gear, radau, auto"
                                                 : "saddle-point or auto; others with gear, radau, auto");
    if (integrator == "bayo" && word.starts_with("saddle-point"))
        throw UsageError("--formulation", fmt::format("'{}' with --integrator bayo", word),
                         "augmented-lagrangian or auto");
    return word;
}

std::optional<std::string> folder(const Typed& typed) {
    const auto out = typed.options.find("--out");
    if (out == typed.options.end())
        return std::nullopt;
    if (out->second.empty())
        throw UsageError("--out", "an empty name", "a folder");
    return out->second;
}

RestArguments rest_arguments(const Typed& typed, ModelArguments model) {
    RestArguments rest;
    rest.model = std::move(model);
    rest.start = choice(typed, "--start", {"as-given", "equilibrium"}, {});
    rest.count = whole(typed, "--count", 10000, rest.count);
    rest.out = folder(typed);
    rest.quiet = typed.quiet;
    return rest;
}

RunArguments run_arguments(const Typed& typed, ModelArguments model) {
    RunArguments run;
    run.model = std::move(model);
    run.integrator = choice(typed, "--integrator", integrator_names(), {});
    run.formulation = formulation(typed, run.integrator);
    run.start = choice(typed, "--start", {"as-given", "equilibrium"}, {});
    run.rtol = positive(typed, "--rtol", 1e-14, 1).value_or(run.rtol);
    run.atol = positive(typed, "--atol");
    run.step = positive(typed, "--step");
    run.end = positive(typed, "--end");
    run.every = positive(typed, "--every");
    run.checkpoint = positive(typed, "--checkpoint");
    run.threads = whole(typed, "--threads", 1024, run.threads);
    run.max_order = whole(typed, "--max-order", 5, run.max_order);
    for (const std::string& glob : typed.channels)
        if (glob.empty())
            throw UsageError("--channels", "an empty name", "names with * and ?, divided by commas");
    run.channels = typed.channels;
    run.steps = typed.steps;
    run.contacts = typed.contacts;
    run.onset = onset_named(choice(typed, "--onset", {"threshold", "root", "ignored"}, {}));
    run.out = folder(typed);
    run.quiet = typed.quiet;
    run.given = typed.options;
    return run;
}

/// Named here, since CLI11 only says that a command is missing.
void check_command(const std::vector<std::string>& args) {
    const std::vector<std::string> commands{"run", "check", "statics", "modes", "list", "export", "resume"};
    const std::string allowed = listed(commands) + ", --version, --help";
    if (args.empty())
        throw UsageError("command line", "no command", allowed);
    if (!args[0].starts_with('-') && std::ranges::find(commands, args[0]) == commands.end())
        throw UsageError("command line", fmt::format("unknown command '{}'", args[0]),
                         suggestion(args[0], commands) + allowed);
}

} // namespace

void RunArguments::visit(Archive& archive) {
    archive(model, integrator, formulation, start, rtol, atol, step, end, every, checkpoint, channels,
            threads, max_order, out, onset, steps, contacts, quiet, given);
}

Arguments parse_arguments(const std::vector<std::string>& args) {
    CLI::App app("Multibody dynamics with perfect, compliant and worn joints.", "gudgeon");
    app.set_version_flag("--version", "gudgeon " GUDGEON_VERSION);
    app.require_subcommand(1);
    app.footer("Exit: 0 ok, 2 usage or model refused, 3 cannot be assembled, 4 integration stopped, 5 files, "
               "130 interrupted.");
    Typed typed;
    const char* model = "a model file (JSON) or a ready mechanism's name";
    CLI::App* run = app.add_subcommand("run", "simulate a model");
    add_model(*run, typed, "MODEL", model);
    add_run_options(*run, typed);
    CLI::App* resumed = app.add_subcommand("resume", "go on with a run that was interrupted or killed");
    resumed->add_option("DIR", typed.folder, "the folder of the run's results")->required();
    resumed->add_flag("--quiet", typed.quiet, "print errors only");
    CLI::App* check =
        app.add_subcommand("check", "validate, compile and assemble a model, without running it");
    add_model(*check, typed, "MODEL", model);
    CLI::App* statics = app.add_subcommand("statics", "the equilibrium of a model: pose, reactions, forces");
    add_model(*statics, typed, "MODEL", model);
    add_rest_options(*statics, typed);
    CLI::App* modes =
        app.add_subcommand("modes", "eigenfrequencies, damping ratios and mode shapes of a model");
    add_model(*modes, typed, "MODEL", model);
    add_modes_options(*modes, typed);
    add_rest_options(*modes, typed);
    CLI::App* list = app.add_subcommand("list", "the ready mechanisms with their parameters");
    CLI::App* written = app.add_subcommand("export", "a ready mechanism as a JSON model");
    add_model(*written, typed, "NAME", "a ready mechanism's name");

    check_command(args);
    Arguments out;
    try {
        app.parse(std::vector<std::string>(args.rbegin(), args.rend())); // last one first
    } catch (const CLI::CallForHelp&) {
        const auto chosen = app.get_subcommands();
        out.text = chosen.empty() ? app.help() : chosen.front()->help("gudgeon");
        return out;
    } catch (const CLI::CallForVersion& version) {
        out.text = std::string(version.what()) + "\n";
        return out;
    } catch (const CLI::ParseError& error) {
        throw UsageError("command line", error.what(), "what 'gudgeon --help' and 'gudgeon run --help' list");
    }
    typed.model.parameters = split_parameters(typed.parameters);
    using Command = Arguments::Command;
    out.command = *run       ? Command::run
                  : *resumed ? Command::resume
                  : *check   ? Command::check
                  : *statics ? Command::statics
                  : *modes   ? Command::modes
                  : *list    ? Command::list
                             : Command::export_model;
    out.resume = {typed.folder, typed.quiet};
    if (out.command == Command::run)
        out.run = run_arguments(typed, typed.model);
    if (out.command == Command::statics || out.command == Command::modes)
        out.rest = rest_arguments(typed, typed.model);
    out.model = std::move(typed.model);
    return out;
}

} // namespace gudgeon

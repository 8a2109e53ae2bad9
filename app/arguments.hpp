// The command line in words: what the user asked for, checked as far as that goes without the model.
#pragma once

#include "core/archive.hpp"
#include "solvers/integrator.hpp"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace gudgeon {

struct ModelArguments {
    std::string model; // file or ready mechanism
    std::map<std::string, std::string> parameters;
    void visit(Archive& archive) { archive(model, parameters); }
};

struct RunArguments {
    ModelArguments model;
    std::string integrator = "auto", formulation = "auto", start = "as-given";
    double rtol = 1e-6;
    std::optional<double> atol;       // rtol if absent
    std::optional<double> step;       // s
    std::optional<double> end;        // s
    std::optional<double> every;      // s
    std::optional<double> checkpoint; // s between checkpoints; absent: only where the run is interrupted
    std::vector<std::string> channels;
    int threads = 1, max_order = 5;
    std::optional<std::string> out;
    Onset onset = Onset::threshold;
    bool steps = false;    // history of steps and orders
    bool contacts = false; // history of contacts
    bool quiet = false;
    std::map<std::string, std::string> given; // options as typed, for the record
    void visit(Archive& archive);
};

struct ResumeArguments {
    std::string folder; // of the run
    bool quiet = false;
};

struct RestArguments {
    ModelArguments model;
    std::string start = "as-given"; // of modes
    int count = 10;                 // of modes
    std::optional<std::string> out;
    bool quiet = false;
};

struct Arguments {
    enum class Command {
        run,
        resume,
        check,
        statics,
        modes,
        list,
        export_model,
        text
    } command = Command::text;
    RunArguments run; // of run
    ResumeArguments resume;
    RestArguments rest;   // of statics and modes
    ModelArguments model; // of check and export
    std::string text;     // help or version, to be printed
};

/// args: without the program's name. Throws UsageError.
Arguments parse_arguments(const std::vector<std::string>& args);

} // namespace gudgeon

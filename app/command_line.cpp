#include "app/command_line.hpp"

#include "app/check.hpp"
#include "app/exit_codes.hpp"
#include "app/rest.hpp"
#include "app/run.hpp"
#include "core/bad_numbers.hpp"
#include "core/reader.hpp"
#include "solvers/simulation.hpp"

#include <new>

namespace gudgeon {

namespace {

std::string source_of(const Arguments& arguments) {
    using Command = Arguments::Command;
    const bool rests = arguments.command == Command::statics || arguments.command == Command::modes;
    return rests ? arguments.rest.model.model : arguments.run.model.model;
}

int dispatch(const Arguments& arguments, const Console& console) {
    switch (arguments.command) {
    case Arguments::Command::run:
        return run(arguments.run, console);
    case Arguments::Command::resume:
        return resume(arguments.resume, console);
    case Arguments::Command::check:
        return check(arguments.model, console);
    case Arguments::Command::statics:
        return statics(arguments.rest, console);
    case Arguments::Command::modes:
        return modes(arguments.rest, console);
    case Arguments::Command::list:
        return list(console);
    case Arguments::Command::export_model:
        return export_model(arguments.model, console);
    case Arguments::Command::text:
        break;
    }
    console.out << arguments.text;
    return Exit::ok;
}

} // namespace

int command_line(const std::vector<std::string>& args, const Console& console) {
    const auto fail = [&](int code, const std::string& message) {
        console.out.flush();
        console.err << message << '\n';
        return code;
    };
    Arguments arguments;
    try {
        arguments = parse_arguments(args);
        const int code = dispatch(arguments, console);
        console.out.flush();
        return console.out ? code : fail(Exit::files, "gudgeon: standard output cannot be written");
    } catch (const UsageError& error) {
        return fail(Exit::refused, error.what());
    } catch (const ModelError& error) {
        return fail(Exit::refused, error.what());
    } catch (const AssemblyError& error) {
        return fail(Exit::assembly, source_of(arguments) + ": " + error.what());
    } catch (const EquilibriumError& error) {
        return fail(Exit::stopped, source_of(arguments) + ": " + error.what());
    } catch (const BadNumberError& error) {
        return fail(Exit::stopped, source_of(arguments) + ": " + error.what());
    } catch (const FileError& error) {
        return fail(Exit::files, error.what());
    } catch (const std::bad_alloc&) {
        return fail(Exit::unexpected, "gudgeon: out of memory");
    } catch (const std::exception& error) {
        return fail(Exit::unexpected, std::string("gudgeon: unexpected: ") + error.what());
    }
}

} // namespace gudgeon

#include "app/load_model.hpp"

#include "app/exit_codes.hpp"
#include "app/numbers.hpp"
#include "core/reader.hpp"
#include "core/words.hpp"
#include "models/mechanisms.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

namespace gudgeon {

namespace {

std::vector<std::string> mechanism_names() {
    std::vector<std::string> names;
    for (const Mechanism& m : mechanisms())
        names.push_back(m.name);
    return names;
}

LoadedModel load_text(const ModelArguments& arguments, std::string text) {
    std::map<std::string, double> overrides;
    for (const auto& [name, text] : arguments.parameters) {
        const std::optional<double> value = to_number(text);
        if (!value)
            throw ModelError(arguments.model, "/parameters/" + name,
                             fmt::format("'{}' is no finite number", text), "a finite number");
        overrides[name] = *value;
    }
    LoadedModel loaded{parse_model(text, arguments.model, overrides), false, {}, {}};
    loaded.text = std::move(text);
    loaded.parameters = loaded.model.parameters;
    if (loaded.model.parameters.empty())
        loaded.parameters = nlohmann::ordered_json::object();
    return loaded;
}

LoadedModel load_file(const ModelArguments& arguments) {
    return load_text(arguments, read_model_text(arguments.model));
}

} // namespace

Model take_model(LoadedModel& loaded) {
    Model out = std::move(loaded.model);
    loaded.model = {};
    loaded.model.name = out.name;
    loaded.model.source = out.source;
    return out;
}

LoadedModel load_again(const ModelArguments& arguments, const std::string& text) {
    return text.empty() ? load_mechanism(arguments) : load_text(arguments, text);
}

LoadedModel load_mechanism(const ModelArguments& arguments) {
    const Mechanism* mechanism = find_mechanism(arguments.model);
    const std::vector<std::string> names = mechanism_names();
    if (!mechanism)
        throw UsageError("NAME", fmt::format("there is no ready mechanism '{}'", arguments.model),
                         suggestion(arguments.model, names) + listed(names));
    LoadedModel loaded{
        build_mechanism(arguments.model, arguments.parameters), true, nlohmann::ordered_json::object(), {}};
    loaded.model.source = arguments.model;
    const ParameterValues values = read_parameters(*mechanism, arguments.parameters);
    for (const auto& [name, word] : values.words()) {
        const auto number = values.numbers().find(name);
        if (number != values.numbers().end())
            loaded.parameters[name] = number->second;
        else
            loaded.parameters[name] = word;
    }
    return loaded;
}

LoadedModel load_model(const ModelArguments& arguments) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(arguments.model, error);
    const bool folder = fs::is_directory(status); // perhaps the results of an earlier run
    if (fs::exists(status) && !folder)
        return load_file(arguments);
    if (find_mechanism(arguments.model))
        return load_mechanism(arguments);
    if (folder || status.type() == fs::file_type::none || status.type() == fs::file_type::unknown)
        return load_file(arguments); // says what is wrong with it
    const std::vector<std::string> names = mechanism_names();
    throw UsageError("MODEL", fmt::format("'{}' is neither a file nor a ready mechanism", arguments.model),
                     suggestion(arguments.model, names) + "a model file or one of " + listed(names));
}

} // namespace gudgeon

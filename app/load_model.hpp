// MODEL of the command line -> Model.
#pragma once

#include "app/arguments.hpp"
#include "core/model.hpp"

#include <nlohmann/json.hpp>

namespace gudgeon {

struct LoadedModel {
    Model model;
    bool ready = false;                // a ready mechanism, not a file
    nlohmann::ordered_json parameters; // as used; words too
    std::string text;                  // of the file; empty: a ready mechanism
};

/// A file where there is one of this name, else a ready mechanism. Throws UsageError, FileError, ModelError.
LoadedModel load_model(const ModelArguments& arguments);

/// The model of such arguments again, from the text of its file where it came from one.
LoadedModel load_again(const ModelArguments& arguments, const std::string& text);

/// Ready mechanisms only.
LoadedModel load_mechanism(const ModelArguments& arguments);

/// The model out of what was loaded; name and source stay there too.
Model take_model(LoadedModel& loaded);

} // namespace gudgeon

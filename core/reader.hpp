// Model file (JSON, models/format.md) -> Model.
#pragma once

#include "core/model.hpp"

#include <filesystem>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace gudgeon {

/// A file that cannot be opened, read or written.
class FileError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

/// Reads and validates a model. overrides: values for parameters of the file ("--param").
/// Throws FileError if the file cannot be read, ModelError for everything that is refused in it.
Model read_model(const std::filesystem::path& file, const std::map<std::string, double>& overrides = {});

/// The text of a model file. Throws FileError.
std::string read_model_text(const std::filesystem::path& file);

/// The same as read_model() for text; source names it in messages.
Model parse_model(std::string_view text, std::string source,
                  const std::map<std::string, double>& overrides = {});

} // namespace gudgeon

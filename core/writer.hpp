// Model -> JSON in the format of models/format.md. Parameters are written as used; every number is a
// literal, and reading the text back gives the same doubles.
#pragma once

#include "core/model.hpp"

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace gudgeon {

nlohmann::ordered_json to_json(const Model& model);
std::string write_model(const Model& model);

} // namespace gudgeon

// `gudgeon check`, `gudgeon list`, `gudgeon export`.
#pragma once

#include "app/arguments.hpp"
#include "app/console.hpp"

namespace gudgeon {

/// Sizes, degrees of freedom, assembly, constraints that repeat each other. Returns Exit::ok or
/// Exit::assembly.
int check(const ModelArguments& arguments, const Console& console);

int list(const Console& console);

int export_model(const ModelArguments& arguments, const Console& console);

} // namespace gudgeon

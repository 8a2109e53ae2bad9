// `gudgeon run`.
#pragma once

#include "app/arguments.hpp"
#include "app/console.hpp"

namespace gudgeon {

/// Returns what the command ends with; throws what command_line() tells the user.
int run(const RunArguments& arguments, const Console& console);

} // namespace gudgeon

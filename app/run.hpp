// `gudgeon run` and `gudgeon resume`.
#pragma once

#include "app/arguments.hpp"
#include "app/console.hpp"

namespace gudgeon {

/// Both return what the command ends with, and throw what command_line() tells the user.
int run(const RunArguments& arguments, const Console& console);
int resume(const ResumeArguments& arguments, const Console& console);

} // namespace gudgeon

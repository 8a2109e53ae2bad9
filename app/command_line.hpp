// The command: arguments in, exit code out. Nothing else in Gudgeon prints.
#pragma once

#include "app/console.hpp"

#include <string>
#include <vector>

namespace gudgeon {

/// args: without the program's name. Throws nothing but what the streams throw.
int command_line(const std::vector<std::string>& args, const Console& console);

} // namespace gudgeon

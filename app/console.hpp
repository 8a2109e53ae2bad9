// Where the command writes to.
#pragma once

#include <ostream>

namespace gudgeon {

struct Console {
    std::ostream& out;
    std::ostream& err;
    bool terminal = false; // err is a terminal: show progress
};

} // namespace gudgeon

#include "app/command_line.hpp"

#include <iostream>

#include <unistd.h>

int main(int argc, char** argv) {
    return gudgeon::command_line({argv + 1, argv + argc}, {std::cout, std::cerr, isatty(STDERR_FILENO) != 0});
}

// Kernels whose instructions callgrind counts: a program of this kind is run and judged by regression.py.
// Needs the standard library and valgrind's headers; nothing of the project that it counts.
//
// Set-up, a first run (caches, symbols bound late) and reset run uncounted. Each kernel's counts end up in a
// file of their own, named by the kernel. On standard output, separated by tabs, one line each:
//   environment NAME VALUE        what moves counts without any change of the sources
//   kernel NAME REPEATS NOTE      when its counts are written
// Without valgrind the program runs all the same and counts nothing.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace counted {

struct Work {
    std::function<void()> run;         // counted; always the same amount of work
    std::function<void()> reset;       // before every run where set, not counted
    std::function<std::string()> note; // after all runs: what they did, for the reader of a report
};

struct Kernel {
    std::string name; // group/what; without tabs and line breaks
    std::function<Work()> prepare;
    int repeats = 10; // a multiple of 10: a kernel slower by 10 % is one more run in ten
};

/// Fixed arithmetic that depends on no library; counts are judged as ratios to it.
Kernel calibration();

/// The whole program: counts the calibration, then the kernels. environment: versions of libraries; compiler,
/// its flags and the version of glibc are added.
///   --only GLOB           kernels whose name fits (and the calibration)
///   --slower GLOB=PERCENT these do so much more work than they should: what a check must notice
///   --list                names, one a line
/// Returns the exit status: 0, or 2 with a message on standard error.
int run(int argc, char** argv, const std::vector<Kernel>& kernels,
        const std::map<std::string, std::string>& environment);

} // namespace counted

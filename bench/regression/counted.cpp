#include "counted.hpp"

#include <fnmatch.h>
#include <gnu/libc-version.h>
#include <valgrind/callgrind.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <stdexcept>
#include <string_view>

namespace counted {

namespace {

struct Options {
    std::string only = "*", slower; // globs
    double percent = 0;             // more work of those that fit `slower`
    bool list = false;
};

bool fits(const std::string& glob, const std::string& name) {
    return fnmatch(glob.c_str(), name.c_str(), 0) == 0;
}

Options parse(int argc, char** argv) {
    Options options;
    for (int i = 1; i < argc; ++i) {
        const std::string_view word = argv[i];
        if (word == "--list") {
            options.list = true;
        } else if (word == "--only" && i + 1 < argc) {
            options.only = argv[++i];
        } else if (word == "--slower" && i + 1 < argc) {
            const std::string value = argv[++i];
            const std::size_t split = value.rfind('=');
            if (split == std::string::npos)
                throw std::invalid_argument("--slower wants GLOB=PERCENT");
            options.slower = value.substr(0, split);
            options.percent = std::stod(value.substr(split + 1));
        } else {
            throw std::invalid_argument("unknown option '" + std::string(word) +
                                        "'; allowed: --only GLOB, --slower GLOB=PERCENT, --list");
        }
    }
    return options;
}

void count(const Kernel& kernel, int repeats) {
    const Work work = kernel.prepare();
    const auto reset = [&work] {
        if (work.reset)
            work.reset();
    };
    reset();
    work.run();
    CALLGRIND_START_INSTRUMENTATION;
    CALLGRIND_ZERO_STATS; // else the summary of a dump is off by what was counted before
    for (int i = 0; i < repeats; ++i) {
        if (work.reset) {
            CALLGRIND_TOGGLE_COLLECT;
            work.reset();
            CALLGRIND_TOGGLE_COLLECT;
        }
        work.run();
    }
    CALLGRIND_DUMP_STATS_AT(kernel.name.c_str());
    CALLGRIND_STOP_INSTRUMENTATION;
    std::printf("kernel\t%s\t%d\t%s\n", kernel.name.c_str(), repeats, work.note ? work.note().c_str() : "");
    std::fflush(stdout);
}

std::string compiler() {
#if defined(__clang__)
    return "Clang " __clang_version__;
#elif defined(__GNUC__)
    return "GNU " __VERSION__;
#else
    return "unknown";
#endif
}

} // namespace

int run(int argc, char** argv, const std::vector<Kernel>& kernels,
        const std::map<std::string, std::string>& environment) {
    try {
        const Options options = parse(argc, argv);
        if (options.list) {
            for (const Kernel& kernel : kernels)
                std::puts(kernel.name.c_str());
            return 0;
        }
        std::map<std::string, std::string> items = environment;
        items["compiler"] = compiler();
        items["flags"] = COUNTED_FLAGS;
        items["glibc"] = gnu_get_libc_version();
        for (const auto& [name, value] : items)
            std::printf("environment\t%s\t%s\n", name.c_str(), value.c_str());

        const Kernel first = calibration();
        count(first, first.repeats);
        for (const Kernel& kernel : kernels) {
            if (!fits(options.only, kernel.name))
                continue;
            const double more = fits(options.slower, kernel.name) ? options.percent / 100 : 0;
            count(kernel, kernel.repeats + static_cast<int>(std::lround(more * kernel.repeats)));
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
        return 2;
    }
}

} // namespace counted

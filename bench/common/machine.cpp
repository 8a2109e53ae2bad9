#include "bench/common/machine.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <thread>

namespace gudgeon::bench {

namespace {

#if defined(__clang__)
constexpr const char* compiler = "Clang " __clang_version__;
#else
constexpr const char* compiler = "GCC " __VERSION__;
#endif

} // namespace

double load_now() {
    double load = 0;
    std::ifstream("/proc/loadavg") >> load;
    return load;
}

nlohmann::json describe_machine() {
    std::string processor = "unknown";
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);)
        if (line.rfind("model name", 0) == 0) {
            processor = line.substr(line.find(':') + 2);
            break;
        }
    const char* commit = std::getenv("GUDGEON_COMMIT");
    return {{"processor", processor},
            {"cores", std::thread::hardware_concurrency()},
            {"load", load_now()},
            {"compiler", compiler},
            {"build", GUDGEON_BUILD_TYPE},
            {"version", GUDGEON_VERSION},
            {"commit", commit ? commit : ""},
            {"date", fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(std::time(nullptr)))}};
}

} // namespace gudgeon::bench

#include "app/progress.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

std::string duration(double seconds) {
    if (seconds < 60)
        return fmt::format("{:.0f} s", seconds);
    const long whole = static_cast<long>(std::min(seconds, 1e9));
    if (whole < 3600)
        return fmt::format("{} min {:02d} s", whole / 60, whole % 60);
    return fmt::format("{} h {:02d} min", whole / 3600, whole / 60 % 60);
}

Progress::Progress(const Console& console, bool wanted, double end)
    : err_(console.err), wanted_(wanted && console.terminal), end_(end) {}

Progress::~Progress() {
    if (drawn_)
        err_ << "\r\033[K" << std::flush;
}

void Progress::update(double t, long steps) {
    if (!wanted_)
        return;
    const clock::time_point now = clock::now();
    if (now - last_ < std::chrono::milliseconds(200))
        return;
    last_ = now;
    drawn_ = true;
    const double share = t / end_;
    const double passed = std::chrono::duration<double>(now - begin_).count();
    constexpr int width = 30;
    const int filled = static_cast<int>(share * width);
    err_ << fmt::format("\r[{:#<{}}{:.<{}}] {:5.1f} %  t = {:.4g} of {:.4g} s  {} steps  {} left\033[K", "",
                        filled, "", width - filled, 100 * share, t, end_, steps,
                        share > 0 ? duration(passed / share - passed) : "?")
         << std::flush;
}

} // namespace gudgeon

// Loops over ranges, shared among threads.
#pragma once

#include <cstddef>

namespace gudgeon {

/// f(begin, end) over [0, size) in one piece, or in one piece for each thread where a thread gets at least
/// `grain`. The pieces are the same for the same number of threads; f must not depend on where they end.
/// f must not throw.
template <class F> void for_ranges(std::ptrdiff_t size, int threads, std::ptrdiff_t grain, F&& f) {
    if (threads <= 1 || size < threads * grain) {
        f(std::ptrdiff_t(0), size);
        return;
    }
#pragma omp parallel for schedule(static) num_threads(threads)
    for (int i = 0; i < threads; ++i)
        f(size * i / threads, size * (i + 1) / threads);
}

} // namespace gudgeon

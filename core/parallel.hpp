// Loops shared among threads: turns or ranges that are independent of each other, in any order.
#pragma once

#include <cstddef>

namespace gudgeon {

/// f(i) for i in [begin, end), in equal shares on `threads` threads; on one below `threshold` turns, where
/// starting threads costs more than it brings. With one thread the loop enters no parallel region, which
/// allocates.
template <class F>
void parallel_for(int threads, std::ptrdiff_t begin, std::ptrdiff_t end, std::ptrdiff_t threshold, F&& f) {
    if (threads == 1 || end - begin < threshold) {
        for (std::ptrdiff_t i = begin; i < end; ++i)
            f(i);
    } else {
#pragma omp parallel for schedule(static) num_threads(threads)
        for (std::ptrdiff_t i = begin; i < end; ++i)
            f(i);
    }
}

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

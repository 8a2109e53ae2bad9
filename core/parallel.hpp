// Loops whose turns are independent of each other, so that they may run in any order on any number of
// threads.
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

} // namespace gudgeon

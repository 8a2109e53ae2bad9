// Counts every malloc of the process made while a function runs (on its thread).
#pragma once

#include <cstdlib> // __GLIBC__

#if defined(__SANITIZE_ADDRESS__) || !defined(__GLIBC__)
#define GUDGEON_COUNTS_ALLOCATIONS 0 // the sanitizer has its own malloc
#else
#define GUDGEON_COUNTS_ALLOCATIONS 1
#endif

namespace gudgeon::test {

#if GUDGEON_COUNTS_ALLOCATIONS
void start_counting_allocations();
long stop_counting_allocations();

template <class F> long count_allocations(F&& f) {
    start_counting_allocations();
    f();
    return stop_counting_allocations();
}
#else
template <class F> long count_allocations(F&& f) {
    f();
    return 0;
}
#endif

} // namespace gudgeon::test

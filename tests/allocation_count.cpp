#include "tests/allocation_count.hpp"

#include <cstddef>

#if GUDGEON_COUNTS_ALLOCATIONS
namespace {
thread_local bool counting = false;
thread_local long counted = 0;
} // namespace

// Put in place of glibc's for the whole program, libraries included; operator new comes here too.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) noexcept {
    counted += counting;
    return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
    counted += counting;
    return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) noexcept {
    counted += counting;
    return __libc_realloc(p, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) noexcept {
    counted += counting;
    return __libc_memalign(alignment, size);
}
int posix_memalign(void** p, std::size_t alignment, std::size_t size) noexcept {
    counted += counting;
    *p = __libc_memalign(alignment, size);
    return *p ? 0 : 12; // ENOMEM
}
}

namespace gudgeon::test {

void start_counting_allocations() {
    counted = 0;
    counting = true;
}

long stop_counting_allocations() {
    counting = false;
    return counted;
}

} // namespace gudgeon::test
#endif

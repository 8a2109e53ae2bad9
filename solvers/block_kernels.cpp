#include "solvers/block_kernels.hpp"

#include <algorithm>
#include <cmath>

#define GUDGEON_INLINE [[gnu::always_inline]] inline

namespace gudgeon {

namespace {

#pragma GCC diagnostic ignored "-Wpsabi" // vectors are passed to functions that are always inlined

/// Vectors of `width` doubles. The same arithmetic for any width.
template <int width> struct Vectors;
template <> struct Vectors<2> {
    using Value = double __attribute__((vector_size(16)));
    using InMemory = double __attribute__((vector_size(16), aligned(8), may_alias));
    using Singles = float __attribute__((vector_size(8)));
    using SinglesInMemory = float __attribute__((vector_size(8), aligned(4), may_alias));
};
template <> struct Vectors<4> {
    using Value = double __attribute__((vector_size(32)));
    using InMemory = double __attribute__((vector_size(32), aligned(8), may_alias));
    using Singles = float __attribute__((vector_size(16)));
    using SinglesInMemory = float __attribute__((vector_size(16), aligned(4), may_alias));
};

template <int width> GUDGEON_INLINE typename Vectors<width>::Value at(const double* p) {
    return *reinterpret_cast<const typename Vectors<width>::InMemory*>(p);
}
template <int width> GUDGEON_INLINE typename Vectors<width>::Value at(const float* p) {
    const typename Vectors<width>::Singles x =
        *reinterpret_cast<const typename Vectors<width>::SinglesInMemory*>(p);
    return __builtin_convertvector(x, typename Vectors<width>::Value);
}
template <int width> GUDGEON_INLINE void put(double* p, const typename Vectors<width>::Value& v) {
    *reinterpret_cast<typename Vectors<width>::InMemory*>(p) = v;
}

GUDGEON_INLINE double magnitude(double re, double im) { return std::max(std::abs(re), std::abs(im)); }

template <int planes> GUDGEON_INLINE double entry_size(const double* column, int i, int height) {
    return planes == 1 ? std::abs(column[i]) : magnitude(column[i], column[height + i]);
}

template <int planes> GUDGEON_INLINE void swap_rows(double* f, int size, int height, int i, int j) {
    for (int c = 0; c < planes * size; ++c)
        std::swap(f[long(c) * height + i], f[long(c) * height + j]);
}

/// to -= from * factor for every column `to` but number k, factor being row k of it times the pivot's inverse
/// (re, im), which takes its place. `vectors` vectors of `from`, the pivot's column, stay in registers.
template <int planes, int width, int vectors>
GUDGEON_INLINE void clear_row(double* f, int size, int height, int k, double re, double im) {
    using Vec = typename Vectors<width>::Value;
    const long stride = long(planes) * height;
    const double* from = f + k * stride;
    Vec fr[vectors], fi[vectors];
#pragma GCC unroll 8
    for (int v = 0; v < vectors; ++v) {
        fr[v] = at<width>(from + width * v);
        fi[v] = planes == 2 ? at<width>(from + height + width * v) : fr[v];
    }
    double* to = f;
    for (int j = 0; j < size; ++j, to += stride) {
        if (j == k)
            continue;
        if constexpr (planes == 1) {
            const double t = to[k] * re;
            if (t == 0)
                continue;
#pragma GCC unroll 8
            for (int v = 0; v < vectors; ++v)
                put<width>(to + width * v, at<width>(to + width * v) - fr[v] * t);
            to[k] = t;
        } else {
            const double cr = to[k], ci = to[height + k];
            if (cr == 0 && ci == 0)
                continue;
            const double tr = cr * re - ci * im, ti = cr * im + ci * re;
#pragma GCC unroll 8
            for (int v = 0; v < vectors; ++v) {
                double *x = to + width * v, *y = x + height;
                put<width>(x, at<width>(x) - (fr[v] * tr - fi[v] * ti));
                put<width>(y, at<width>(y) - (fr[v] * ti + fi[v] * tr));
            }
            to[k] = tr;
            to[height + k] = ti;
        }
    }
}

/// The same for any height.
template <int planes, int width>
GUDGEON_INLINE void clear_row_tall(double* f, int size, int height, int k, double re, double im) {
    const long stride = long(planes) * height;
    const double* from = f + k * stride;
    double* to = f;
    for (int j = 0; j < size; ++j, to += stride) {
        if (j == k)
            continue;
        const double cr = to[k], ci = planes == 2 ? to[height + k] : 0;
        if (cr == 0 && ci == 0)
            continue;
        const double tr = planes == 2 ? cr * re - ci * im : cr * re, ti = cr * im + ci * re;
        for (int i = 0; i < height; i += width) {
            double *x = to + i, *y = x + height;
            const auto fr = at<width>(from + i);
            if constexpr (planes == 1) {
                put<width>(x, at<width>(x) - fr * tr);
            } else {
                const auto fi = at<width>(from + height + i);
                put<width>(x, at<width>(x) - (fr * tr - fi * ti));
                put<width>(y, at<width>(y) - (fr * ti + fi * tr));
            }
        }
        to[k] = tr;
        if constexpr (planes == 2)
            to[height + k] = ti;
    }
}

/// clear_row() where the height is one of `fours` times four; else false.
template <int planes, int width, int... fours>
GUDGEON_INLINE bool clear_short_row(double* f, int size, int height, int k, double re, double im) {
    return ((height == 4 * fours &&
             (clear_row<planes, width, fours*(4 / width)>(f, size, height, k, re, im), true)) ||
            ...);
}

/// Exchanges unknown k (Gauss & Jordan).
template <int planes, int width> GUDGEON_INLINE void exchange(double* f, int size, int height, int k) {
    double* column = f + long(k) * planes * height;
    double re = column[k], im = 0;
    if constexpr (planes == 2) {
        im = column[height + k];
        const double square = re * re + im * im;
        re = re / square;
        im = -im / square;
    } else {
        re = 1 / re;
    }
    if (!clear_short_row<planes, width, 2, 3, 4, 5, 6>(f, size, height, k, re, im))
        clear_row_tall<planes, width>(f, size, height, k, re, im);
    for (int i = 0; i < height; ++i) {
        if constexpr (planes == 1) {
            column[i] = -column[i] * re;
        } else {
            const double cr = column[i], ci = column[height + i];
            column[i] = -(cr * re - ci * im);
            column[height + i] = -(cr * im + ci * re);
        }
    }
    column[k] = re;
    if constexpr (planes == 2)
        column[height + k] = im;
}

template <int planes, int width>
GUDGEON_INLINE double sweep(double* f, int size, int pivots, int height, int* swaps, int* bad) {
    const long stride = long(planes) * height;
    double smallest = 1;
    for (int k = 0; k < pivots; ++k) {
        const double* column = f + k * stride;
        int best = k;
        double largest = entry_size<planes>(column, k, height);
        for (int i = k + 1; i < pivots; ++i)
            if (const double x = entry_size<planes>(column, i, height); x > largest) {
                largest = x;
                best = i;
            }
        if (!(largest > 0)) {
            *bad = k;
            return 0;
        }
        if (largest < smallest) {
            smallest = largest;
            *bad = k;
        }
        swaps[k] = best;
        if (best != k)
            swap_rows<planes>(f, size, height, k, best);
        exchange<planes, width>(f, size, height, k);
    }
    for (int k = pivots; k-- > 0;) // rows were exchanged: so are the columns of the inverse
        if (swaps[k] != k)
            for (int i = 0; i < stride; ++i)
                std::swap(f[k * stride + i], f[swaps[k] * stride + i]);
    return smallest;
}

/// width * vectors rows of all right-hand sides, sums kept in registers.
template <int planes, int width, int vectors, int sides, class Stored>
GUDGEON_INLINE void product_tile(const Stored* a, int height, int columns, const double* x, long x_stride,
                                 long x_plane, double* y, long y_stride) {
    using Vec = typename Vectors<width>::Value;
    Vec re[sides][vectors], im[sides][vectors];
#pragma GCC unroll 8
    for (int s = 0; s < sides; ++s)
#pragma GCC unroll 8
        for (int v = 0; v < vectors; ++v)
            re[s][v] = im[s][v] = Vec{};
    for (int j = 0; j < columns; ++j, a += long(planes) * height) {
#pragma GCC unroll 8
        for (int s = 0; s < sides; ++s) {
            const double xr = x[s * x_stride + j], xi = planes == 2 ? x[s * x_stride + x_plane + j] : 0;
#pragma GCC unroll 8
            for (int v = 0; v < vectors; ++v) {
                const Vec ar = at<width>(a + width * v);
                if constexpr (planes == 1) {
                    re[s][v] += ar * xr;
                } else {
                    const Vec ai = at<width>(a + height + width * v);
                    re[s][v] += ar * xr - ai * xi;
                    im[s][v] += ar * xi + ai * xr;
                }
            }
        }
    }
#pragma GCC unroll 8
    for (int s = 0; s < sides; ++s)
#pragma GCC unroll 8
        for (int v = 0; v < vectors; ++v) {
            put<width>(y + s * y_stride + width * v, re[s][v]);
            if constexpr (planes == 2)
                put<width>(y + s * y_stride + height + width * v, im[s][v]);
        }
}

template <int planes, int width, int sides, class Stored>
GUDGEON_INLINE void product_sides(const Stored* a, int height, int columns, const double* x, long x_stride,
                                  long x_plane, double* y, long y_stride) {
    constexpr int tile = planes == 1 ? 4 : 2; // with their sums they fit into the registers
    int row = 0;
    for (; row + tile * width <= height; row += tile * width)
        product_tile<planes, width, tile, sides>(a + row, height, columns, x, x_stride, x_plane, y + row,
                                                 y_stride);
    if constexpr (tile == 4)
        for (; row + 2 * width <= height; row += 2 * width)
            product_tile<planes, width, 2, sides>(a + row, height, columns, x, x_stride, x_plane, y + row,
                                                  y_stride);
    for (; row < height; row += width)
        product_tile<planes, width, 1, sides>(a + row, height, columns, x, x_stride, x_plane, y + row,
                                              y_stride);
}

template <int planes, int width, class Stored>
GUDGEON_INLINE void product(const Stored* a, int height, int columns, const double* x, long x_stride,
                            long x_plane, double* y, long y_stride, int sides) {
    for (; sides >= 2; sides -= 2, x += 2 * x_stride, y += 2 * y_stride)
        product_sides<planes, width, 2>(a, height, columns, x, x_stride, x_plane, y, y_stride);
    if (sides == 1)
        product_sides<planes, width, 1>(a, height, columns, x, x_stride, x_plane, y, y_stride);
}

#define GUDGEON_BLOCK_KERNELS(suffix, width, attribute)                                                      \
    template <int planes>                                                                                    \
    attribute double sweep_##suffix(double* f, int size, int pivots, int height, int* swaps, int* bad) {     \
        return sweep<planes, width>(f, size, pivots, height, swaps, bad);                                    \
    }                                                                                                        \
    template <int planes, class Stored>                                                                      \
    attribute void product_##suffix(const Stored* a, int height, int columns, const double* x,               \
                                    long x_stride, long x_plane, double* y, long y_stride, int sides) {      \
        product<planes, width>(a, height, columns, x, x_stride, x_plane, y, y_stride, sides);                \
    }                                                                                                        \
    constexpr BlockKernels kernels_##suffix{{sweep_##suffix<1>, sweep_##suffix<2>},                          \
                                            {product_##suffix<1, double>, product_##suffix<2, double>},      \
                                            {product_##suffix<1, float>, product_##suffix<2, float>},        \
                                            #suffix};

GUDGEON_BLOCK_KERNELS(portable, 2, )
#if defined(__x86_64__)
GUDGEON_BLOCK_KERNELS(avx2, 4, __attribute__((target("avx2"))))
#endif

} // namespace

const BlockKernels& portable_block_kernels() { return kernels_portable; }

namespace {
const BlockKernels& best_kernels() {
#if defined(__x86_64__)
    if (__builtin_cpu_supports("avx2"))
        return kernels_avx2;
#endif
    return kernels_portable;
}

const BlockKernels*& chosen_kernels() {
    static const BlockKernels* chosen = &best_kernels();
    return chosen;
}
} // namespace

const BlockKernels& block_kernels() { return *chosen_kernels(); }
void use_portable_block_kernels() { chosen_kernels() = &kernels_portable; }

} // namespace gudgeon

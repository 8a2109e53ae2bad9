// Dense kernels of the block elimination, with vectors of four doubles where the processor has them.
//
// Every number is made by the same multiplications and additions in the same order whatever the length of
// the vectors, so results have the same bits on every x86-64.
//
// Matrices are stored by columns; a column is `height` numbers (a multiple of four), and where numbers are
// complex (planes = 2) the `height` real parts are followed by the `height` imaginary ones.
#pragma once

namespace gudgeon {

struct BlockKernels {
    /// Exchanges the first `pivots` unknowns of the size x size matrix F = [P U; L B], with partial pivoting
    /// among them: F becomes [P^-1, P^-1 U; -L P^-1, B - L P^-1 U]. swaps: pivots ints to work with. Returns
    /// the smallest pivot over the largest number of its column when its turn came, with the column's initial
    /// size (largest of its numbers) counted as well; 0, F unusable: no pivot in column `*bad`.
    using Sweep = double (*)(double* front, int size, int pivots, int height, int* swaps, int* bad);
    /// y(:, c) = A x(:, c): A of `height` rows and `columns` columns, x and y with strides in numbers; for
    /// planes = 2 the imaginary parts of x are x_plane further on and those of y `height`.
    template <class Stored>
    using Product = void (*)(const Stored* a, int height, int columns, const double* x, long x_stride,
                             long x_plane, double* y, long y_stride, int right_hand_sides);
    Sweep sweep[2];                   // [planes - 1]
    Product<double> product[2];       // [planes - 1]
    Product<float> single_product[2]; // numbers stored in single precision, the arithmetic is the same
    template <class Stored> Product<Stored> product_of(int planes) const {
        if constexpr (sizeof(Stored) == sizeof(double))
            return product[planes - 1];
        else
            return single_product[planes - 1];
    }
    const char* name;
};

/// Those for this processor.
const BlockKernels& block_kernels();
/// Those for any processor.
const BlockKernels& portable_block_kernels();
/// block_kernels() gives these from now on, where instructions are counted.
void use_portable_block_kernels();

} // namespace gudgeon

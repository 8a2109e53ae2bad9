#include "solvers/block_kernels.hpp"

#include "tests/solvers/sparse_samples.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <complex>
#include <cstring>
#include <vector>

namespace gudgeon {
namespace {

using Eigen::MatrixXcd;
using Complex = std::complex<double>;

struct Sizes {
    int pivots, boundary;
    int size() const { return pivots + boundary; }
    int height() const { return (size() + 3) & ~3; }
};
// fronts of every height with a loop of its own, and taller ones
const std::vector<Sizes> all_sizes{{1, 0}, {3, 2}, {6, 9}, {11, 8}, {12, 6}, {16, 11}, {9, 20}, {6, 40}};

MatrixXcd random_front(int size, int planes, std::uint64_t seed) {
    MatrixXcd f = samples::random_columns(size, size, seed).cast<Complex>();
    if (planes == 2)
        f += Complex(0, 1) * samples::random_columns(size, size, seed + 1).cast<Complex>();
    return f;
}

std::vector<double> stored(const MatrixXcd& f, int planes, int height) {
    std::vector<double> out(std::size_t(planes) * height * f.cols(), 0.0);
    for (Eigen::Index j = 0; j < f.cols(); ++j)
        for (Eigen::Index i = 0; i < f.rows(); ++i)
            for (int p = 0; p < planes; ++p)
                out[(j * planes + p) * height + i] = p ? f(i, j).imag() : f(i, j).real();
    return out;
}

MatrixXcd taken(const std::vector<double>& x, int rows, int columns, int planes, int height) {
    MatrixXcd out(rows, columns);
    for (int j = 0; j < columns; ++j)
        for (int i = 0; i < rows; ++i)
            out(i, j) = {x[std::size_t(j) * planes * height + i],
                         planes == 2 ? x[(std::size_t(j) * planes + 1) * height + i] : 0.0};
    return out;
}

// [P U; L B] -> [P^-1, P^-1 U; -L P^-1, B - L P^-1 U]
MatrixXcd exchanged(const MatrixXcd& f, int p) {
    const auto b = f.rows() - p;
    const MatrixXcd inverse = f.topLeftCorner(p, p).inverse();
    MatrixXcd out(f.rows(), f.cols());
    out.topLeftCorner(p, p) = inverse;
    out.topRightCorner(p, b) = inverse * f.topRightCorner(p, b);
    out.bottomLeftCorner(b, p) = -f.bottomLeftCorner(b, p) * inverse;
    out.bottomRightCorner(b, b) =
        f.bottomRightCorner(b, b) - f.bottomLeftCorner(b, p) * inverse * f.topRightCorner(p, b);
    return out;
}

TEST(BlockKernels, SweepExchangesThePivots) {
    for (const int planes : {1, 2})
        for (const Sizes s : all_sizes) {
            const MatrixXcd f = random_front(s.size(), planes, 31 * s.pivots + s.boundary);
            std::vector<double> front = stored(f, planes, s.height());
            std::vector<int> swaps(s.pivots);
            int bad = -1;
            const double smallest = block_kernels().sweep[planes - 1](front.data(), s.size(), s.pivots,
                                                                      s.height(), swaps.data(), &bad);
            EXPECT_GT(smallest, 0);
            EXPECT_LE(smallest, 1);
            const MatrixXcd expected = exchanged(f, s.pivots);
            const MatrixXcd found = taken(front, s.size(), s.size(), planes, s.height());
            EXPECT_LT((found - expected).norm(), 1e-11 * expected.norm())
                << planes << ": " << s.pivots << " + " << s.boundary;
        }
}

TEST(BlockKernels, RowsOfPivotsAreExchangedWhereTheDiagonalIsEmpty) {
    const Eigen::Matrix3d a = (Eigen::Matrix3d() << 0, 2, 0, 0, 0, 4, 8, 0, 0).finished();
    std::vector<double> front = stored(a.cast<Complex>(), 1, 4);
    std::vector<int> swaps(3);
    int bad = -1;
    EXPECT_EQ(block_kernels().sweep[0](front.data(), 3, 3, 4, swaps.data(), &bad), 1);
    EXPECT_EQ((taken(front, 3, 3, 1, 4).real() - a.inverse()).norm(), 0);
}

TEST(BlockKernels, ColumnWithoutPivotIsNamed) {
    Eigen::Matrix4d a = Eigen::Matrix4d::Identity();
    a(2, 2) = 0;
    std::vector<double> front = stored(a.cast<Complex>(), 1, 4);
    std::vector<int> swaps(4);
    int bad = -1;
    EXPECT_EQ(block_kernels().sweep[0](front.data(), 4, 4, 4, swaps.data(), &bad), 0);
    EXPECT_EQ(bad, 2);
}

TEST(BlockKernels, ProductAgreesWithEigen) {
    for (const int planes : {1, 2})
        for (const int rows : {4, 8, 12, 16, 20, 28, 60})
            for (const int sides : {1, 2, 3}) {
                const int columns = 7;
                const MatrixXcd a = random_front(rows, planes, rows).leftCols(std::min(rows, columns));
                const MatrixXcd x = random_front(std::max<int>(a.cols(), sides), planes, 5 * rows + sides)
                                        .topLeftCorner(a.cols(), sides);
                const std::vector<double> stored_a = stored(a, planes, rows);
                const std::vector<double> stored_x = stored(x, planes, static_cast<int>(a.cols()));
                std::vector<double> y(std::size_t(planes) * rows * sides, -7.0);
                block_kernels().product[planes - 1](stored_a.data(), rows, static_cast<int>(a.cols()),
                                                    stored_x.data(), planes * a.cols(), a.cols(), y.data(),
                                                    long(planes) * rows, sides);
                EXPECT_LT((taken(y, rows, sides, planes, rows) - a * x).norm(), 1e-14 * rows)
                    << planes << ", " << rows << " rows, " << sides;
            }
}

TEST(BlockKernels, SameBitsOnEveryProcessor) {
    for (const int planes : {1, 2})
        for (const Sizes s : all_sizes) {
            const MatrixXcd f = random_front(s.size(), planes, 77 + s.pivots);
            std::vector<double> front[2], y[2];
            const BlockKernels* kernels[2]{&portable_block_kernels(), &block_kernels()};
            const std::vector<double> x = stored(random_front(s.size() + 2, planes, 3), planes, s.size() + 2);
            for (int k = 0; k < 2; ++k) {
                front[k] = stored(f, planes, s.height());
                y[k].assign(2 * std::size_t(planes) * s.height(), 0.0);
                std::vector<int> swaps(s.pivots);
                int bad = -1;
                kernels[k]->sweep[planes - 1](front[k].data(), s.size(), s.pivots, s.height(), swaps.data(),
                                              &bad);
                kernels[k]->product[planes - 1](front[k].data(), s.height(), s.pivots, x.data(), 1, s.pivots,
                                                y[k].data(), long(planes) * s.height(), 2);
            }
            EXPECT_EQ(std::memcmp(front[0].data(), front[1].data(), front[0].size() * sizeof(double)), 0);
            EXPECT_EQ(std::memcmp(y[0].data(), y[1].data(), y[0].size() * sizeof(double)), 0);
        }
}

} // namespace
} // namespace gudgeon

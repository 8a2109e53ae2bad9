// The work that all counts are compared with: what the kernels of a multibody program consist of, in plain
// loops. Never change it without renewing every record.

#include "counted.hpp"

#include <cstdint>
#include <memory>

namespace counted {

namespace {

constexpr int blocks = 64, columns = 400, entries = 9;

struct Data {
    double a[blocks][9], b[blocks][9], c[blocks][9]; // 3 x 3, by columns
    double value[columns][entries], x[columns + entries];
    int row[columns][entries];
};

void fill(Data& d) {
    std::uint64_t state = 1;
    const auto next = [&state] { // linear congruences (Knuth), in [0, 1)
        state = state * 6364136223846793005u + 1442695040888963407u;
        return static_cast<double>(state >> 11) * 0x1p-53;
    };
    for (int k = 0; k < blocks; ++k)
        for (int i = 0; i < 9; ++i) {
            d.a[k][i] = next() - 0.5;
            d.b[k][i] = next() - 0.5;
            d.c[k][i] = 0;
        }
    for (int j = 0; j < columns; ++j)
        for (int k = 0; k < entries; ++k) {
            d.value[j][k] = 0.1 * (next() - 0.5);
            d.row[j][k] = j + 1 + k;
        }
}

void products(Data& d) { // c += a b of small dense blocks
    for (int k = 0; k < blocks; ++k)
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i)
                for (int l = 0; l < 3; ++l)
                    d.c[k][3 * j + i] += d.a[k][3 * l + i] * d.b[k][3 * j + l];
}

void forward(Data& d) { // a sparse triangular solution
    for (int j = 0; j < columns + entries; ++j)
        d.x[j] = 1;
    for (int j = 0; j < columns; ++j)
        for (int k = 0; k < entries; ++k)
            d.x[d.row[j][k]] -= d.value[j][k] * d.x[j];
}

} // namespace

Kernel calibration() {
    return {"calibration", [] {
                const auto data = std::make_shared<Data>();
                fill(*data);
                return Work{[data] {
                                for (int i = 0; i < 20; ++i) {
                                    products(*data);
                                    forward(*data);
                                }
                            },
                            {},
                            {}};
            }};
}

} // namespace counted

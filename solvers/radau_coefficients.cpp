#include "solvers/radau_coefficients.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>

#include <cmath>

namespace gudgeon {

namespace {

RadauCoefficients make() {
    RadauCoefficients k;
    const double s6 = std::sqrt(6.0);
    k.c = {(4 - s6) / 10, (4 + s6) / 10, 1};
    k.A << (88 - 7 * s6) / 360, (296 - 169 * s6) / 1800, (-2 + 3 * s6) / 225, //
        (296 + 169 * s6) / 1800, (88 + 7 * s6) / 360, (-2 - 3 * s6) / 225,    //
        (16 - s6) / 36, (16 + s6) / 36, 1.0 / 9;
    k.A_inverse = k.A.inverse();
    const Eigen::EigenSolver<Eigen::Matrix3d> eigen(k.A_inverse);
    for (int i = 0; i < 3; ++i) {
        const std::complex<double> value = eigen.eigenvalues()[i];
        const Eigen::Vector3cd vector = eigen.eigenvectors().col(i);
        if (std::abs(value.imag()) < 1e-8) {
            k.real_eigenvalue = value.real();
            k.T.col(0) = vector.real();
        } else if (value.imag() > 0) {
            // A^-1 (x - i y) = (re + i im)(x - i y) gives the block [re, -im; im, re] on (x, y)
            k.eigenvalue = value;
            k.T.col(1) = vector.real();
            k.T.col(2) = -vector.imag();
        }
    }
    k.T_inverse = k.T.inverse();
    k.error_weights = {-(13 + 7 * s6) / 3, (-13 + 7 * s6) / 3, -1.0 / 3};
    return k;
}

} // namespace

const RadauCoefficients& radau_coefficients() {
    static const RadauCoefficients k = make();
    return k;
}

} // namespace gudgeon

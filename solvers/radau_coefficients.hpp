// Coefficients of Radau IIA with three stages (Hairer & Wanner 1996, IV.8).
#pragma once

#include <Eigen/Core>

#include <array>
#include <complex>

namespace gudgeon {

struct RadauCoefficients {
    std::array<double, 3> c;         // nodes, the last is 1
    Eigen::Matrix3d A, A_inverse;    // Runge-Kutta matrix
    double real_eigenvalue;          // of A^-1
    std::complex<double> eigenvalue; // of A^-1, with its conjugate
    /// A^-1 = T Lambda T^-1 with Lambda = [real, 0, 0; 0, re, -im; 0, im, re].
    Eigen::Matrix3d T, T_inverse;
    std::array<double, 3> error_weights; // of the embedded formula of order 3, for stage increments over h
};

const RadauCoefficients& radau_coefficients();

} // namespace gudgeon

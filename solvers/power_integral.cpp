#include "solvers/power_integral.hpp"

namespace gudgeon {

namespace {
constexpr double inner = 0.32732683535398857190; // half of sqrt(3 / 7)
}

const std::array<double, PowerIntegral::points> PowerIntegral::node{0, 0.5 - inner, 0.5, 0.5 + inner, 1};

void PowerIntegral::step(double h, const std::array<VecX, points>& powers) {
    begin_ = end_;
    h_ = h;
    powers_ = powers;
    end_ = at(1);
}

void PowerIntegral::restart(const VecX& energies) {
    begin_ = end_ = energies;
    h_ = 0;
    powers_.fill(VecX::Zero(energies.size()));
}

VecX PowerIntegral::at(double share) const {
    VecX sum = begin_;
    for (int i = 0; i < points; ++i) {
        // Lagrange polynomial of point i as coefficients of powers of the share
        std::array<double, points> c{1};
        double scale = 1;
        for (int j = 0, degree = 0; j < points; ++j) {
            if (j == i)
                continue;
            scale *= node[i] - node[j];
            ++degree;
            for (int k = degree; k >= 0; --k)
                c[k] = (k > 0 ? c[k - 1] : 0.0) - node[j] * c[k];
        }
        double integral = 0;
        for (int k = points - 1; k >= 0; --k)
            integral = (integral + c[k] / (k + 1)) * share;
        sum += h_ * integral / scale * powers_[i];
    }
    return sum;
}

} // namespace gudgeon

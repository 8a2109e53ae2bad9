// Flexible GMRES on vectors of fixed size (Saad 1993), without restarts: the smallest residual of
// b - K x over the corrections that a preconditioner proposes.
#pragma once

#include <Eigen/Core>

#include <cmath>
#include <complex>
#include <vector>

namespace gudgeon {

/// Scalar: double or std::complex<double>. Takes its memory as the iterations need it for the first time.
template <class Scalar> class Gmres {
  public:
    using Vector = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

    void resize(Eigen::Index size, int most) {
        size_ = size;
        most_ = most;
        basis_.assign(most + 1, Vector());
        proposed_.assign(most, Vector());
        h_.setZero(most + 1, most);
        g_.setZero(most + 1);
        cosine_.setZero(most);
        sine_.setZero(most);
    }

    /// A vector of the right size, overwritten by solve().
    Vector& scratch() { return take(proposed_.front()); }

    struct Result {
        bool converged = true;
        int iterations = 0;
    };

    /// b on entry, x on return. propose(v, z, w): z = P^-1 v and w = K z.
    /// Converged: the 2-norm of the residual fell by the factor `tolerance`.
    template <class Propose> Result solve(Vector& x, double tolerance, Propose&& propose) {
        const double length = x.norm();
        if (length == 0)
            return {};
        if (!std::isfinite(length))
            return {false, 0};
        take(basis_[0]) = x / length;
        g_.setZero();
        g_[0] = length;
        Result result{false, 0};
        int useful = 0;
        while (!result.converged && result.iterations < most_) {
            const int j = result.iterations++;
            Vector& w = take(basis_[j + 1]);
            propose(basis_[j], take(proposed_[j]), w);
            for (int i = 0; i <= j; ++i) {
                h_(i, j) = basis_[i].dot(w); // conjugates the first
                w -= h_(i, j) * basis_[i];
            }
            const double rest = w.norm();
            if (!std::isfinite(rest))
                break;
            if (rest > 0)
                w /= rest;
            turn(j, rest);
            ++useful;
            result.converged = std::abs(g_[j + 1]) <= tolerance * length;
            if (rest == 0)
                break;
        }
        gather(x, useful);
        return result;
    }

  private:
    Vector& take(Vector& v) {
        v.resize(size_); // allocates at first use only
        return v;
    }

    // The new column of the Hessenberg matrix through the old rotations, and a rotation of its own.
    void turn(int j, double rest) {
        for (int i = 0; i < j; ++i) {
            const Scalar upper = h_(i, j), lower = h_(i + 1, j);
            h_(i, j) = cosine_[i] * upper + Eigen::numext::conj(sine_[i]) * lower;
            h_(i + 1, j) = cosine_[i] * lower - sine_[i] * upper;
        }
        const Scalar own = h_(j, j);
        const double size = std::abs(own), radius = std::hypot(size, rest);
        if (radius == 0) {
            cosine_[j] = 1;
            sine_[j] = 0;
            return;
        }
        const Scalar phase = size > 0 ? Scalar(own / size) : Scalar(1);
        cosine_[j] = size / radius;
        sine_[j] = rest / radius * Eigen::numext::conj(phase);
        h_(j, j) = radius * phase;
        g_[j + 1] = -sine_[j] * g_[j];
        g_[j] = cosine_[j] * g_[j];
    }

    void gather(Vector& x, int count) {
        x.setZero();
        for (int i = count - 1; i >= 0; --i) {
            if (h_(i, i) == Scalar(0) || !std::isfinite(std::abs(h_(i, i))))
                continue;
            g_[i] /= h_(i, i);
            for (int k = 0; k < i; ++k)
                g_[k] -= h_(k, i) * g_[i];
            x += g_[i] * proposed_[i];
        }
    }

    Eigen::Index size_ = 0;
    int most_ = 0;
    std::vector<Vector> basis_, proposed_;
    Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> h_;
    Vector g_, sine_;
    Eigen::VectorXd cosine_;
};

} // namespace gudgeon

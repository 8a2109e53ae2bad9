// The stage equations of Radau IIA: start values, simplified Newton sweeps, closing of the constraints.

#include "core/parallel.hpp"
#include "solvers/bdf_history.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/radau.hpp"
#include "solvers/radau_coefficients.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <type_traits>

namespace gudgeon {

namespace {

constexpr int most_sweeps = 10;
constexpr int most_turn_iterations = 40;
constexpr std::ptrdiff_t grain = 256; // bodies for a thread
constexpr double most_growth = 10;    // of a step, over which the last polynomial is carried on
// Assumed at least for the first sweep of a step: one accepted unseen leaves stiff modes astray, which the
// error estimate then follows with short steps.
constexpr double least_contraction = 0.1;

} // namespace

// Start values: the collocation polynomial of the last step, carried on; constant accelerations at first
// and after a step so short that its polynomial says nothing about this one.
void Radau::predict(double h) {
    const PhaseTimer timer(statistics_.seconds.control);
    const RadauCoefficients& k = radau_coefficients();
    const std::array<double, 4> nodes{0, k.c[0], k.c[1], 1};
    std::array<double, 4> w{};
    if (have_last_ && h > most_growth * last_h_) // slope of the collocation polynomial at its end
        slope_ = (k.A_inverse(2, 0) * last_V_[0] + k.A_inverse(2, 1) * last_V_[1] +
                  k.A_inverse(2, 2) * last_V_[2]) /
                 last_h_;
    for (int i = 0; i < stages; ++i) {
        X_[i].setZero();
        if (!have_last_ || h > most_growth * last_h_) {
            V_[i] = k.c[i] * h * slope_;
            Z_[i].setZero();
            lambda_[i] = state_.lambda;
            continue;
        }
        const double s = 1 + k.c[i] * h / last_h_;
        interpolation_weights(nodes, s, w.data());
        V_[i] = w[1] * last_V_[0] + w[2] * last_V_[1] + (w[3] - 1) * last_V_[2];
        Z_[i] = w[1] * last_Z_[0] + w[2] * last_Z_[1] + (w[3] - 1) * last_Z_[2];
        interpolation_weights(k.c, s, w.data());
        lambda_[i] = w[0] * last_lambda_[0] + w[1] * last_lambda_[1] + w[2] * last_lambda_[2];
    }
}

bool Radau::turn_to_velocities(double h) {
    const Mat3 hA = h * radau_coefficients().A;
    const std::vector<StepCoordinates::Piece>& pieces = coordinates_->pieces();
    std::atomic<bool> all = true;
    for_ranges(std::ssize(pieces), options_.threads, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
        for (std::ptrdiff_t k = begin; k < end; ++k)
            if (!turn_to_velocity(pieces[k], hA)) {
                all = false;
                break;
            }
    });
    return all;
}

// Coordinates of a piece that fit the velocities: Z_i = h sum_j A_ij q'_j + X_i, rotations by iteration on
// the rotation vectors (theta' = omega + theta x omega / 2 + ...).
bool Radau::turn_to_velocity(const StepCoordinates::Piece& piece, const Mat3& hA) {
    const auto slide = [&]<int N>(std::integral_constant<int, N>) {
        std::array<Eigen::Matrix<double, N, 1>, stages> rate;
        for (int l = 0; l < stages; ++l)
            rate[l] = w_.segment<N>(piece.w) + V_[l].segment<N>(piece.w);
        for (int j = 0; j < stages; ++j) {
            Eigen::Matrix<double, N, 1> r = X_[j].segment<N>(piece.w);
            for (int l = 0; l < stages; ++l)
                r += hA(j, l) * rate[l];
            Z_[j].segment<N>(piece.w) = r;
        }
    };
    if (piece.straight == 3)
        slide(std::integral_constant<int, 3>());
    else if (piece.straight == 2)
        slide(std::integral_constant<int, 2>());
    else if (piece.straight == 1)
        slide(std::integral_constant<int, 1>());
    if (!piece.turns)
        return true;
    const int at = piece.w + piece.straight;
    std::array<Vec3, stages> w, theta;
    for (int j = 0; j < stages; ++j) {
        w[j] = w_.segment<3>(at) + V_[j].segment<3>(at);
        theta[j] = Z_[j].segment<3>(at);
    }
    double change = 1, last = 1;
    // the next change is foreseen from the last two
    for (int iteration = 0; change * change > 1e-15 * last; ++iteration) {
        if (iteration == most_turn_iterations)
            return change < 1e-12;
        std::array<Vec3, stages> rate;
        for (int j = 0; j < stages; ++j) {
            const Vec3 tw = theta[j].cross(w[j]);
            rate[j] = w[j] + 0.5 * tw + rotation_vector::curvature(theta[j]) * theta[j].cross(tw);
        }
        last = change;
        change = 0;
        for (int j = 0; j < stages; ++j) {
            const Vec3 next =
                X_[j].segment<3>(at) + hA(j, 0) * rate[0] + hA(j, 1) * rate[1] + hA(j, 2) * rate[2];
            const double size = next.norm();
            if (!(size < 3))
                return false; // the rotation vector folds at pi
            change = std::max(change, (next - theta[j]).norm() / (1 + size));
            theta[j] = next;
        }
    }
    for (int j = 0; j < stages; ++j)
        Z_[j].segment<3>(at) = theta[j];
    return true;
}

// Friction states at the stages that fit the motion there: sum_j (A^-1)_ij (z_j - z_0) / h = source_i -
// decay_i z_i, three equations for each state.
void Radau::settle_states(double t, double h) {
    const RadauCoefficients& k = radau_coefficients();
    for (int i = 0; i < stages; ++i) {
        stage_coordinates(i, q_stage_);
        u_stage_ = w_ + V_[i];
        coordinates_->set_motion(q_stage_, u_stage_, ws_);
        ws_.z = z_[i];
        state_terms(system_, t + k.c[i] * h, ws_, source_i_[i], decay_i_[i]);
    }
    const Eigen::Matrix3d over_h = k.A_inverse / h;
    const Vec3 from_start = over_h.rowwise().sum();
    ErrorNorm::Value worst;
    for (Eigen::Index s = 0; s < state_.z.size(); ++s) {
        Eigen::Matrix3d matrix = over_h;
        Vec3 rhs;
        for (int i = 0; i < stages; ++i) {
            matrix(i, i) += decay_i_[i][s];
            rhs[i] = source_i_[i][s] + from_start[i] * state_.z[s];
        }
        const Vec3 z = matrix.partialPivLu().solve(rhs);
        for (int i = 0; i < stages; ++i) {
            source_i_[i][s] = z[i] - z_[i][s]; // the change
            z_[i][s] = z[i];
        }
    }
    for (int i = 0; i < stages; ++i)
        worst = ErrorNorm::worse(worst, norm_.states(source_i_[i]));
    z_change_ = worst.norm;
}

void Radau::stage_coordinates(int i, VecX& q) const {
    q = x_;
    coordinates_->shift(Z_[i], q);
}

// Derivatives at the predicted second stage, the middle of the step.
void Radau::linearise_in_step() {
    const PhaseTimer timer(statistics_.seconds.assemble);
    stage_coordinates(1, q_stage_);
    u_stage_ = w_ + V_[1];
    coordinates_->set_motion(q_stage_, u_stage_, ws_);
    if (has_states()) {
        ws_.z = z_[1];
        state_terms(system_, matrix_t_, ws_, source_, z_matrix_decay_);
    }
    coordinates_->hold();
    linearise(system_, matrix_t_, lambda_[1].data(), ws_);
    if (!on_tree())
        evaluate_rate_rows(system_, matrix_t_, ws_);
    matrix_current_ = true;
}

Radau::Corrector Radau::refresh_matrices(double h) {
    const RadauCoefficients& k = radau_coefficients();
    const double real = k.real_eigenvalue / h;
    const std::complex<double> pair = k.eigenvalue / h;
    {
        const PhaseTimer timer(statistics_.seconds.assemble);
        saddle_.assemble(system_, ws_, real, 1 / real, values_);
        saddle_.assemble(system_, ws_, pair, 1.0 / pair, complex_values_);
    }
    const PhaseTimer timer(statistics_.seconds.factor);
    FactorStatus status = solver_.factor(values_);
    if (status.ok())
        status = pair_ ? pair_->factor(complex_values_, pair / real) : complex_.factor(complex_values_);
    matrix_h_ = status.ok() ? h : 0;
    return factored(status, matrix_t_);
}

// The real one alone, with new derivatives: for the error estimate.
Radau::Corrector Radau::refresh_real_matrix(double h) {
    linearise_in_step();
    const double real = radau_coefficients().real_eigenvalue / h;
    saddle_.assemble(system_, ws_, real, 1 / real, values_);
    matrix_h_ = 0;
    return solver_.factor(values_).ok() ? Corrector::converged : Corrector::slow;
}

// stage_rhs_[i]: force balance (n), velocity constraints (m), position constraints (m).
void Radau::stage_residual(int i, double t, double h) {
    const PhaseTimer timer(statistics_.seconds.evaluate);
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    const Eigen::Matrix3d& inverse = radau_coefficients().A_inverse;
    stage_coordinates(i, q_stage_);
    u_stage_ = w_ + V_[i];
    coordinates_->set_motion(q_stage_, u_stage_, ws_);
    if (has_states())
        ws_.z = z_[i];
    ws_.lambda = lambda_[i];
    evaluate_forces(system_, t, ws_);
    evaluate_constraints(system_, t, lambda_[i].data(), false, ws_);
    ++statistics_.evaluations;
    speeds_ = (1 / h) * (inverse(i, 0) * V_[0] + inverse(i, 1) * V_[1] + inverse(i, 2) * V_[2]);
    coordinates_->momentum_residual(speeds_, ws_.f, stage_rhs_[i]);
    put_open_rows(stage_rhs_[i].segment(n, m), stage_rhs_[i].tail(m));
}

// As solve_second_order(), for the pair of complex eigenvalues.
void Radau::solve_complex(std::complex<double> q_per_u) {
    const PhaseTimer timer(statistics_.seconds.solve);
    const Eigen::Index n = system_.velocities(), m = system_.row_count(), size = n + m;
    Eigen::Map<Eigen::VectorXcd> x(complex_rhs_.data(), 2 * size), y(complex_turn_.data(), size);
    if (on_tree() && !coordinates_->can_drift()) { // nothing to close
        complex_.solve({complex_rhs_.data(), static_cast<std::size_t>(size)}, 1);
        return;
    }
    x.tail(m) -= q_per_u * x.segment(n, m);
    pair_ ? pair_->solve(complex_rhs_, 2) : complex_.solve(complex_rhs_, 2);
    if (m == 0 || on_tree())
        return;
    double largest_change = 0;
    y.setZero();
    for (const std::complex<double> part : {std::complex<double>(1, 0), std::complex<double>(0, 1)}) {
        for (Eigen::Index j = 0; j < n; ++j) {
            const std::complex<double> change = x[size + j] + q_per_u * x[j];
            pose_change_[j] = part.imag() == 0 ? change.real() : change.imag();
        }
        rate_rows_times(system_, ws_, pose_change_, rate_change_);
        largest_change = std::max(largest_change, largest(rate_change_));
        y.tail(m) -= part * rate_change_;
    }
    if (largest_change <= negligible_rate())
        return;
    pair_ ? pair_->solve(complex_turn_, 1) : complex_.solve(complex_turn_, 1);
    x.head(size) += y;
    x.segment(size, n) -= q_per_u * y.head(n);
}

void Radau::solve_increments(double h) {
    const Eigen::Index n = system_.velocities(), m = system_.row_count(), size = n + m;
    const Eigen::Matrix3d &T = radau_coefficients().T, &inverse = radau_coefficients().T_inverse;
    {
        const PhaseTimer timer(statistics_.seconds.solve);
        const auto transformed = [&](int row, Eigen::Index j) {
            return inverse(row, 0) * stage_rhs_[0][j] + inverse(row, 1) * stage_rhs_[1][j] +
                   inverse(row, 2) * stage_rhs_[2][j];
        };
        for_ranges(size + m, options_.threads, 8 * grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (std::ptrdiff_t j = begin; j < end; ++j) {
                const Eigen::Index at =
                    j < size ? j : j + n; // position residuals begin the second column's rows
                rhs_[at] = transformed(0, j);
                complex_rhs_[at] = {transformed(1, j), transformed(2, j)};
            }
        });
        for (Eigen::Index j = size; j < size + n; ++j) {
            rhs_[j] = 0;
            complex_rhs_[j] = 0;
        }
    }
    solve_second_order(h / radau_coefficients().real_eigenvalue,
                       on_tree() && !coordinates_->can_drift() ? 1 : 2);
    solve_complex(h / radau_coefficients().eigenvalue);
    const PhaseTimer timer(statistics_.seconds.control);
    lambda_change_ = 0;
    for (int i = 0; i < stages; ++i) {
        const auto back = [&](Eigen::Index at) {
            return T(i, 0) * rhs_[at] + T(i, 1) * complex_rhs_[at].real() + T(i, 2) * complex_rhs_[at].imag();
        };
        for (Eigen::Index j = 0; j < n; ++j)
            stage_rhs_[i][j] = back(j);
        if (on_tree()) {
            coordinates_->speeds_of(stage_rhs_[i], speeds_);
            V_[i] += speeds_;
        } else {
            V_[i] += stage_rhs_[i].head(n);
        }
        for (Eigen::Index j = 0; j < m; ++j) {
            const double change = back(n + j);
            lambda_[i][j] += change;
            lambda_change_ = std::max(lambda_change_, std::abs(change));
        }
        if (!on_tree()) {
            for (Eigen::Index j = 0; j < n; ++j)
                X_[i][j] += back(size + j);
        } else if (coordinates_->can_drift()) {
            for (Eigen::Index j = 0; j < n; ++j)
                momentum_[j] = back(size + j);
            coordinates_->speeds_of(momentum_, speeds_);
            X_[i] += speeds_;
        }
    }
    increment_ = {};
    for (int i = 0; i < stages; ++i) {
        momentum_ = h * stage_rhs_[i].head(n); // about the change of Z
        const ErrorNorm::Value at_stage = norm_.increment(momentum_.data(), stage_rhs_[i].data());
        if (!(at_stage.norm <= increment_.norm))
            increment_ = at_stage;
    }
}

// On a tree the sweeps see the rates of its joints' motion one behind: where a drive leaves little free,
// speeds are right at once and multipliers are not.
bool Radau::multipliers_settled() const {
    return !on_tree() || !driven_ ||
           lambda_change_ <= multiplier_share() * (largest(lambda_[2]) + largest(ws_.f)) + 1e-9;
}

Radau::Corrector Radau::correct(double t, double h) {
    const RadauCoefficients& k = radau_coefficients();
    const double tol = std::max(options_.rtol, options_.atol), round_off = 10 * 2.2e-16 / tol;
    // Velocities of a stage, as coordinates rounded to the last place under stiff forces move them: sweeps
    // that shrink no more below this have converged.
    const double noise = std::min(0.03, 2.2e-16 / tol * k.real_eigenvalue / h * largest(state_.q));
    const double target = std::max(round_off, std::min(0.03, std::sqrt(tol)));
    if (!turn_to_velocities(h))
        return Corrector::slow;
    if (has_states()) {
        z_.fill(state_.z);
        settle_states(t, h);
    }
    if (!matrix_current_) {
        matrix_t_ = t + k.c[1] * h;
        linearise_in_step();
        matrix_h_ = 0;
    }
    if (matrix_h_ != h)
        if (const Corrector result = refresh_matrices(h); result != Corrector::converged)
            return result;
    bool stalled = false;
    double last = 0, ratio = std::max(least_contraction, std::pow(std::max(contraction_, 1e-10), 0.8));
    for (sweeps_ = 1; sweeps_ <= most_sweeps; ++sweeps_) {
        for (int i = 0; i < stages; ++i) {
            stage_residual(i, t + k.c[i] * h, h);
            if (!stage_rhs_[i].allFinite()) {
                note_bad_number(t + k.c[i] * h);
                return Corrector::non_finite;
            }
        }
        ++statistics_.newton_sweeps;
        solve_increments(h);
        if (!std::isfinite(increment_.norm))
            return Corrector::non_finite;
        {
            const PhaseTimer timer(statistics_.seconds.control);
            if (!turn_to_velocities(h))
                return Corrector::slow;
            if (has_states()) {
                settle_states(t, h);
                increment_ = ErrorNorm::worse(increment_, {z_change_, -1});
            }
        }
        // near singular positions the second sweep takes back what the first did with unfit multipliers
        const int judged = soft() ? 3 : 2;
        if (sweeps_ >= judged) {
            ratio = increment_.norm / last;
            contraction_ = sweeps_ == judged ? ratio : std::sqrt(ratio * contraction_);
            ratio = contraction_;
            const int left = most_sweeps - sweeps_;
            stalled =
                ratio > 0.95 || (std::pow(ratio, left) / (1 - ratio) * increment_.norm > target && left < 8);
            if (stalled && increment_.norm > noise)
                return Corrector::slow;
        }
        last = std::max(increment_.norm, 1e-300);
        if (!multipliers_settled())
            continue;
        if (stalled || ratio / (1 - std::min(ratio, 0.95)) * increment_.norm <= target) {
            stage_coordinates(2, q_end_);
            u_end_ = w_ + V_[2];
            return close_constraints(t + h) ? Corrector::converged : Corrector::slow;
        }
    }
    return Corrector::slow;
}

// The end of the step by a solution in rhs_ that closes the constraints; the collocation follows.
void Radau::move_end() {
    const Eigen::Index n = system_.velocities(), m = system_.row_count();
    coordinates_->speeds_of(rhs_, speeds_);
    V_[2] += speeds_;
    lambda_[2] += rhs_.segment(n, m);
    momentum_ = rhs_.segment(n + m, n);
    coordinates_->speeds_of(momentum_, speeds_);
    Z_[2] += speeds_; // rotation vectors: to first order, the next round mends it
    stage_coordinates(2, q_end_);
    u_end_ = w_ + V_[2];
}

} // namespace gudgeon

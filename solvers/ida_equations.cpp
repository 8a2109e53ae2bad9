#include "solvers/ida_equations.hpp"

#include "solvers/index1_equations.hpp"

#include <algorithm>
#include <cstdint>
#include <numeric>

namespace gudgeon {

namespace {

using Mat34 = Eigen::Matrix<double, 3, 4>;
using Row12 = Eigen::Map<const Eigen::Matrix<double, 1, 12>>;

Mat34 l_matrix(const Vec4& p) {
    Mat34 l;
    l << -p[1], p[0], p[3], -p[2], -p[2], -p[3], p[0], p[1], -p[3], p[2], -p[1], p[0];
    return l;
}

/// d(L(p)^T x)/dp
Eigen::Matrix4d spin_matrix(const Vec3& x) {
    Eigen::Matrix4d m;
    m << 0, -x[0], -x[1], -x[2], x[0], 0, x[2], -x[1], x[1], -x[2], 0, x[0], x[2], x[1], -x[0], 0;
    return m;
}

} // namespace

IdaEquations::IdaEquations(const System& system, Rows rows, int threads)
    : system_(system), rows_(rows), u0_(system.positions()), z0_(u0_ + system.velocities()),
      lambda0_(z0_ + system.friction_states()), mu0_(lambda0_ + system.row_count()),
      nu0_(mu0_ + system.row_count()), ws_(make_workspace(system, threads)),
      lambda_(VecX::Zero(system.row_count())), mu_(VecX::Zero(system.row_count())),
      nu_(VecX::Zero(system.moving)), drift_(VecX::Zero(system.velocities())),
      rate_rows_(12 * system.rows.size(), 0.0), turn_(system.moving, Mat34::Zero()) {
    const State start = initial_state(system);
    q_ = start.q;
    u_ = start.u;
    source_ = decay_ = VecX::Zero(system.friction_states());
    linearise(system_, 0, lambda_.data(), ws_); // lists the couplings
    build_pattern();
}

void IdaEquations::pack(const State& state, double* y) const {
    Eigen::Map<VecX> out(y, size());
    out.setZero();
    out.head(u0_) = state.q;
    out.segment(u0_, system_.velocities()) = state.u;
    out.segment(z0_, state.z.size()) = state.z;
    out.segment(lambda0_, system_.row_count()) = state.lambda;
}

void IdaEquations::unpack(const double* y, State& state) const {
    const Eigen::Map<const VecX> in(y, size());
    state.q = in.head(u0_);
    state.u = in.segment(u0_, system_.velocities());
    state.z = in.segment(z0_, system_.friction_states());
    state.lambda = in.segment(lambda0_, system_.row_count());
    for (int i = 0; i < system_.moving; ++i)
        state.q.segment<4>(7 * i + 3).normalize();
}

void IdaEquations::pack_rates(double t, const double* y, const VecX& acceleration, double* ydot) {
    const Eigen::Map<const VecX> in(y, size());
    Eigen::Map<VecX> out(ydot, size());
    out.setZero();
    for (int i = 0; i < system_.moving; ++i) {
        out.segment<3>(7 * i) = in.segment<3>(u0_ + 6 * i);
        out.segment<4>(7 * i + 3) = 0.5 * lt_times(in.segment<4>(7 * i + 3), in.segment<3>(u0_ + 6 * i + 3));
    }
    out.segment(u0_, system_.velocities()) = acceleration;
    if (system_.friction_states() == 0)
        return;
    set(y);
    state_terms(system_, t, ws_, source_, decay_);
    out.segment(z0_, ws_.z.size()) = source_ - decay_.cwiseProduct(ws_.z);
}

void IdaEquations::set(const double* y) {
    const Eigen::Map<const VecX> in(y, size());
    q_ = in.head(u0_);
    u_ = in.segment(u0_, system_.velocities());
    lambda_ = in.segment(lambda0_, system_.row_count());
    mu_ = in.segment(mu0_, system_.row_count());
    nu_ = in.segment(nu0_, system_.moving);
    ws_.z = in.segment(z0_, system_.friction_states());
    ws_.lambda = lambda_;
    set_motion(system_, q_, u_, ws_);
}

bool IdaEquations::residual(double t, const double* y, const double* ydot, double* out) {
    set(y);
    evaluate_forces(system_, t, ws_);
    evaluate_constraints(system_, t, lambda_.data(), true, ws_);
    drift_.setZero();
    add_transposed_rows(system_, ws_, mu_, 1.0, drift_);
    inverse_mass_times(system_, drift_, drift_);

    const Eigen::Map<const VecX> rate(ydot, size());
    Eigen::Map<VecX> f(out, size());
    for (int i = 0; i < system_.moving; ++i) {
        const int j = 7 * i, k = 6 * i;
        const Vec4 p = q_.segment<4>(j + 3);
        const Vec3 spin = u_.segment<3>(k + 3) - drift_.segment<3>(k + 3);
        f.segment<3>(j) = rate.segment<3>(j) - u_.segment<3>(k) + drift_.segment<3>(k);
        f.segment<4>(j + 3) = rate.segment<4>(j + 3) - 0.5 * lt_times(p, spin) + 2 * nu_[i] * p;
        f.segment<3>(u0_ + k) = system_.mass[i] * rate.segment<3>(u0_ + k) - ws_.f.segment<3>(k);
        f.segment<3>(u0_ + k + 3) =
            system_.inertia[i] * rate.segment<3>(u0_ + k + 3) - ws_.f.segment<3>(k + 3);
        f[nu0_ + i] = p.squaredNorm() - 1;
    }
    if (system_.friction_states() > 0) {
        state_terms(system_, t, ws_, source_, decay_);
        f.segment(z0_, ws_.z.size()) = rate.segment(z0_, ws_.z.size()) - source_ + decay_.cwiseProduct(ws_.z);
    }
    f.segment(lambda0_, system_.row_count()) = ws_.rate;
    f.segment(mu0_, system_.row_count()) = ws_.phi;
    return f.allFinite();
}

void IdaEquations::jacobian(double t, double cj, const double* y, std::span<double> values) {
    set(y);
    linearise(system_, t, lambda_.data(), ws_);
    const Evaluation e = evaluation(system_, ws_, t);
    for (const auto& batch : system_.constraints)
        batch->rate_gradient(e, rate_rows_.data());
    drift_.setZero();
    add_transposed_rows(system_, ws_, mu_, 1.0, drift_);
    inverse_mass_times(system_, drift_, drift_);
    for (int i = 0; i < system_.moving; ++i)
        turn_[i] = (2 / q_.segment<4>(7 * i + 3).norm()) * l_matrix(ws_.motion[i].p);

    std::fill(values.begin(), values.end(), 0.0);
    const int* slot = slot_.data();
    visit(cj, [&](int, int, double value) { values[*slot++] += value; });
}

// Every coefficient that can be nonzero, always in the same order: (equation, unknown, value). The same
// visit builds the pattern and fills the values.
template <class Emit> void IdaEquations::visit(double cj, Emit&& emit) const {
    for (int i = 0; i < system_.moving; ++i)
        visit_body(i, cj, emit);
    visit_blocks(emit);
    visit_states(cj, emit);
    visit_reactions(emit);
    for (int row = 0; row < system_.row_count(); ++row)
        for (const int side : {0, 1})
            visit_side(row, side, emit);
    if (rows_ == Rows::soft)
        visit_softness(cj, emit);
}

// As in SaddleMatrix: rows that repeat each other leave the matrix regular.
template <class Emit> void IdaEquations::visit_softness(double cj, Emit&& emit) const {
    for (int row = 0; row < system_.row_count(); ++row) {
        double sum = 0;
        for (const int side : {0, 1}) {
            const int body = side ? system_.rows[row].b : system_.rows[row].a;
            if (body >= system_.moving)
                continue;
            const Row12 g(ws_.rows.data() + 12 * std::size_t(row));
            const Vec3 turn = g.segment<3>(6 * side + 3);
            sum += g.segment<3>(6 * side).squaredNorm() / system_.mass[body] +
                   turn.dot(system_.inverse_inertia[body] * turn);
        }
        const double soft = sum > 0 ? -SaddleMatrix::softness * sum / cj : -1.0;
        emit(lambda0_ + row, lambda0_ + row, soft);
        emit(mu0_ + row, mu0_ + row, soft);
    }
}

template <class Emit> void IdaEquations::visit_body(int i, double cj, Emit&& emit) const {
    const int r = 7 * i, p = r + 3, v = u0_ + 6 * i, w = v + 3, nu = nu0_ + i;
    const Vec4 euler = q_.segment<4>(p);
    const Vec3 spin = u_.segment<3>(6 * i + 3) - drift_.segment<3>(6 * i + 3);
    for (int k = 0; k < 3; ++k) {
        emit(r + k, r + k, cj);
        emit(r + k, v + k, -1.0);
        emit(v + k, v + k, cj * system_.mass[i]);
        for (int j = 0; j < 3; ++j)
            emit(w + k, w + j, cj * system_.inertia[i](k, j));
    }
    const Eigen::Matrix4d m = -0.5 * spin_matrix(spin);
    const Mat34 l = l_matrix(euler);
    for (int k = 0; k < 4; ++k) {
        for (int j = 0; j < 4; ++j)
            emit(p + k, p + j, m(k, j) + (k == j ? cj + 2 * nu_[i] : 0.0));
        for (int j = 0; j < 3; ++j)
            emit(p + k, w + j, -0.5 * l(j, k));
        emit(p + k, nu, 2 * euler[k]);
        emit(nu, p + k, 2 * euler[k]);
    }
}

// C and S; columns along body-frame rotations become columns of p by dtheta = 2 L(p) dp / |p|^2.
template <class Emit> void IdaEquations::visit_blocks(Emit&& emit) const {
    const BlockLayout& layout = system_.layout;
    for (int id = 0; id < layout.blocks(); ++id) {
        if (!layout.active[id])
            continue;
        const int row = u0_ + 3 * layout.block_row[id], body = layout.block_col[id] / 2;
        const bool rotational = layout.block_col[id] % 2;
        const int q = 7 * body + (rotational ? 3 : 0), u = u0_ + 3 * layout.block_col[id];
        const Eigen::Map<const Mat3> c(ws_.lin.C.data() + 9 * std::size_t(id));
        const Eigen::Map<const Mat3> s(ws_.lin.S.data() + 9 * std::size_t(id));
        for (int j = 0; j < 3; ++j)
            for (int k = 0; k < 3; ++k)
                emit(row + k, u + j, c(k, j));
        if (rotational) {
            const Mat34 sp = s * turn_[body];
            for (int j = 0; j < 4; ++j)
                for (int k = 0; k < 3; ++k)
                    emit(row + k, q + j, sp(k, j));
        } else {
            for (int j = 0; j < 3; ++j)
                for (int k = 0; k < 3; ++k)
                    emit(row + k, q + j, s(k, j));
        }
    }
}

// Bristles and the forces they put on their two bodies.
template <class Emit> void IdaEquations::visit_states(double cj, Emit&& emit) const {
    for (const Linearisation::StateCoupling& x : ws_.lin.states) {
        const int z = z0_ + x.state;
        emit(z, z, cj + x.decay);
        for (const int side : {0, 1}) {
            const int body = side ? x.b : x.a;
            for (int k = 0; body < system_.moving && k < 6; ++k) {
                const int u = u0_ + 6 * body + k, part = 2 * side + k / 3;
                emit(u, z, -x.force.part(part)[k % 3]);
                emit(z, u, -x.rate.part(part)[k % 3]);
            }
        }
    }
}

template <class Emit> void IdaEquations::visit_reactions(Emit&& emit) const {
    for (const Linearisation::ReactionCoupling& x : ws_.lin.reactions)
        for (const int side : {0, 1}) {
            const int body = side ? system_.rows[x.row].b : system_.rows[x.row].a;
            for (int k = 0; body < system_.moving && k < 6; ++k)
                emit(u0_ + 6 * body + k, lambda0_ + x.row, x.force.part(2 * side + k / 3)[k % 3]);
        }
}

// A constraint row and one of its bodies: G, G^T, d(G u)/dq, T M^-1 G^T.
template <class Emit> void IdaEquations::visit_side(int row, int side, Emit&& emit) const {
    const RowRecord& record = system_.rows[row];
    const int body = side ? record.b : record.a;
    if (body >= system_.moving)
        return;
    const unsigned mask = record.mask >> (6 * side);
    const Row12 g(ws_.rows.data() + 12 * std::size_t(row)), d(rate_rows_.data() + 12 * std::size_t(row));
    const int first = 6 * side, r = 7 * body, p = r + 3, v = u0_ + 6 * body, w = v + 3;
    const int lambda = lambda0_ + row, mu = mu0_ + row;
    for (int k = 0; k < 3; ++k) {
        if (!(mask >> k & 1u))
            continue;
        emit(lambda, v + k, g[first + k]);
        emit(lambda, r + k, d[first + k]);
        emit(mu, r + k, g[first + k]);
        emit(v + k, lambda, g[first + k]);
        emit(r + k, mu, g[first + k] / system_.mass[body]);
    }
    if (!(mask >> 3 & 7u))
        return;
    const Eigen::RowVector3d gw = g.segment<3>(first + 3), dw = d.segment<3>(first + 3);
    for (int k = 0; k < 3; ++k) {
        emit(lambda, w + k, gw[k]);
        emit(w + k, lambda, gw[k]);
    }
    const Eigen::RowVector4d gp = gw * turn_[body], dp = dw * turn_[body];
    const Vec4 push = 0.5 * lt_times(q_.segment<4>(p), system_.inverse_inertia[body] * gw.transpose());
    for (int k = 0; k < 4; ++k) {
        emit(lambda, p + k, dp[k]);
        emit(mu, p + k, gp[k]);
        emit(p + k, mu, push[k]);
    }
}

void IdaEquations::build_pattern() {
    std::vector<std::uint64_t> place; // column in the upper half, row in the lower
    visit(1.0, [&](int row, int column, double) {
        place.push_back((std::uint64_t(column) << 32) | std::uint32_t(row));
    });
    std::vector<std::size_t> order(place.size());
    std::iota(order.begin(), order.end(), std::size_t(0));
    std::sort(order.begin(), order.end(), [&](auto a, auto b) { return place[a] < place[b]; });

    slot_.resize(place.size());
    pattern_.rows = pattern_.cols = size();
    pattern_.col_start.assign(std::size_t(size()) + 1, 0);
    for (std::size_t i = 0; i < order.size(); ++i) {
        const std::uint64_t entry = place[order[i]];
        if (i == 0 || entry != place[order[i - 1]]) {
            pattern_.row.push_back(static_cast<int>(entry & 0xffffffffu));
            ++pattern_.col_start[(entry >> 32) + 1];
        }
        slot_[order[i]] = pattern_.nonzeros() - 1;
    }
    std::partial_sum(pattern_.col_start.begin(), pattern_.col_start.end(), pattern_.col_start.begin());
}

std::string IdaEquations::name_of(int unknown) const {
    if (unknown < 0)
        return "unknown";
    if (unknown < u0_)
        return "body " + system_.body_names[unknown / 7];
    if (unknown < z0_)
        return "body " + system_.body_names[(unknown - u0_) / 6];
    if (unknown < lambda0_)
        return "friction state " + std::to_string(unknown - z0_);
    if (unknown < nu0_)
        return row_name(system_, (unknown - lambda0_) % system_.row_count());
    return "body " + system_.body_names[unknown - nu0_];
}

} // namespace gudgeon

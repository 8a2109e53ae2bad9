#include "solvers/modes.hpp"

#include "solvers/linearised.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Spectra/GenEigsSolver.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {

using Complex = std::complex<double>;
using CVecX = Eigen::VectorXcd;

constexpr double zero_share = 1e-11; // of the stiffnesses that cancel: no stiffness
constexpr double zero_scale = 1e-6;  // of the stiffness scale
constexpr double grows = 1e-7;       // of a root: real part of an unstable one
constexpr double arnoldi_tolerance = 1e-11;
constexpr int most_rounds = 12;

struct Root {
    Complex s;
    CVecX x;
};

// --- dense ---

MatX null_space(const MatX& g, Eigen::Index n) {
    if (g.rows() == 0)
        return MatX::Identity(n, n);
    Eigen::ColPivHouseholderQR<MatX> qr(g.transpose());
    qr.setThreshold(1e-10);
    const MatX q = qr.householderQ();
    return q.rightCols(n - qr.rank());
}

std::vector<Root> dense_roots(Linearised& lin, double sigma) {
    MatX z = null_space(lin.rows(), lin.mass().rows());
    const Eigen::Index d = z.cols();
    std::vector<Root> out;
    if (d == 0)
        return out;
    const Eigen::LLT<MatX> llt(z.transpose() * lin.mass() * z);
    z = llt.matrixU().solve<Eigen::OnTheRight>(z); // z^T M z = 1
    const MatX c = z.transpose() * lin.damping() * z, k = z.transpose() * lin.stiffness() * z;
    const double size = k.cwiseAbs().maxCoeff();
    const bool symmetric = (k - k.transpose()).cwiseAbs().maxCoeff() <= 1e-12 * size;
    if (symmetric && c.cwiseAbs().maxCoeff() <= 1e-14 * std::sqrt(size)) {
        const Eigen::SelfAdjointEigenSolver<MatX> eigen(0.5 * (k + k.transpose()));
        for (Eigen::Index i = 0; i < d; ++i) {
            const Complex s = std::sqrt(Complex(-eigen.eigenvalues()[i], 0));
            for (const Complex root : {s, -s})
                out.push_back({root, z * eigen.eigenvectors().col(i)});
        }
        return out;
    }
    // (A - sigma B)^-1 B as in Linearised, velocities over sigma: small roots come out exactly
    const MatX one = MatX::Identity(d, d), at = sigma * sigma * one + sigma * c + k;
    const Eigen::PartialPivLU<MatX> lu(at);
    MatX t(2 * d, 2 * d);
    t.topLeftCorner(d, d) = -lu.solve(c + sigma * one);
    t.topRightCorner(d, d) = -sigma * lu.solve(one);
    t.bottomRows(d) = t.topRows(d);
    t.bottomLeftCorner(d, d) += one / sigma;
    const Eigen::EigenSolver<MatX> eigen(t);
    for (Eigen::Index i = 0; i < 2 * d; ++i)
        out.push_back({sigma + 1.0 / eigen.eigenvalues()[i], z * eigen.eigenvectors().col(i).head(d)});
    return out;
}

// --- Arnoldi ---

/// The operator without what has been found already: (1 - Q Q^T) op.
class Deflated {
  public:
    using Scalar = double;
    explicit Deflated(Linearised& lin) : q(2 * lin.system().velocities(), 0), lin_(lin), scratch_(q.rows()) {}
    Eigen::Index rows() const { return q.rows(); }
    Eigen::Index cols() const { return q.rows(); }
    void perform_op(const double* y, double* w) const {
        lin_.shift_invert(y, w);
        Eigen::Map<VecX> out(w, rows());
        for (int pass = 0; pass < 2 && q.cols() > 0; ++pass)
            out -= q * (q.transpose() * out);
    }

    /// Adds the part of a vector outside Q.
    void add(VecX v) {
        const double before = v.norm();
        for (int pass = 0; pass < 2 && q.cols() > 0; ++pass)
            v -= q * (q.transpose() * v);
        const double length = v.norm();
        if (!(length > 1e-7 * before))
            return;
        q.conservativeResize(Eigen::NoChange, q.cols() + 1);
        q.rightCols(1) = v / length;
    }

    MatX q; // orthonormal columns

  private:
    Linearised& lin_;
    VecX scratch_;
};

VecX consistent_start(const Deflated& op, int round) {
    VecX v(op.rows()), w(op.rows());
    unsigned seed = 7919u * static_cast<unsigned>(round + 1); // the same start every time
    for (double& x : v) {
        seed = seed * 1664525u + 1013904223u;
        x = static_cast<double>(seed >> 8) / 16777216.0 - 0.5;
    }
    for (int k = 0; k < 2; ++k) { // onto the constraints, positions and velocities
        op.perform_op(v.data(), w.data());
        v = w / w.norm();
    }
    return v;
}

std::vector<Root> arnoldi_roots(Linearised& lin, int wanted) {
    Deflated op(lin);
    const Eigen::Index size = op.rows();
    std::vector<double> found; // |theta|
    for (int round = 0; round < most_rounds; ++round) {
        const Eigen::Index nev = round == 0 ? wanted : std::min(wanted, 8);
        const Eigen::Index ncv = std::min(size, std::max<Eigen::Index>(3 * nev, nev + 30));
        Spectra::GenEigsSolver<Deflated> solver(op, nev, ncv);
        const VecX start = consistent_start(op, round);
        solver.init(start.data());
        solver.compute(Spectra::SortRule::LargestMagn, 300, arnoldi_tolerance);
        const CVecX theta = solver.eigenvalues();
        const Eigen::MatrixXcd vectors = solver.eigenvectors();
        if (theta.size() == 0 && round == 0)
            throw std::runtime_error("Arnoldi's method found no root; ask for fewer modes");
        std::ranges::sort(found, std::ranges::greater{});
        const double least = std::ssize(found) >= wanted ? found[wanted - 1] : 0.0;
        bool fresh = false;
        for (Eigen::Index i = 0; i < theta.size(); ++i) {
            fresh = fresh || std::abs(theta[i]) > (1 + 1e-9) * least;
            found.push_back(std::abs(theta[i]));
            op.add(vectors.col(i).real());
            op.add(vectors.col(i).imag());
        }
        if (!fresh)
            break;
    }
    // Ritz pairs of the whole space found
    const MatX q = std::move(op.q);
    op.q.resize(size, 0);
    MatX image(size, q.cols());
    for (Eigen::Index k = 0; k < q.cols(); ++k)
        op.perform_op(q.col(k).data(), image.col(k).data());
    const Eigen::EigenSolver<MatX> eigen(q.transpose() * image);
    std::vector<Root> out;
    for (Eigen::Index i = 0; i < q.cols(); ++i) {
        const CVecX y = q * eigen.eigenvectors().col(i);
        out.push_back({lin.sigma() + 1.0 / eigen.eigenvalues()[i], y.head(size / 2)});
    }
    return out;
}

// --- sorting ---

bool is_neutral(const Linearised& lin, const Root& root) {
    VecX m(root.x.size());
    double mass = 0, cancelling = 0;
    for (const VecX& part : {VecX(root.x.real()), VecX(root.x.imag())}) {
        lin.mass_of(part, m);
        mass += part.dot(m);
        cancelling += lin.cancelling(part);
    }
    return std::norm(root.s) <= zero_scale * lin.stiffness_scale() + zero_share * cancelling / mass;
}

void normalise(CVecX& x) {
    Eigen::Index largest;
    x.cwiseAbs().maxCoeff(&largest);
    x /= x[largest];
}

/// Independent shapes of the neutral roots: zero is a double root, with one shape.
std::vector<CVecX> neutral_shapes(const Linearised& lin, const std::vector<const Root*>& roots) {
    std::vector<VecX> basis;
    VecX m(2);
    const auto length = [&](const VecX& v) {
        m.resize(v.size());
        lin.mass_of(v, m);
        return std::sqrt(v.dot(m));
    };
    for (const Root* root : roots)
        for (VecX v : {VecX(root->x.real()), VecX(root->x.imag())}) {
            const double before = length(root->x.real()) + length(root->x.imag());
            for (int pass = 0; pass < 2; ++pass)
                for (const VecX& b : basis) {
                    length(b); // m = M b
                    v -= b * m.dot(v);
                }
            if (const double rest = length(v); rest > 1e-3 * before)
                basis.push_back(v / rest);
        }
    return {basis.begin(), basis.end()};
}

} // namespace

const char* mode_kind_name(Mode::Kind kind) {
    switch (kind) {
    case Mode::Kind::neutral:
        return "neutral";
    case Mode::Kind::vibration:
        return "vibration";
    case Mode::Kind::overdamped:
        return "overdamped";
    case Mode::Kind::unstable:
        break;
    }
    return "unstable";
}

ModesReport find_modes(const System& system, const State& state, const ModesOptions& options) {
    ModesReport report;
    if (system.moving == 0)
        return report;
    Linearised lin(system, state);
    const double sigma = std::sqrt(lin.stiffness_scale());
    const int n = system.velocities();
    const int wanted = 2 * (options.count > 0 ? options.count : n) + 12;
    const bool dense = n <= options.dense_up_to || 4 * wanted > 2 * n;
    report.solver = dense ? "dense" : "arnoldi";
    std::vector<Root> roots;
    if (dense) {
        roots = dense_roots(lin, sigma);
    } else {
        lin.factor(sigma);
        roots = arnoldi_roots(lin, wanted);
    }
    report.shift = dense ? sigma : lin.sigma();

    std::vector<const Root*> zero;
    for (Root& root : roots) {
        root.s = lin.refined(root.x, root.s);
        if (!std::isfinite(std::abs(root.s)) || !root.x.allFinite())
            continue;
        if (is_neutral(lin, root)) {
            zero.push_back(&root);
            continue;
        }
        const double size = std::abs(root.s);
        const bool real = std::abs(root.s.imag()) <= 1e-9 * size;
        if (!real && root.s.imag() < 0)
            continue; // of a pair
        Mode mode;
        mode.root = real ? Complex(root.s.real(), 0) : root.s;
        mode.kind = root.s.real() > grows * size ? Mode::Kind::unstable
                    : real                       ? Mode::Kind::overdamped
                                                 : Mode::Kind::vibration;
        mode.shape = root.x;
        normalise(mode.shape);
        report.modes.push_back(std::move(mode));
    }
    std::ranges::stable_sort(report.modes, {}, &Mode::omega);
    if (options.count > 0 && std::ssize(report.modes) > options.count)
        report.modes.resize(static_cast<std::size_t>(options.count));
    std::vector<Mode> first;
    for (CVecX& shape : neutral_shapes(lin, zero)) {
        normalise(shape);
        first.push_back({Mode::Kind::neutral, {0, 0}, std::move(shape)});
    }
    report.neutral = static_cast<int>(first.size());
    report.unstable = static_cast<int>(std::ranges::count(report.modes, Mode::Kind::unstable, &Mode::kind));
    report.modes.insert(report.modes.begin(), first.begin(), first.end());
    return report;
}

Model without_friction(Model model) {
    for (Joint& joint : model.joints) {
        joint.friction.clear();
        if (joint.clearance)
            joint.clearance->friction.reset();
        for (auto& [coordinate, stop] : joint.stops)
            stop.friction.reset();
    }
    std::erase_if(model.forces, [](const Force& f) { return std::holds_alternative<FrictionForce>(f); });
    return model;
}

} // namespace gudgeon

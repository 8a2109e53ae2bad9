#include "solvers/augmented_solver_impl.hpp"
#include "solvers/complex_klu_solver.hpp"

#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {
using Complex = std::complex<double>;
using ComplexVector = Eigen::VectorXcd;
} // namespace

struct AugmentedPairSolver::Impl {
    const AugmentedSolver::Impl& real;
    AugmentedOptions options;
    ScaledSaddle<Complex> k;
    std::vector<Complex> original;
    Complex ratio = 1;
    Gmres<Complex> gmres;
    ComplexVector x, v, gz;
    ComplexKluSolver klu;
    bool klu_analysed = false, klu_in_use = false, factored = false;
    Patience patience;
    LinearSolverCounts own;
    mutable LinearSolverCounts counts;

    explicit Impl(const AugmentedSolver::Impl& r) : real(r), options(r.options) {}

    FactorStatus factor_by_klu() {
        if (!klu_analysed)
            klu.analyse(real.pattern);
        klu_analysed = true;
        const FactorStatus status = klu.factor(original);
        klu_in_use = status.ok();
        own.klu_fallbacks += klu_in_use;
        return status;
    }

    void pass(const ComplexVector& residual, ComplexVector& z, ComplexVector& w) {
        const int n = real.parts.n, m = real.parts.m;
        v.head(n) = residual.head(n);
        v.tail(m) = ratio * residual.tail(m);
        real.pass(v, z, gz);
        z.head(n) /= ratio;
        gz /= ratio;
        k.times(real.parts, z, gz, w);
    }

    bool solve(Complex* rhs) {
        const SaddleParts& parts = real.parts;
        for (int i = 0; i < parts.n; ++i)
            x[parts.place[i]] = real.scaling.unknown[parts.place[i]] * rhs[i];
        for (int r = 0; r < parts.m; ++r)
            x[parts.n + r] = real.scaling.multiplier[r] * rhs[parts.n + r];
        const auto result =
            gmres.solve(x, options.tolerance, [&](const auto& b, auto& z, auto& w) { pass(b, z, w); });
        ++own.cholmod_solves;
        own.cholmod_iterations += result.iterations;
        if (!result.converged && factor_by_klu().ok())
            return false;
        for (int i = 0; i < parts.n; ++i)
            rhs[i] = real.scaling.unknown[parts.place[i]] * x[parts.place[i]];
        for (int r = 0; r < parts.m; ++r)
            rhs[parts.n + r] = real.scaling.multiplier[r] * x[parts.n + r];
        return true;
    }
};

AugmentedPairSolver::AugmentedPairSolver(const AugmentedSolver& real)
    : impl_(std::make_unique<Impl>(*real.impl_)) {}
AugmentedPairSolver::~AugmentedPairSolver() = default;

void AugmentedPairSolver::analyse(const CscPattern& pattern) {
    Impl& s = *impl_;
    if (pattern.row != s.real.pattern.row || pattern.col_start != s.real.pattern.col_start)
        throw std::invalid_argument("the real matrix has another pattern");
    s.klu_analysed = s.klu_in_use = s.factored = false;
    s.k.resize(s.real.parts);
    s.original.assign(pattern.nonzeros(), 0.0);
    s.gmres.resize(pattern.cols, s.options.most_passes);
    s.x.setZero(pattern.cols);
    s.v.setZero(pattern.cols);
    s.gz.setZero(s.real.parts.m);
    ++s.own.analyses;
}

FactorStatus AugmentedPairSolver::factor(std::span<const Complex> values, Complex ratio) {
    Impl& s = *impl_;
    if (std::ssize(values) != std::ssize(s.original) || s.own.analyses == 0)
        throw std::invalid_argument("one value per pattern entry is needed");
    if (s.factored && !s.klu_in_use)
        s.patience.served();
    s.factored = s.klu_in_use = false;
    for (const Complex& value : values)
        if (!std::isfinite(value.real()) || !std::isfinite(value.imag()))
            return {FactorStatus::Kind::non_finite, 0};
    std::copy(values.begin(), values.end(), s.original.begin());
    s.ratio = ratio;
    if (s.real.factored && !s.real.klu_in_use && s.patience.wants_to_try()) {
        s.k.load(s.real.parts, s.real.scaling, values);
        s.factored = true;
        return {};
    }
    const FactorStatus status = s.factor_by_klu();
    s.factored = status.ok();
    return status;
}

void AugmentedPairSolver::solve(std::span<Complex> rhs, int columns) {
    Impl& s = *impl_;
    if (!s.factored)
        throw std::logic_error("solve without factors");
    const auto size = static_cast<std::size_t>(s.real.pattern.cols);
    if (columns < 0 || rhs.size() != size * static_cast<std::size_t>(columns))
        throw std::invalid_argument("right-hand side of another size");
    s.own.solves += columns;
    for (int c = 0; c < columns && size > 0; ++c) {
        Complex* const column = rhs.data() + size * static_cast<std::size_t>(c);
        const bool before = s.klu_in_use;
        if (before || !s.solve(column)) {
            if (!before)
                s.patience.failed();
            s.klu.solve({column, size}, 1);
        }
    }
}

const LinearSolverCounts& AugmentedPairSolver::counts() const {
    const Impl& s = *impl_;
    s.counts = s.own;
    s.counts.factorisations = s.klu.counts().factorisations;
    s.counts.refactorisations = s.klu.counts().refactorisations;
    return s.counts;
}

long AugmentedPairSolver::factor_nonzeros() const {
    return impl_->klu_in_use ? impl_->klu.factor_nonzeros() : 0;
}

} // namespace gudgeon

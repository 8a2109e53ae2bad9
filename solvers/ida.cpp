#include "solvers/ida.hpp"

#include "core/bad_numbers.hpp"
#include "solvers/contact_watch.hpp"
#include "solvers/ida_diagnosis.hpp"
#include "solvers/ida_equations.hpp"
#include "solvers/ida_linear_solver.hpp"
#include "solvers/index1_equations.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/power_integral.hpp"

#include <fmt/format.h>
#include <ida/ida.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_linearsolver.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace gudgeon {

namespace {

// Of the tolerance, left to Newton's iteration: less than IDA's own 0.33, because errors of the iteration
// roughen the estimates that choose order and step. Measured on pendulum, slider-crank and chain, it saves
// a third of the steps for the same number of iterations.
constexpr double newton_share = 0.01;

// So many steps in a row below this share of t: a point is not passed.
constexpr int most_tiny_steps = 20;
constexpr double smallest_share = 2e-15;
constexpr int most_cuts = 20; // of a step in which a contact begins too deep

struct Handles {
    SUNContext context = nullptr;
    void* ida = nullptr;
    N_Vector y = nullptr, ydot = nullptr, id = nullptr, scratch = nullptr;
    SUNMatrix matrix = nullptr;
    SUNLinearSolver solver = nullptr;

    Handles() = default;
    Handles(const Handles&) = delete;
    Handles& operator=(const Handles&) = delete;
    ~Handles() {
        if (ida)
            IDAFree(&ida);
        if (solver)
            SUNLinSolFree(solver);
        if (matrix)
            SUNMatDestroy(matrix);
        for (N_Vector v : {y, ydot, id, scratch})
            if (v)
                N_VDestroy(v);
        if (context)
            SUNContext_Free(&context);
    }
};

double* data(N_Vector v) { return N_VGetArrayPointer(v); }

class Ida final : public Integrator {
  public:
    Ida(const System& system, const IntegratorOptions& options);

    const char* name() const override { return "ida"; }
    const char* linear_solver() const override { return "klu"; }
    const State& state() const override { return state_; }
    const Statistics& statistics() const override { return statistics_; }
    Workspace& workspace() override { return equations_.workspace(); }
    void set_on_contact(std::function<void(const ContactEvent&)> f) override {
        watch_.on_contact = std::move(f);
    }
    void start(const State& state) override;
    void visit(Archive& archive) override;
    StepOutcome advance(double t_stop) override;
    void kink() override { restart_ = true; }
    void interpolate(double t, State& out) const override;

  private:
    struct Counters {
        long steps = 0, error_fails = 0, newton_fails = 0, iterations = 0;
    };
    struct Attempt {
        bool open = false;
        double t = 0, h = 0;
        long error_fails = 0;
    };

    void create();
    void require(int flag, const char* what) const;
    // callbacks of IDA; no exception leaves them
    static int residual(double t, N_Vector y, N_Vector ydot, N_Vector out, void* self);
    static int jacobian(double t, double cj, N_Vector y, N_Vector ydot, N_Vector r, SUNMatrix j, void* self,
                        N_Vector, N_Vector, N_Vector);
    static int weights(N_Vector y, N_Vector w, void* self);
    static void keep_message(int, const char*, const char*, char* message, void* self);
    template <class F> int guarded(F&& f);

    void follow_attempts(double t);
    void close_attempt(StepReason reason, double error);
    void collect_counters();
    void accept(double t, double t_before);
    bool crawls();
    void motion_in_step(double t, int body, BodyMotion& out) const;
    bool cut_at_contact(double t_before, double& t);
    void integrate_powers(double h);
    void powers_at(double t, VecX& out);
    StepOutcome failure(int flag);
    double error_norm();

    const System& system_;
    const IntegratorOptions options_;
    IdaEquations equations_;
    Index1Equations accelerations_;
    ContactWatch watch_;
    const ContactWatch::MotionAt motion_at_;
    bool restart_ = false;   // where a contact begins, or at a kink
    IdaLinearRecord linear_; // before the handles: their solver writes into it
    Handles sun_;
    State state_;
    VecX acceleration_;
    PowerIntegral energies_;
    std::array<VecX, PowerIntegral::points> powers_; // of the last step
    double t_begin_ = 0;                             // of the last step
    bool initialised_ = false;
    StepOutcome started_;
    Counters last_;
    Attempt attempt_;
    int tiny_steps_ = 0;
    std::string message_, exception_;
    std::string bad_number_; // met since the last accepted step; empty: none
    mutable Statistics statistics_;
};

Ida::Ida(const System& system, const IntegratorOptions& options)
    : system_(system), options_(options), equations_(system, rows_of(options), options.threads),
      accelerations_(system, rows_of(options)), watch_(system, options),
      motion_at_([this](double t, int body, BodyMotion& out) { motion_in_step(t, body, out); }),
      state_(initial_state(system)), acceleration_(VecX::Zero(system.velocities())) {
    if (!(options.rtol >= 0) || !(options.atol > 0) || !(options.step >= 0))
        throw std::invalid_argument(
            fmt::format("ida: rtol {}, atol {}, step {} are not allowed; rtol and step "
                        "at least 0, atol positive",
                        options.rtol, options.atol, options.step));
    if (system.moving > 0)
        create();
}

void Ida::require(int flag, const char* what) const {
    if (flag < 0)
        throw std::invalid_argument(fmt::format("ida: {} refused: {}", what, message_));
}

void Ida::create() {
    const int n = equations_.size();
    require(SUNContext_Create(nullptr, &sun_.context), "context");
    for (N_Vector* v : {&sun_.y, &sun_.ydot, &sun_.id, &sun_.scratch})
        if (!(*v = N_VNew_Serial(n, sun_.context)))
            throw std::bad_alloc();
    std::fill_n(data(sun_.id), n, 0.0);
    std::fill_n(data(sun_.id), equations_.lambda0(), 1.0); // q and u are differential

    const int nonzeros = equations_.pattern().nonzeros();
    statistics_.nnz_matrix = nonzeros;
    sun_.matrix = SUNSparseMatrix(n, n, nonzeros, CSC_MAT, sun_.context);
    if (sun_.matrix)
        sun_.solver = make_ida_linear_solver(sun_.y, sun_.matrix, sun_.context, linear_);
    sun_.ida = IDACreate(sun_.context);
    if (!sun_.solver || !sun_.ida)
        throw std::bad_alloc();
    require(IDASetErrHandlerFn(sun_.ida, &Ida::keep_message, this), "error handler");
}

void Ida::start(const State& state) {
    state_ = state;
    Workspace& ws = equations_.workspace();
    ws.angles = state.angles;
    energies_.restart(state.work);
    powers_.fill(VecX::Zero(work_count(system_)));
    t_begin_ = state.t;
    attempt_.open = false;
    tiny_steps_ = 0;
    last_ = {};
    started_ = {};
    exception_.clear();
    bad_number_.clear();
    message_.clear();
    if (system_.moving == 0)
        return;
    restart_ = false;
    ws.z = state.z;
    ws.lambda = state.lambda;
    set_motion(system_, state.q, state.u, ws);
    watch_.begin(state_, ws);
    const FactorStatus status = accelerations_.solve(state.t, ws, nullptr, acceleration_, state_.lambda);
    if (!status.ok()) {
        const bool singular = status.kind == FactorStatus::Kind::singular;
        started_ = {false, singular ? StepReason::singular : StepReason::non_finite,
                    fmt::format("t = {} s: no accelerations at the start: {}; first at {}", state.t,
                                singular ? "constraints repeat each other" : "entries that are no numbers",
                                accelerations_.name_of(status.column))};
        return;
    }
    update_angles(system_, state.t, ws, ws.angles);
    state_.angles = ws.angles;
    powers(system_, state.t, state_.lambda.data(), ws, powers_.back());
    equations_.pack(state_, data(sun_.y));
    equations_.pack_rates(state.t, data(sun_.y), acceleration_, data(sun_.ydot));
    if (initialised_) {
        require(IDAReInit(sun_.ida, state.t, sun_.y, sun_.ydot), "state");
        return;
    }
    void* ida = sun_.ida;
    require(IDAInit(ida, &Ida::residual, state.t, sun_.y, sun_.ydot), "state");
    require(IDASetUserData(ida, this), "user data");
    require(IDAWFtolerances(ida, &Ida::weights), "tolerances");
    require(IDASetId(ida, sun_.id), "kinds of unknowns");
    require(IDASetSuppressAlg(ida, SUNTRUE), "error test");
    require(IDASetMaxOrd(ida, options_.max_order), "largest order");
    require(IDASetMaxStep(ida, options_.step), "largest step");
    require(IDASetNonlinConvCoef(ida, newton_share), "convergence test");
    require(IDASetLinearSolver(ida, sun_.solver, sun_.matrix), "linear solver");
    require(IDASetJacFn(ida, &Ida::jacobian), "Jacobian");
    initialised_ = true;
}

// IDA keeps its history to itself: it starts anew from the state, with the work so far counted on.
void Ida::visit(Archive& archive) {
    Statistics statistics = statistics_;
    IdaLinearRecord linear = linear_;
    Integrator::visit(archive);
    archive(statistics, linear.factor_seconds, linear.solve_seconds, linear.factorisations,
            linear.refactorisations, linear.nnz_factors);
    statistics_ = statistics;
    linear_ = linear;
}

template <class F> int Ida::guarded(F&& f) {
    try {
        return f();
    } catch (const std::exception& e) {
        exception_ = e.what();
    } catch (...) {
        exception_ = "unknown exception";
    }
    return -1;
}

int Ida::residual(double t, N_Vector y, N_Vector ydot, N_Vector out, void* self) {
    auto& me = *static_cast<Ida*>(self);
    return me.guarded([&] {
        if (me.on_step)
            me.follow_attempts(t);
        const PhaseTimer timer(me.statistics_.seconds.evaluate);
        ++me.statistics_.evaluations;
        if (me.equations_.residual(t, data(y), data(ydot), data(out)))
            return 0;
        me.bad_number_ = find_bad_number(me.system_, t, me.equations_.workspace());
        return 1;
    });
}

int Ida::jacobian(double t, double cj, N_Vector y, N_Vector, N_Vector, SUNMatrix j, void* self, N_Vector,
                  N_Vector, N_Vector) {
    auto& me = *static_cast<Ida*>(self);
    return me.guarded([&] {
        const PhaseTimer timer(me.statistics_.seconds.assemble);
        const CscPattern& pattern = me.equations_.pattern();
        const std::span<double> values(SUNSparseMatrix_Data(j), pattern.row.size());
        std::copy(pattern.col_start.begin(), pattern.col_start.end(), SUNSparseMatrix_IndexPointers(j));
        std::copy(pattern.row.begin(), pattern.row.end(), SUNSparseMatrix_IndexValues(j));
        me.equations_.jacobian(t, cj, data(y), values);
        const bool finite = Eigen::Map<const VecX>(values.data(), pattern.nonzeros()).allFinite();
        return finite ? 0 : 1;
    });
}

// IDA's norms divide by the number of all unknowns: the weights make up for those that do not count.
int Ida::weights(N_Vector y, N_Vector w, void* self) {
    const auto& me = *static_cast<const Ida*>(self);
    const int n = me.equations_.size(), counted = me.equations_.lambda0();
    const double share = std::sqrt(double(n) / counted);
    const double *x = data(y), r = me.options_.rtol, a = me.options_.atol;
    double* out = data(w);
    for (int i = 0; i < counted; ++i) {
        if (!std::isfinite(x[i]))
            return -1;
        out[i] = share / (r * std::abs(x[i]) + a);
    }
    for (int i = me.equations_.z0(); i < counted; ++i)
        out[i] = share / (r * std::abs(x[i]) + a * me.system_.state_scales[i - me.equations_.z0()]);
    std::fill(out + counted, out + n, 1e-100);
    return 0;
}

void Ida::keep_message(int, const char*, const char*, char* message, void* self) {
    auto& me = *static_cast<Ida*>(self);
    me.guarded([&] {
        me.message_ = message;
        return 0;
    });
}

// A residual at a new time is a new attempt: the one before it was rejected.
void Ida::follow_attempts(double t) {
    if (attempt_.open && attempt_.t == t)
        return;
    long error_fails = 0;
    IDAGetNumErrTestFails(sun_.ida, &error_fails);
    const bool by_error = error_fails > attempt_.error_fails;
    close_attempt(by_error ? StepReason::error_test : StepReason::newton, by_error ? error_norm() : 0);
    attempt_ = {true, t, t - state_.t, error_fails};
}

void Ida::close_attempt(StepReason reason, double error) {
    int order = 0;
    IDAGetLastOrder(sun_.ida, &order);
    if (attempt_.open && on_step)
        on_step({attempt_.t, attempt_.h, order, reason, error});
    attempt_.open = false;
}

double Ida::error_norm() { return ida_error_norm(sun_.ida, sun_.scratch, equations_.lambda0()); }

StepOutcome Ida::advance(double t_stop) {
    if (!started_.ok || t_stop <= state_.t)
        return started_;
    if (system_.moving == 0 || t_stop - state_.t < 1e-15 * (std::abs(t_stop) + std::abs(state_.t))) {
        state_.t = t_stop; // nothing moves, or not within rounding
        return {};
    }
    if (statistics_.steps >= options_.max_steps)
        return {false, StepReason::none,
                fmt::format("t = {} s: {} steps were allowed", state_.t, options_.max_steps)};
    if (restart_) {
        start(State(state_));
        if (!started_.ok)
            return started_;
    }
    const PhaseTimes before = statistics_.seconds;
    const double inner = linear_.factor_seconds + linear_.solve_seconds;
    const double t_before = state_.t;
    double t = t_before, total = 0;
    int flag = IDASetStopTime(sun_.ida, t_stop);
    {
        const PhaseTimer timer(total);
        // IDA may first hand out what is left of a step it cut at the last stop, by rounding
        for (int i = 0; i < 2 && flag >= 0 && (i == 0 || t <= t_before); ++i)
            flag = IDASolve(sun_.ida, t_stop, &t, sun_.y, sun_.ydot, IDA_ONE_STEP);
    }
    PhaseTimes& s = statistics_.seconds;
    s.factor = linear_.factor_seconds;
    s.solve = linear_.solve_seconds;
    s.control += total - (s.evaluate - before.evaluate) - (s.assemble - before.assemble) -
                 (linear_.factor_seconds + linear_.solve_seconds - inner);
    collect_counters();
    if (flag < 0)
        return started_ = failure(flag);
    restart_ = cut_at_contact(t_before, t);
    accept(t, t_before);
    return crawls() ? started_ = failure(IDA_TOO_MUCH_ACC) : StepOutcome{};
}

// IDA goes on with steps that do not change t any more, towards a point it cannot pass.
bool Ida::crawls() {
    double h = 0;
    IDAGetLastStep(sun_.ida, &h);
    tiny_steps_ = std::abs(h) < smallest_share * std::abs(state_.t) ? tiny_steps_ + 1 : 0;
    if (tiny_steps_ == 0)
        bad_number_.clear(); // it was got over
    return tiny_steps_ >= most_tiny_steps;
}

void Ida::collect_counters() {
    Counters now;
    IDAGetNumSteps(sun_.ida, &now.steps);
    IDAGetNumErrTestFails(sun_.ida, &now.error_fails);
    IDAGetNumStepSolveFails(sun_.ida, &now.newton_fails);
    IDAGetNumNonlinSolvIters(sun_.ida, &now.iterations);
    statistics_.rejected_error += now.error_fails - last_.error_fails;
    statistics_.rejected_newton += now.newton_fails - last_.newton_fails;
    statistics_.newton_sweeps += now.iterations - last_.iterations;
    if (now.steps > last_.steps) {
        int order = 0;
        double h = 0;
        IDAGetLastOrder(sun_.ida, &order);
        IDAGetLastStep(sun_.ida, &h);
        statistics_.steps += now.steps - last_.steps;
        ++statistics_.order_histogram[order];
        statistics_.smallest_step = std::min(statistics_.smallest_step, h);
        statistics_.largest_step = std::max(statistics_.largest_step, h);
    }
    last_ = now;
    statistics_.factorisations = linear_.factorisations;
    statistics_.refactorisations = linear_.refactorisations;
    statistics_.nnz_factors = linear_.nnz_factors;
}

void Ida::accept(double t, double t_before) {
    if (attempt_.open)
        close_attempt(StepReason::none, on_step ? error_norm() : 0);
    attempt_.error_fails = last_.error_fails;
    const PhaseTimer timer(statistics_.seconds.control);
    t_begin_ = t_before;
    state_.t = t;
    equations_.unpack(data(sun_.y), state_);
    integrate_powers(t - t_before);
    Workspace& ws = equations_.workspace();
    evaluate_constraints(system_, t, nullptr, false, ws); // the motion is that of the end
    if (system_.row_count() > 0) {
        statistics_.constraint_position_max =
            std::max(statistics_.constraint_position_max, ws.phi.cwiseAbs().maxCoeff());
        statistics_.constraint_velocity_max =
            std::max(statistics_.constraint_velocity_max, ws.rate.cwiseAbs().maxCoeff());
    }
    update_angles(system_, t, ws, ws.angles);
    state_.angles = ws.angles;
    watch_.commit(t_before, t, state_, ws);
}

// IDA cannot take a step back: where a contact began too deep, the step ends shallow in that contact, at a
// state of its interpolant, and IDA starts anew from there.
bool Ida::cut_at_contact(double t_before, double& t) {
    if (watch_.idle())
        return false;
    bool cut = false;
    for (int i = 0;; ++i) {
        equations_.set(data(sun_.y));
        const ContactWatch::Verdict verdict = watch_.judge(t_before, t, equations_.workspace(), motion_at_);
        if (verdict.ok)
            break;
        if (i == most_cuts) { // the start cannot be resolved in time
            ++statistics_.deep_starts;
            break;
        }
        ++statistics_.rejected_contact;
        cut = true;
        t = verdict.end;
        IDAGetDky(sun_.ida, t, 0, sun_.y);
    }
    return cut;
}

void Ida::motion_in_step(double t, int body, BodyMotion& out) const {
    IDAGetDky(sun_.ida, t, 0, sun_.scratch);
    const double* y = data(sun_.scratch);
    const Eigen::Map<const Eigen::Matrix<double, 7, 1>> q(y + 7 * std::ptrdiff_t(body));
    const Eigen::Map<const Vec6> u(y + equations_.u0() + 6 * std::ptrdiff_t(body));
    set_body_motion(q, u, out);
}

void Ida::integrate_powers(double h) {
    constexpr int last = PowerIntegral::points - 1;
    powers_.front() = powers_.back();
    for (int i = 1; i <= last; ++i) {
        if (i < last)
            IDAGetDky(sun_.ida, t_begin_ + PowerIntegral::node[i] * h, 0, sun_.scratch);
        else
            N_VScale(1.0, sun_.y, sun_.scratch);
        powers_at(i < last ? t_begin_ + PowerIntegral::node[i] * h : state_.t, powers_[i]);
    }
    energies_.step(h, powers_);
    state_.work = energies_.end();
}

void Ida::powers_at(double t, VecX& out) {
    equations_.set(data(sun_.scratch));
    powers(system_, t, equations_.lambda().data(), equations_.workspace(), out);
}

void Ida::interpolate(double t, State& out) const {
    const PhaseTimer timer(statistics_.seconds.output);
    out = state_;
    const double h = state_.t - t_begin_;
    if (!(h > 0) || t >= state_.t)
        return;
    t = std::max(t, t_begin_);
    if (IDAGetDky(sun_.ida, t, 0, sun_.scratch) < 0)
        return;
    equations_.unpack(data(sun_.scratch), out);
    const double share = (t - t_begin_) / h;
    out.t = t;
    out.work = energies_.at(share);
    watch_.memory_inside(out.contacts);
}

StepOutcome Ida::failure(int flag) {
    const IdaTrouble trouble{sun_.ida,   sun_.y,   sun_.scratch, flag, state_.t, linear_.singular_column,
                             exception_, message_, bad_number_};
    const StepOutcome outcome = explain(trouble, system_, equations_);
    close_attempt(outcome.reason, 0);
    return outcome;
}

} // namespace

std::unique_ptr<Integrator> make_ida(const System& system, const IntegratorOptions& options) {
    return std::make_unique<Ida>(system, options);
}

} // namespace gudgeon

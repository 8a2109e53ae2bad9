#include "solvers/step_coordinates.hpp"

#include "core/archive_state.hpp"
#include "core/assembly.hpp"
#include "core/parallel.hpp"
#include "core/tree_kinematics.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

constexpr std::ptrdiff_t grain = 256; // bodies for a thread

/// The turn of Euler parameters p after which a p + beta fits the angular velocity w + a drift.
inline Vec3 fitting_turn(double a, const Vec4& p, const Vec4& beta, const Vec3& w, const Vec3& drift) {
    const double lag = 1 / a;
    const Vec3 defect = w + a * drift - 2 * l_times(p, beta);
    const Vec3 half = 0.5 * w; // (a + skew(half)) turn = defect, in closed form
    return (lag / (a * a + half.squaredNorm())) *
           (a * a * defect - a * half.cross(defect) + half.dot(defect) * half);
}

class CartesianCoordinates final : public StepCoordinates {
  public:
    CartesianCoordinates(const System& system, int threads)
        : system_(system), threads_(threads), drift_(VecX::Zero(system.velocities())), step_(drift_) {
        for (int i = 0; i < system.moving; ++i)
            pieces_.push_back({7 * i, 6 * i, 3, true});
    }

    int coordinates() const override { return system_.positions(); }
    int speeds() const override { return system_.velocities(); }
    void load(const State& state, VecX& x, VecX& w) override {
        x = state.q;
        w = state.u;
    }
    void store(const VecX& x, const VecX& w, State& state) override {
        state.q = x;
        state.u = w;
    }
    void normalise(VecX& x) const override { normalise_orientations(system_, x); }
    void shift(const VecX& step, VecX& x) const override { gudgeon::move(system_, step, x); }
    void set_motion(const VecX& x, const VecX& w, Workspace& ws) override {
        gudgeon::set_motion(system_, x, w, ws);
    }
    void rates(const VecX& x, const VecX& w, const VecX& acceleration, VecX& x_rate, VecX& w_rate) override {
        coordinate_rates(system_, x, w, x_rate);
        w_rate = acceleration;
    }

    void begin_step(const StepFormula& formula, VecX& predicted_x, const VecX& predicted_w, VecX& x,
                    VecX& w) override {
        for_bodies([&](int i) {
            predicted_x.segment<4>(7 * i + 3).normalize();
            x.segment<7>(7 * i) = predicted_x.segment<7>(7 * i);
            w.segment<6>(6 * i) = predicted_w.segment<6>(6 * i);
            drift_.segment<6>(6 * i).setZero();
            fit(formula, i, x, w);
        });
    }
    void momentum_residual(const VecX& w_rate, const VecX& f, VecX& momentum) override {
        for_bodies([&](int i) {
            const Vec6 rate = w_rate.segment<6>(6 * i);
            momentum.segment<3>(6 * i) = f.segment<3>(6 * i) - system_.mass[i] * rate.head<3>();
            momentum.segment<3>(6 * i + 3) = f.segment<3>(6 * i + 3) - system_.inertia[i] * rate.tail<3>();
        });
    }
    Moved move(const StepFormula& formula, const double* velocities, const double* poses, VecX& x,
               VecX& w) override {
        for_bodies([&](int i) {
            w.segment<6>(6 * i) += Eigen::Map<const Vec6>(velocities + 6 * std::ptrdiff_t(i));
            drift_.segment<6>(6 * i) += Eigen::Map<const Vec6>(poses + 6 * std::ptrdiff_t(i));
            fit(formula, i, x, w);
        });
        return {step_.data(), velocities};
    }

    void speeds_of(const VecX& velocities, VecX& w) override { w = velocities.head(w.size()); }
    void velocities_of(const VecX& w, VecX& velocities) override { velocities = w; }
    ErrorNorm::Value measure(const ErrorNorm& norm, const VecX& step, const VecX& w) override {
        return norm.increment(step.data(), w.data());
    }
    ErrorNorm::Value distance(const ErrorNorm& norm, const VecX& x, const VecX& x2, const VecX& w,
                              const VecX& w2, double factor) override {
        return norm.difference(x, x2, w, w2, factor);
    }
    bool can_drift() const override { return system_.row_count() > 0; }

  private:
    template <class F> void for_bodies(F&& f) {
        for_ranges(system_.moving, threads_, grain, [&](std::ptrdiff_t begin, std::ptrdiff_t end) {
            for (std::ptrdiff_t i = begin; i < end; ++i)
                f(static_cast<int>(i));
        });
    }
    // Moves x so that its rate by the formula is T (w + a drift), drift being the pose corrections so far.
    void fit(const StepFormula& formula, int i, VecX& x, const VecX& w) {
        const double lag = 1 / formula.a;
        const Vec3 r = lag * (w.segment<3>(6 * i) - formula.bx.segment<3>(7 * i)) + drift_.segment<3>(6 * i);
        const Vec3 dr = r - x.segment<3>(7 * i);
        x.segment<3>(7 * i) = r;
        const Vec4 p = x.segment<4>(7 * i + 3);
        const Vec3 turn = fitting_turn(formula.a, p, formula.bx.segment<4>(7 * i + 3),
                                       w.segment<3>(6 * i + 3), drift_.segment<3>(6 * i + 3));
        x.segment<4>(7 * i + 3) = turned(p, turn);
        step_.segment<3>(6 * i) = dr;
        step_.segment<3>(6 * i + 3) = turn;
    }

    const System& system_;
    const int threads_;
    VecX drift_, step_;
};

class TreeCoordinates final : public StepCoordinates {
  public:
    explicit TreeCoordinates(const System& system)
        : system_(system), tree_(system), links_(tree_.make_links()), held_links_(links_),
          stored_links_(links_), motion_(system.start), held_motion_(motion_), stored_motion_(motion_),
          acceleration_(VecX::Zero(system.velocities())), products_(acceleration_), poses_(acceleration_),
          velocities_(acceleration_), drift_(VecX::Zero(tree_.speeds())), step_(drift_), change_(drift_) {
        for (const TreeLink& link : tree_.tree().links) {
            const bool turns = link.kind == TreeKind::free || link.kind == TreeKind::spherical;
            pieces_.push_back({link.coordinate, link.speed, speed_count(link.kind) - (turns ? 3 : 0), turns});
        }
    }

    int coordinates() const override { return tree_.coordinates(); }
    int speeds() const override { return tree_.speeds(); }
    void load(const State& state, VecX& x, VecX& w) override { tree_.take(state.q, state.u, x, w); }
    void store(const VecX& x, const VecX& w, State& state) override {
        tree_.set_motion(x, w, stored_motion_, stored_links_);
        state.q.resize(system_.positions());
        state.u.resize(system_.velocities());
        tree_.store(stored_motion_, state.q, state.u);
    }
    void normalise(VecX& x) const override { tree_.normalise(x); }
    void shift(const VecX& step, VecX& x) const override { tree_.move(step, x); }
    void go_to(const VecX& x, const VecX& w) override { tree_.set_motion(x, w, motion_, links_); }
    void set_motion(const VecX& x, const VecX& w, Workspace& ws) override {
        tree_.set_motion(x, w, motion_, links_);
        std::copy_n(motion_.begin(), system_.moving, ws.motion.begin());
    }
    void rates(const VecX& x, const VecX& w, const VecX& acceleration, VecX& x_rate, VecX& w_rate) override;

    void begin_step(const StepFormula& formula, VecX& predicted_x, const VecX& predicted_w, VecX& x,
                    VecX& w) override {
        tree_.normalise(predicted_x);
        x = predicted_x;
        w = predicted_w;
        drift_.setZero();
        fit(formula, x, w);
    }
    void momentum_residual(const VecX& w_rate, const VecX& f, VecX& momentum) override;
    void take_out_products(VecX& f) override;
    Moved move(const StepFormula& formula, const double* velocities, const double* poses, VecX& x,
               VecX& w) override;

    void hold() override {
        held_links_ = links_;
        held_motion_ = motion_;
    }
    void speeds_of(const VecX& velocities, VecX& w) override {
        tree_.project(held_motion_, held_links_, velocities, w);
    }
    void velocities_of(const VecX& w, VecX& velocities) override {
        tree_.expand(motion_, links_, w, velocities);
    }
    ErrorNorm::Value measure(const ErrorNorm& norm, const VecX& step, const VecX& w) override;
    ErrorNorm::Value distance(const ErrorNorm& norm, const VecX& x, const VecX& x2, const VecX& w,
                              const VecX& w2, double factor) override;

    const std::vector<bool>* kept_rows() const override { return &tree_.tree().kept; }
    bool can_drift() const override { return tree_.tree().cut_rows > 0; }
    // The motion is set anew before anything reads it.
    void visit(Archive& archive) override {
        archive(tree_);
        for (BodyMotion& m : held_motion_)
            archive(m.A);
        for (LinkMotion& x : held_links_)
            archive(x.axes, x.from_parent, x.centre);
    }

  private:
    void fit(const StepFormula& formula, VecX& x, const VecX& w);

    const System& system_;
    TreeKinematics tree_;
    std::vector<LinkMotion> links_, held_links_, stored_links_;
    std::vector<BodyMotion> motion_, held_motion_, stored_motion_;
    VecX acceleration_, products_, poses_, velocities_; // of the bodies
    VecX drift_, step_, change_;                        // along the freedoms
};

void TreeCoordinates::rates(const VecX& x, const VecX& w, const VecX& acceleration, VecX& x_rate,
                            VecX& w_rate) {
    x_rate.resize(coordinates());
    w_rate.resize(speeds());
    tree_.rates(x, w, x_rate);
    tree_.products(motion_, links_, products_);
    acceleration_ = acceleration - products_;
    tree_.project(motion_, links_, acceleration_, w_rate);
}

void TreeCoordinates::momentum_residual(const VecX& w_rate, const VecX& f, VecX& momentum) {
    tree_.expand(motion_, links_, w_rate, acceleration_);
    tree_.products(motion_, links_, products_);
    for (int i = 0; i < system_.moving; ++i) {
        const Vec6 rate = acceleration_.segment<6>(6 * i) + products_.segment<6>(6 * i);
        momentum.segment<3>(6 * i) = f.segment<3>(6 * i) - system_.mass[i] * rate.head<3>();
        momentum.segment<3>(6 * i + 3) = f.segment<3>(6 * i + 3) - system_.inertia[i] * rate.tail<3>();
    }
}

void TreeCoordinates::take_out_products(VecX& f) {
    tree_.products(motion_, links_, products_);
    mass_times(system_, products_, products_);
    f -= products_;
}

StepCoordinates::Moved TreeCoordinates::move(const StepFormula& formula, const double* velocities,
                                             const double* poses, VecX& x, VecX& w) {
    velocities_ = Eigen::Map<const VecX>(velocities, system_.velocities());
    tree_.project(held_motion_, held_links_, velocities_, change_);
    w += change_;
    if (can_drift()) {
        poses_ = Eigen::Map<const VecX>(poses, system_.velocities());
        tree_.project(held_motion_, held_links_, poses_, step_);
        drift_ += step_;
    }
    fit(formula, x, w);
    tree_.expand(motion_, links_, step_, poses_);
    tree_.expand(motion_, links_, change_, velocities_);
    return {poses_.data(), velocities_.data()};
}

// Moves x so that its rate by the formula is N (w + a drift); step_: how far along the freedoms.
void TreeCoordinates::fit(const StepFormula& formula, VecX& x, const VecX& w) {
    const double lag = 1 / formula.a;
    for (const Piece& piece : pieces_) {
        for (int k = 0; k < piece.straight; ++k) {
            const int i = piece.x + k, j = piece.w + k;
            const double next = lag * (w[j] - formula.bx[i]) + drift_[j];
            step_[j] = next - x[i];
            x[i] = next;
        }
        if (!piece.turns)
            continue;
        const int i = piece.x + piece.straight, j = piece.w + piece.straight;
        const Vec4 p = x.segment<4>(i);
        const Vec3 turn =
            fitting_turn(formula.a, p, formula.bx.segment<4>(i), w.segment<3>(j), drift_.segment<3>(j));
        x.segment<4>(i) = turned(p, turn);
        step_.segment<3>(j) = turn;
    }
}

ErrorNorm::Value TreeCoordinates::measure(const ErrorNorm& norm, const VecX& step, const VecX& w) {
    tree_.expand(motion_, links_, step, poses_);
    tree_.expand(motion_, links_, w, velocities_);
    return norm.increment(poses_.data(), velocities_.data());
}

ErrorNorm::Value TreeCoordinates::distance(const ErrorNorm& norm, const VecX& x, const VecX& x2,
                                           const VecX& w, const VecX& w2, double factor) {
    tree_.difference(x, x2, step_);
    step_ *= factor;
    change_ = factor * (w - w2);
    return measure(norm, step_, change_);
}

} // namespace

void coordinate_rates(const System& system, const VecX& q, const VecX& u, VecX& rates) {
    rates.resize(system.positions());
    for (int i = 0; i < system.moving; ++i) {
        rates.segment<3>(7 * i) = u.segment<3>(6 * i);
        rates.segment<4>(7 * i + 3) = 0.5 * lt_times(q.segment<4>(7 * i + 3), u.segment<3>(6 * i + 3));
    }
}

void normalise_orientations(const System& system, VecX& q) {
    for (int i = 0; i < system.moving; ++i)
        q.segment<4>(7 * i + 3).normalize();
}

std::unique_ptr<StepCoordinates> make_step_coordinates(const System& system, Formulation formulation,
                                                       int threads) {
    if (formulation == Formulation::tree)
        return std::make_unique<TreeCoordinates>(system);
    return std::make_unique<CartesianCoordinates>(system, threads);
}

} // namespace gudgeon

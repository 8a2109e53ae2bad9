#include "solvers/statics.hpp"

#include "solvers/redundancy.hpp"
#include "solvers/rest_point.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace gudgeon {

namespace {

constexpr double longest_share = 0.1;      // of the size of a body: longest move of a step at first
constexpr double longest_turn = 0.1;       // rad
constexpr double longest_of_bearing = 0.3; // of its radius or length
constexpr double least_return = 1e-9, most_return = 10; // of the longest move
constexpr int most_returns = 6;
constexpr double least_metric = 1e-3; // of the stiffness scale: smallest a
constexpr double pushes_back = 0.5;   // of the force along the step: more is too far
constexpr int most_trials = 40;       // of one step
constexpr double too_far = 30;        // sizes: what has moved this far falls
constexpr int relaxation_per_step = 20;
constexpr double loose = 1e-7; // residual that round-off of stiff contacts may leave

double largest(const VecX& x) { return x.size() ? x.cwiseAbs().maxCoeff() : 0.0; }

class Search {
  public:
    Search(const System& system, State& state, const StaticsOptions& options)
        : system_(system), state_(state), options_(options), closer_(system),
          closing_(make_workspace(system)), point_(system, state, dependent_rows(system, state)), q_(state.q),
          longest_(longest_share * body_size(system)) {
        find_bearings();
        closer_.regularise(1e-9); // repeated rows pass
        closing_.angles = point_.workspace().angles;
    }

    StaticsReport run() {
        const State before = state_;
        if (!point_.evaluate(q_)) {
            report_.message = "forces at the start are not finite, or its constraints are singular";
            return report_;
        }
        energy_ = report_.energy_before = point_.energy();
        if (options_.relax_only)
            relax();
        bool found = newton();
        if (!found && !falls()) {
            relax();
            found = newton();
        }
        for (int round = 0; found && round < most_returns && go_back(before.q); ++round) {
        }
        report_.factorisations = point_.factorisations();
        finish(before, found);
        return report_;
    }

  private:
    double residual() const { return largest(point_.left); }

    // How far a journal may move in its bearing in one step: farther it might come out on the other side.
    void find_bearings() {
        for (std::size_t j = 0; j < system_.joints.size(); ++j) {
            const SharedPart<Clearance>& clearance = system_.model.joints[j].clearance;
            if (!clearance || system_.joints[j].contact < 0)
                continue;
            double allowed = longest_;
            for (const std::optional<double>& size : {clearance->radius, clearance->length})
                if (size)
                    allowed = std::min(allowed, longest_of_bearing * *size);
            for (const double radius : clearance->profile)
                allowed = std::min(allowed, longest_of_bearing * radius);
            bearings_.push_back({&system_.joints[j], allowed});
        }
    }

    Vec3 move_of(const Anchor& anchor, const VecX& step) {
        if (anchor.body >= system_.moving)
            return Vec3::Zero();
        const Vec3 turn = step.segment<3>(6 * anchor.body + 3);
        return step.segment<3>(6 * anchor.body) +
               point_.workspace().motion[anchor.body].A * turn.cross(anchor.point);
    }

    // Largest move of a step: m over the length allowed, rad over the turn allowed.
    double length_of(const VecX& step) {
        double most = 0;
        for (int i = 0; i < system_.moving; ++i)
            most = std::max({most, step.segment<3>(6 * i).norm() / longest_,
                             step.segment<3>(6 * i + 3).norm() / longest_turn});
        for (const Bearing& x : bearings_)
            most = std::max(most, (move_of(x.joint->b, step) - move_of(x.joint->a, step)).norm() / x.allowed);
        return most;
    }

    // Moves along the step and back onto the constraints; the forces there along the step.
    std::optional<double> force_after(const VecX& step, double share, VecX& q) {
        q = q_;
        move(system_, share * step, q);
        closing_.angles = point_.workspace().angles;
        if (system_.row_count() > 0 && !closer_.project_positions(state_.t, q, point_.rest(), closing_) &&
            !(closer_.worst_position() <= 1e-10))
            return std::nullopt;
        if (!point_.evaluate(q))
            return std::nullopt;
        return step.dot(point_.left);
    }

    // What the energy and the work of the forces that store none fall by in a step to q, J; round-off of the
    // energies counts as falling.
    bool climbs(const VecX& step, const VecX& q) {
        const double now = point_.energy();
        const double work = 0.5 * (point_.applied_work(q_, step) + point_.applied_work(q, step));
        return now - energy_ - work > 1e-10 * (std::abs(now) + std::abs(energy_));
    }

    // Takes the step, or what of it the forces allow. The share taken; 0: nothing. low: they still push on;
    // high: they push back (at_high < 0), or the energy has risen on the way.
    double take(const VecX& step, double before) {
        double share = 1, low = 0, high = 0, at_low = before, at_high = 0;
        VecX q, best;
        for (int trial = 0; trial < most_trials; ++trial) {
            const std::optional<double> force = force_after(step, share, q);
            const bool above = !force || climbs(share * step, q);
            const bool near = force && std::abs(*force) <= pushes_back * before;
            if (!above && (near || (*force > 0 && (high == 0 || at_high == 0)))) {
                accept(q);
                return share;
            }
            if (!above && *force > 0) {
                low = share;
                at_low = *force;
                at_high *= 0.5; // Illinois
                best = q;
            } else {
                high = share;
                at_high = force && *force < 0 ? *force : 0;
                if (low > 0)
                    at_low *= 0.5;
            }
            const double width = high - low;
            if (width <= 1e-12 * high)
                break;
            const double root = low + width * at_low / (at_low - at_high);
            share = at_high == 0     ? low + 0.25 * width
                    : trial % 4 == 3 ? 0.5 * (low + high)
                                     : std::clamp(root, low + 1e-3 * width, high - 1e-3 * width);
        }
        if (low > 0 && point_.evaluate(best)) {
            accept(best);
            return low;
        }
        point_.evaluate(q_);
        return 0;
    }

    void accept(const VecX& q) {
        q_ = q;
        energy_ = point_.energy();
        for (int i = 0; i < system_.moving; ++i)
            moved_ = std::max(moved_, (q_.segment<3>(7 * i) - state_.q.segment<3>(7 * i)).norm());
        point_.follow_angles();
    }

    bool falls() const { return moved_ > too_far * point_.size(); }

    bool arrived() const { return residual() <= options_.tolerance * point_.force_scale(); }

    bool newton() {
        double a = 0;
        for (int i = 0; i < system_.moving; ++i)
            a = std::max(a, point_.left.segment<3>(6 * i).norm() / system_.mass[i] / longest_);
        const double least = least_metric * point_.stiffness_scale();
        a = std::max(a, least);
        int stuck = 0;
        for (int k = 0; k < options_.most_steps && !falls(); ++k) {
            if (arrived()) {
                polish(least);
                return true;
            }
            ++report_.steps;
            point_.linearise();
            VecX step;
            double along = 0;
            for (int trial = 0; trial < 60; ++trial, a *= 4) {
                if (!solve(a, step))
                    continue;
                along = step.dot(point_.left);
                if (along > 0 && length_of(step) <= 4)
                    break;
            }
            if (!(along > 0))
                break;
            if (const double length = length_of(step); length > 1) {
                step /= length;
                along /= length;
            }
            const double share = take(step, along);
            if (share == 0 && ++stuck > 3)
                break;
            stuck = share == 0 ? stuck : 0;
            a = share >= 0.9 ? std::max(0.25 * a, least) : share < 0.1 ? 4 * a : a;
            if (share == 1 && moved_ > 3 * point_.size())
                longest_ = std::max(longest_, 0.2 * moved_); // what falls is found out soon
        }
        const auto small = [&] { return residual() <= std::max(loose * point_.force_scale(), round_off()); };
        if (!small())
            return false;
        polish(least);
        return small() && at_round_off(least);
    }

    // What round-off of the coordinates makes of the stiffness: small loads on stiff links end there.
    double round_off() {
        point_.linearise();
        return 4 * std::numeric_limits<double>::epsilon() * point_.largest_stiffness() * largest(q_);
    }

    bool solve(double a, VecX& step) {
        if (!point_.factor(a).ok())
            return false;
        step = point_.left;
        VecX rows = -point_.workspace().phi;
        point_.solve(step, rows);
        return step.allFinite();
    }

    // A step that would move nothing any more.
    bool at_round_off(double a) {
        point_.linearise();
        VecX step;
        return solve(a, step) && largest(step) <= 1e-12 * (1 + largest(q_));
    }

    // Whole Newton steps while they help.
    void polish(double a) {
        for (int k = 0; k < 6 && residual() > 0; ++k) {
            const double before = residual();
            const VecX kept = q_;
            point_.linearise();
            VecX step, q;
            if (!solve(a, step) || length_of(step) > 0.01 || !force_after(step, 1, q) ||
                residual() >= before) {
                point_.evaluate(kept);
                return;
            }
            accept(q);
            if (residual() > 0.5 * before)
                return;
        }
    }

    // Displacement since the start: m, and the shortest turn (rad, body frame).
    VecX displacement(const VecX& from) const {
        VecX out(system_.velocities());
        for (int i = 0; i < system_.moving; ++i) {
            out.segment<3>(6 * i) = q_.segment<3>(7 * i) - from.segment<3>(7 * i);
            const Vec4 p = from.segment<4>(7 * i + 3);
            Vec4 to = q_.segment<4>(7 * i + 3);
            if (p.dot(to) < 0)
                to = -to;
            const Vec3 sine = l_times(p, to); // of half the turn
            const double length = sine.norm();
            out.segment<3>(6 * i + 3) =
                length > 0 ? Vec3(2 * std::atan2(length, p.dot(to)) / length * sine) : Vec3::Zero();
        }
        return out;
    }

    double mass_norm(const VecX& x) const {
        VecX m = x;
        mass_times(system_, x, m);
        return std::sqrt(x.dot(m));
    }

    // Every body along its own screw: whole rigid motions and turns about hinges are exact.
    VecX screwed(const VecX& step) {
        VecX q = q_;
        for (int i = 0; i < system_.moving; ++i) {
            const Vec3 shift = step.segment<3>(6 * i), turn = step.segment<3>(6 * i + 3);
            const Vec3 axis = point_.workspace().motion[i].A * turn;
            const double angle = axis.norm();
            const double even = angle > 1e-4 ? (1 - std::cos(angle)) / (angle * angle) : 0.5;
            const double odd = angle > 1e-4 ? (angle - std::sin(angle)) / (angle * angle * angle) : 1.0 / 6;
            q.segment<3>(7 * i) += shift + even * axis.cross(shift) + odd * axis.cross(axis.cross(shift));
            q.segment<4>(7 * i + 3) = turned(q.segment<4>(7 * i + 3), turn);
        }
        return q;
    }

    // Takes back what the search has moved along neutral directions. True: there was something to take back.
    bool go_back(const VecX& from) {
        State here = state_;
        here.q = q_;
        here.angles = point_.workspace().angles;
        const VecX moved = displacement(from);
        VecX weighted = moved, back = point_.rest();
        mass_times(system_, moved, weighted);
        for (const NeutralDirection& neutral : neutral_directions(system_, here))
            back -= neutral.direction.dot(weighted) * neutral.direction;
        if (length_of(back) <= least_return || length_of(back) > most_return)
            return false;
        const StaticsReport counts = report_;
        q_ = screwed(back);
        VecX q;
        if (force_after(point_.rest(), 1, q)) { // onto the constraints
            accept(q);
            if (newton() && mass_norm(displacement(from)) < mass_norm(moved))
                return true;
        }
        report_ = counts;
        q_ = here.q;
        point_.workspace().angles = here.angles;
        point_.evaluate(q_);
        energy_ = point_.energy();
        return false;
    }

    // Motion with time frozen by implicit Euler steps; rests anew at every peak of the kinetic energy.
    void relax() {
        VecX speed = point_.rest(), momentum = speed, step = speed, q;
        double kinetic = 0, h = 0.05 / std::sqrt(point_.stiffness_scale());
        const int most = relaxation_per_step * options_.most_steps;
        for (int k = 0; k < most && residual() > 1e-6 * point_.force_scale() && !falls(); ++k) {
            ++report_.relaxation_steps;
            point_.linearise();
            mass_times(system_, speed, momentum);
            VecX rows = -point_.workspace().phi;
            step = point_.left + momentum / h;
            if (!point_.factor(1 / (h * h)).ok()) {
                h *= 0.5;
                continue;
            }
            point_.solve(step, rows);
            const double along = step.dot(point_.left);
            const std::optional<double> force =
                length_of(step) <= 1 ? force_after(step, 1, q) : std::optional<double>();
            if (!force || *force < -std::max(2 * std::abs(along), momentum.dot(step) / h)) {
                h *= 0.5;
                speed.setZero();
                point_.evaluate(q_);
                continue;
            }
            accept(q);
            speed = step / h;
            mass_times(system_, speed, momentum);
            const double now = 0.5 * speed.dot(momentum);
            if (now < kinetic)
                speed.setZero();
            kinetic = speed.isZero(0) ? 0 : now;
            h *= 1.2;
        }
    }

    void finish(const State& before, bool found) {
        point_.evaluate(q_);
        report_.ok = found;
        report_.residual = residual();
        report_.force_scale = point_.force_scale();
        report_.constraint = point_.largest_constraint();
        report_.energy_after = point_.energy();
        if (!found)
            report_.message = what_accelerates();
        state_.q = q_;
        state_.lambda = point_.lambda;
        state_.angles = point_.workspace().angles;
        state_.z.setZero();
        state_.u.setZero();
        if (system_.row_count() > 0)
            closer_.project_velocities(state_.t, state_.q, state_.u, closing_);
        set_contacts();
        list_moves(before);
    }

    // What contacts remember of a landing that never was.
    void set_contacts() {
        Workspace& ws = point_.workspace();
        state_.contacts.start_speed.setConstant(-1);
        if (system_.contacts.empty())
            return;
        ws.contacts = state_.contacts;
        sample_contacts(system_, state_.t, ws);
        double outer = 0;
        int outer_channel = -1;
        for (int c = 0; c < system_.channels(); ++c) {
            const ContactSample& sample = ws.samples[c];
            state_.contacts.place[c] = sample.place;
            state_.contacts.start_time[c] = state_.t;
            if (!(sample.depth > 0))
                continue;
            if (sample.elastic > 0) {
                outer = std::sqrt(2 * sample.elastic * sample.inverse_mass);
                outer_channel = c;
            }
            // the inner slot of a blend follows its outer one
            const bool follows = sample.elastic == 0 && outer_channel == c - 1;
            state_.contacts.start_speed[c] =
                std::max(sample.elastic > 0 || follows ? outer : 0.0, least_speed);
        }
    }
    static constexpr double least_speed = 1e-8; // m/s: from here on laws take a speed for known

    void list_moves(const State& before) {
        for (int i = 0; i < system_.moving; ++i) {
            const Vec4 p0 = before.q.segment<4>(7 * i + 3), p1 = q_.segment<4>(7 * i + 3);
            AssemblyReport::Change c{};
            c.body = i;
            c.shift = (q_.segment<3>(7 * i) - before.q.segment<3>(7 * i)).norm();
            c.turn = 4 * std::asin(std::min(1.0, 0.5 * std::min((p1 - p0).norm(), (p1 + p0).norm())));
            if (std::max(c.shift, c.turn) > 1e-12)
                report_.moved.push_back(c);
        }
    }

    std::string what_accelerates() {
        VecX acceleration = point_.left;
        inverse_mass_times(system_, acceleration, acceleration);
        std::vector<std::pair<double, int>> bodies;
        for (int i = 0; i < system_.moving; ++i)
            bodies.emplace_back(acceleration.segment<6>(6 * i).norm(), i);
        std::ranges::stable_sort(bodies, std::ranges::greater{}, &std::pair<double, int>::first);
        std::string text = falls()
                               ? fmt::format("no equilibrium: after {:.3g} m forces still move", moved_)
                               : fmt::format("no equilibrium was found: {:.3g} of {:.3g} N or N m remain on",
                                             residual(), point_.force_scale());
        for (std::size_t k = 0; k < bodies.size() && k < 6 && bodies[k].first >= 1e-3 * bodies[0].first;
             ++k) {
            const int i = bodies[k].second;
            text +=
                fmt::format("{} '{}' ({:.3g} m/s2, {:.3g} rad/s2)", k ? "," : "", system_.body_names[i],
                            acceleration.segment<3>(6 * i).norm(), acceleration.segment<3>(6 * i + 3).norm());
        }
        return text + "; hold them by a joint, a spring or a contact, or start as given";
    }

    const System& system_;
    State& state_;
    const StaticsOptions& options_;
    ConsistentSolver closer_;
    Workspace closing_;
    RestPoint point_;
    VecX q_;
    double longest_, moved_ = 0, energy_ = 0; // m, m, J
    struct Bearing {
        const JointRecord* joint;
        double allowed; // m
    };
    std::vector<Bearing> bearings_;
    StaticsReport report_;
};

} // namespace

std::vector<std::string> StaticsReport::notices() const {
    constexpr std::size_t most = 8;
    std::vector<std::string> out;
    for (std::size_t k = 0; k < std::min(neutral.size(), most); ++k)
        out.push_back("nothing holds this motion at rest: " + neutral[k].words);
    if (neutral.size() > most)
        out.push_back(fmt::format("and {} motions more that nothing holds", neutral.size() - most));
    if (unstable > 0)
        out.push_back(
            fmt::format("the equilibrium is unstable in {} direction{}", unstable, unstable > 1 ? "s" : ""));
    return out;
}

StaticsReport find_equilibrium(const System& system, State& state, const StaticsOptions& options) {
    StaticsReport report;
    if (system.moving == 0) {
        report.ok = true;
        return report;
    }
    report = Search(system, state, options).run();
    if (report.ok)
        report.neutral = neutral_directions(system, state, &report.unstable);
    return report;
}

} // namespace gudgeon

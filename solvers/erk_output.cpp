// What an explicit method tells: states inside the last step, counts, why it cannot go on, all of itself.
#include "core/bad_numbers.hpp"
#include "solvers/erk.hpp"
#include "solvers/phase_timer.hpp"
#include "solvers/singular_position.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace gudgeon {

namespace {
constexpr double way_to_look = 1e6; // of the smallest step, for a singular position ahead
} // namespace

StepOutcome Erk::stuck(const Attempt& trial) const {
    const double t = now_.state.t;
    if (reason_ == StepReason::non_finite && !trouble_.empty())
        return {false, StepReason::non_finite, fmt::format("at t = {:.9g} s: {}", t, trouble_)};
    if (reason_ == StepReason::singular)
        return {
            false, StepReason::singular,
            fmt::format("at t = {:.9g} s the acceleration equations are singular (constraints repeat each "
                        "other?); first at {}",
                        t, equations_->name_of(status_.column))};
    if (!(trial.h > 0))
        return {false, reason_, fmt::format("at t = {:.9g} s accelerations are beyond all numbers", t)};
    std::string text = fmt::format("at t = {:.9g} s the step fell to {:.3g} s; last rejected by {}", t,
                                   trial.h, step_reason_name(reason_));
    if (const std::string rows = singular_rows(system_, now_.state, way_to_look * smallest_step());
        !rows.empty())
        text += fmt::format("; next to a singular position, where {} repeat other constraints", rows);
    if (const std::string contact = watch_.culprit(-1); !contact.empty())
        text += "; contact of " + contact;
    return {false, StepReason::step_too_small, text};
}

// Work for output is left out: what a run costs does not depend on who looks at it.
const Statistics& Erk::statistics() const {
    equations_->report(statistics_);
    statistics_.evaluations -= output_work_[0];
    statistics_.factorisations -= output_work_[1];
    statistics_.refactorisations -= output_work_[2];
    return statistics_;
}

std::array<long, 3> Erk::work_so_far() const {
    Statistics all;
    equations_->report(all);
    return {all.evaluations, all.factorisations, all.refactorisations};
}

// The further stages belong to the memory of contacts and angles that the step was made with.
void Erk::dense_stages() const {
    const State &a = before_.state, &b = now_.state;
    const double h = b.t - a.t;
    const std::array<long, 3> before = work_so_far();
    ws_.remember(a);
    for (int j = known_; j < pair_.all_stages(); ++j) {
        combine(before_.y, pair_.a[j], h, y_);
        if (!rates(a.t + pair_.c[j] * h, y_, slope_[j]))
            slope_[j] = slope_[pair_.stages];
    }
    known_ = pair_.all_stages();
    ws_.remember(b);
    const std::array<long, 3> after = work_so_far();
    for (std::size_t i = 0; i < after.size(); ++i)
        output_work_[i] += after[i] - before[i];
}

void Erk::interpolate(double t, State& out) const {
    const PhaseTimer timer(statistics_.seconds.output);
    out = now_.state;
    const double begin = before_.state.t, h = now_.state.t - begin;
    if (!(h > 0) || t >= now_.state.t || known_ == 0)
        return;
    if (known_ < pair_.all_stages())
        dense_stages();
    const double share = std::max(0.0, (t - begin) / h);
    pair_.dense_weights(share, dense_weight_);
    y_ = before_.y;
    for (int j = 0; j < pair_.all_stages(); ++j)
        y_ += (h * dense_weight_[j]) * slope_[j];
    x_now_ = y_.head(x_);
    w_now_ = y_.segment(x_, w_);
    equations_->normalise(x_now_);
    out.t = t;
    equations_->store(x_now_, w_now_, out);
    out.z = y_.segment(x_ + w_, z_);
    out.work = y_.tail(y_.size() - x_ - w_ - z_);
    out.lambda = before_.state.lambda + share * (now_.state.lambda - before_.state.lambda);
    watch_.memory_inside(out.contacts);
}

void Erk::visit(Archive& archive) {
    archive.section(name());
    archive(ws_, watch_, before_, now_, slope_, first_slope_, known_, output_work_[0], output_work_[1],
            output_work_[2], fresh_, h_, error_, reason_, external_, statistics_);
    equations_->visit(archive);
    if (archive.reading())
        started_ = {};
}

} // namespace gudgeon

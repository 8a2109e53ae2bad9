#include "solvers/contact_watch.hpp"

#include "core/bad_numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace gudgeon {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double energy_per_tolerance = 20, largest_share = 1e-2;
constexpr double root_share = 1e-3;   // of the threshold: an onset counts as met
constexpr double jump = 1e-3;         // of the depth: a contact that is not shallower where it begins
constexpr double aim = 0.2;           // of the threshold: where a repeated step should end
constexpr double least_share = 1e-6;  // of a strip that the journal hardly covers
constexpr double step_per_rise = 0.2; // first step in a contact, of the time to its greatest depth

bool touching(const ContactMemory& memory, int channel) { return memory.start_speed[channel] >= 0; }

// Greatest value of the cubic through depth and rate at both ends of a step.
template <class Before> double greatest_depth(double h, const Before& a, const ContactSample& b) {
    double greatest = std::max(a.depth, b.depth);
    if (!(a.rate > 0 && b.rate < 0))
        return greatest;
    double low = 0, high = 1;
    const auto slope = [&](double s) {
        return 6 * s * (1 - s) * (b.depth - a.depth) + h * ((1 - s) * (1 - 3 * s) * a.rate) +
               h * (s * (3 * s - 2) * b.rate);
    };
    for (int i = 0; i < 30; ++i) {
        const double middle = 0.5 * (low + high);
        (slope(middle) > 0 ? low : high) = middle;
    }
    const double s = low, r = 1 - s;
    return std::max(greatest, r * r * (1 + 2 * s) * a.depth + s * s * (3 - 2 * s) * b.depth +
                                  h * s * r * (r * a.rate - s * b.rate));
}

} // namespace

// What is apart now and was so before has nothing to change.
template <class F> void ContactWatch::for_elements(const Workspace& ws, F&& f) const {
    for (std::size_t k = 0; k < before_apart_.size(); ++k) {
        const int first = system_.contact_elements[k];
        for (int c = first; c < system_.contact_elements[k + 1] && !(ws.apart[first] && before_apart_[k]);
             ++c)
            f(c);
    }
}

ContactWatch::ContactWatch(const System& system, const IntegratorOptions& options)
    : system_(system), onset_(options.onset),
      share_(std::min(energy_per_tolerance * std::max(options.rtol, 1e-12), largest_share)),
      before_(system.contacts.size()), before_apart_(system.contact_elements.size() - 1),
      fresh_(system.contacts.size()), now_(system.contact_joints.size()), suggested_(infinity) {}

void ContactWatch::tell(ContactEvent::Kind kind, int channel, double t, double depth, double speed) const {
    if (on_contact)
        on_contact({kind, t, channel, depth, speed});
}

void ContactWatch::begin(State& state, Workspace& ws) {
    suggested_ = infinity;
    if (idle())
        return;
    ws.contacts = state.contacts;
    sample_contacts(system_, state.t, ws);
    for (int c = 0; c < system_.channels(); ++c) {
        const ContactSample& sample = ws.samples[c];
        if (sample.depth >= 0 && !touching(state.contacts, c))
            begin_contact({c, state.t, std::max(sample.rate, 0.0), sample.depth}, sample, state);
        else if (sample.depth < 0 && !(sample.rate > 0)) // met from below by rounding it goes on
            state.contacts.start_speed[c] = -1;
        state.contacts.place[c] = sample.place;
    }
    suggested_ = infinity; // the integrator finds its first step
    ws.contacts = state.contacts;
    sample_contacts(system_, state.t, ws);
    std::ranges::fill(before_apart_, 0);
    keep(ws);
}

void ContactWatch::keep(const Workspace& ws) {
    for (std::size_t k = 0; k < before_apart_.size(); ++k) {
        const int first = system_.contact_elements[k];
        if (!ws.apart[first] || !before_apart_[k])
            for (int c = first; c < system_.contact_elements[k + 1]; ++c)
                before_[c] = {ws.samples[c].depth, ws.samples[c].rate, ws.samples[c].force};
        before_apart_[k] = ws.apart[first];
    }
}

void ContactWatch::move_bodies(double t, int channel, Workspace& ws, const MotionAt& motion_at) const {
    const ContactChannel& c = system_.contacts[channel];
    for (const int body : {c.a, c.b})
        if (body < system_.moving)
            motion_at(t, body, ws.motion[body]);
}

// Where the depth passes zero upwards in [t0, t1], by Newton's method kept inside a shrinking bracket.
// guess: tried first where it lies inside. Leaves the motion of the channel's bodies at t1.
ContactWatch::Crossing ContactWatch::crossing(double t0, double t1, int channel, double guess, Workspace& ws,
                                              const MotionAt& motion_at) {
    double low = t0, high = t1;
    const ForceBatch& batch = *system_.forces[system_.contacts[channel].batch];
    ContactSample at = ws.samples[channel];
    double t = t1, best_t = t1, best = infinity, speed = at.rate;
    for (int i = 0; i < 60 && high - low > 4e-16 * std::abs(high); ++i) {
        if (at.share > 0 && std::abs(at.depth) < best) { // a strip that the journal leaves bare has no depth
            best = std::abs(at.depth);
            best_t = t;
            speed = at.rate;
        }
        if (best < 1e-17)
            break;
        (at.depth > 0 ? high : low) = t;
        const double newton = t - at.depth / at.rate;
        const bool inside = at.rate > 0 && newton > low && newton < high;
        if (inside && newton == t)
            break;
        t = inside ? newton : 0.5 * (low + high);
        if (i == 0 && guess > low && guess < high)
            t = guess;
        move_bodies(t, channel, ws, motion_at);
        at = batch.approach(evaluation(system_, ws, t), channel);
    }
    move_bodies(t1, channel, ws, motion_at);
    return {channel, best_t, std::max(speed, 0.0), best};
}

double ContactWatch::threshold(int channel, double speed, const ContactSample& sample) const {
    const ForceBatch& batch = *system_.forces[system_.contacts[channel].batch];
    const double share = std::max(sample.share, least_share);
    const Model::Onset& wanted = system_.model.onset;
    double depth;
    if (wanted.depth)
        depth = *wanted.depth;
    else if (wanted.force)
        depth = batch.depth_of_force(channel, *wanted.force / share);
    else if (wanted.energy)
        depth = batch.depth_of_energy(channel, *wanted.energy / share);
    else
        depth = batch.depth_of_energy(channel, share_ * 0.5 * speed * speed / (share * sample.inverse_mass));
    return onset_ == Onset::root ? root_share * depth : depth;
}

ContactWatch::Verdict ContactWatch::judge(double t0, double t1, Workspace& ws, const MotionAt& motion_at,
                                          ContactEvent::Kind told) {
    starts_.clear();
    Verdict verdict;
    if (idle())
        return verdict;
    sample_contacts(system_, t1, ws);
    verdict.end = t1;
    ws.for_near(system_, [&](std::size_t, int first, int last) {
        double guess = t0; // strips of a joint begin together
        for (int c = first; c < last; ++c)
            weigh(t0, t1, c, true, guess, ws, motion_at, verdict);
    });
    if (!verdict.ok) {
        rejected_ = verdict.channel;
        tell(told, verdict.channel, t1, verdict.depth, ws.samples[verdict.channel].rate);
    }
    return verdict;
}

// The earliest of the ends that the channels ask for. Most need no search for their start: they are still
// apart at the end that another one asks for. That of the longest way past zero is looked at first.
double ContactWatch::foresee(double t0, double t1, Workspace& ws, const MotionAt& carried_on) {
    if (idle() || onset_ == Onset::ignored)
        return t1;
    const Evaluation e = evaluation(system_, ws, t1);
    for (const auto& batch : system_.forces)
        batch->find_fresh(e, fresh_.data());
    deep_.clear();
    std::size_t first_met = 0;
    double longest = -1;
    for (std::size_t k = 0; k < before_apart_.size(); ++k) {
        const int first = system_.contact_elements[k];
        if (!fresh_[first])
            continue;
        system_.forces[system_.contacts[first].batch]->sample_element(e, first, ws.samples);
        for (int c = first; c < system_.contact_elements[k + 1]; ++c) {
            const ContactSample& sample = ws.samples[c];
            // a higher speed at the start would allow more
            if (!(sample.depth > 0) || touching(ws.contacts, c) ||
                sample.depth <= threshold(c, std::abs(sample.rate), sample))
                continue;
            if (const double way = sample.depth / std::abs(sample.rate); way > longest) {
                longest = way;
                first_met = deep_.size();
            }
            deep_.push_back(c);
        }
    }
    Verdict verdict;
    verdict.end = t1;
    if (!deep_.empty())
        std::swap(deep_.front(), deep_[first_met]);
    for (const int c : deep_) {
        if (!verdict.ok) {
            move_bodies(verdict.end, c, ws, carried_on);
            const ForceBatch& batch = *system_.forces[system_.contacts[c].batch];
            if (!(batch.approach(evaluation(system_, ws, verdict.end), c).depth > 0))
                continue;
        }
        double guess = verdict.end;
        weigh(t0, t1, c, false, guess, ws, carried_on, verdict);
    }
    return verdict.end;
}

// One channel of a step that ends as ws.samples says. What begins shallow counts where its start is wanted.
void ContactWatch::weigh(double t0, double t1, int c, bool start_wanted, double& guess, Workspace& ws,
                         const MotionAt& motion_at, Verdict& verdict) {
    const ContactSample& sample = ws.samples[c];
    if (!(sample.depth > 0) || touching(ws.contacts, c))
        return;
    const Crossing start = crossing(t0, t1, c, guess, ws, motion_at);
    guess = start.t;
    if (start_wanted)
        starts_.push_back(start);
    if (onset_ == Onset::ignored)
        return;
    const double speed = std::max(start.speed, std::abs(sample.rate));
    const double allowed = threshold(c, speed, sample);
    if (sample.depth <= allowed)
        return;
    if (start.depth > root_share * allowed && start.depth > jump * sample.depth)
        return; // it appears at a depth: a journal slides over it. No shorter step finds it shallower
    double end = start.t;
    if (onset_ == Onset::threshold)
        end += start.speed > 0 ? aim * allowed / start.speed : 0.1 * (t1 - start.t);
    end = std::clamp(end, t0 + 1e-4 * (t1 - t0), t0 + 0.9 * (t1 - t0));
    if (verdict.ok || end < verdict.end)
        verdict = {false, end, c, sample.depth, allowed};
}

// Last passage through zero in the step, by the cubic through depth and rate at both its ends.
ContactEvent ContactWatch::end_of_contact(double t0, double t1, int channel, Workspace& ws) const {
    const Before& a = before_[channel];
    const ContactSample b =
        system_.forces[system_.contacts[channel].batch]->sample_contact(evaluation(system_, ws, t1), channel);
    const double h = t1 - t0;
    double low = 0, high = 1;
    for (int i = 0; i < 50 && a.depth > 0; ++i) {
        const double s = 0.5 * (low + high), r = 1 - s;
        const double depth = r * r * (1 + 2 * s) * a.depth + s * s * (3 - 2 * s) * b.depth +
                             h * s * r * (r * a.rate - s * b.rate);
        (depth > 0 ? low : high) = s;
    }
    return {ContactEvent::Kind::end, t0 + low * h, channel, 0, b.rate};
}

void ContactWatch::begin_contact(const Crossing& start, const ContactSample& sample, State& state) {
    mark(start.channel);
    state.contacts.start_speed[start.channel] = start.speed;
    state.contacts.start_time[start.channel] = start.t;
    const ContactChannel& channel = system_.contacts[start.channel];
    ++state.history[system_.joints[channel.joint].contact].impacts;
    tell(ContactEvent::Kind::start, start.channel, start.t, sample.depth, start.speed);
    if (!(start.speed > 0))
        return;
    const double rise = system_.forces[channel.batch]->depth_of_energy(
        start.channel,
        0.5 * start.speed * start.speed / (std::max(sample.share, least_share) * sample.inverse_mass));
    suggested_ = std::min(suggested_, step_per_rise * rise / start.speed);
}

// A contact of the channel's element has begun or ended: its forces are others than sampled.
void ContactWatch::mark(int channel) {
    changed_ = true;
    const std::vector<int>& first = system_.contact_elements;
    fresh_[*std::prev(std::ranges::upper_bound(first, channel))] = 1;
}

void ContactWatch::sample_marked(double t, Workspace& ws) const {
    const Evaluation e = evaluation(system_, ws, t);
    for (std::size_t k = 0; changed_ && k < before_apart_.size(); ++k)
        if (const int first = system_.contact_elements[k]; fresh_[first])
            system_.forces[system_.contacts[first].batch]->sample_element(e, first, ws.samples);
}

std::string ContactWatch::culprit(int body) const {
    if (rejected_ >= 0)
        return fmt::format("{}, which began too deep in every step tried", contact_name(system_, rejected_));
    int worst = -1;
    for (int c = 0; c < system_.channels(); ++c) {
        const ContactChannel& channel = system_.contacts[c];
        if (before_[c].depth > 0 && (body < 0 || channel.a == body || channel.b == body) &&
            (worst < 0 || before_[c].force > before_[worst].force))
            worst = c;
    }
    if (worst < 0)
        return "";
    const bool turns = system_.contacts[worst].rotation;
    return fmt::format("{}, {:.3g} {} deep, pressing with {:.3g} {}", contact_name(system_, worst),
                       before_[worst].depth, turns ? "rad" : "m", before_[worst].force, turns ? "N m" : "N");
}

void ContactWatch::commit(double t0, double t1, State& state, Workspace& ws) {
    rejected_ = -1;
    suggested_ = infinity;
    before_speed_ = state.contacts.start_speed;
    changed_ = false;
    if (idle())
        return;
    std::ranges::fill(fresh_, 0);
    std::ranges::sort(starts_, {}, &Crossing::t);
    std::vector<ContactEvent> ended;
    for (const Crossing& start : std::exchange(starts_, {}))
        begin_contact(start, ws.samples[start.channel], state);
    const auto settle = [&](int c) {
        const ContactSample& sample = ws.samples[c];
        if (sample.depth <= 0 && touching(state.contacts, c)) {
            state.contacts.start_speed[c] = -1;
            mark(c);
            if (on_contact)
                ended.push_back(end_of_contact(t0, t1, c, ws));
        } else if (onset_ == Onset::root && sample.depth <= 0 && sample.rate > 0) {
            const ContactSample exact =
                system_.forces[system_.contacts[c].batch]->sample_contact(evaluation(system_, ws, t1), c);
            if (exact.rate > 0 && -exact.depth <= threshold(c, exact.rate, exact))
                begin_contact({c, t1, exact.rate, 0}, exact, state); // met from below by rounding
        }
        state.contacts.place[c] = sample.place;
    };
    for_elements(ws, settle);
    std::ranges::stable_sort(ended, {}, &ContactEvent::t);
    for (const ContactEvent& event : ended)
        on_contact(event);
    for_elements(ws, [&](int c) {
        ws.contacts.start_speed[c] = state.contacts.start_speed[c];
        ws.contacts.start_time[c] = state.contacts.start_time[c];
        ws.contacts.place[c] = state.contacts.place[c];
    });
    sample_marked(t1, ws);
    record(t0, t1, state, ws);
    keep(ws);
}

void ContactWatch::memory_inside(ContactMemory& out) const {
    if (before_speed_.size() == out.start_speed.size())
        out.start_speed = out.start_speed.cwiseMax(before_speed_);
}

// A joint's channels lie in several batches: strips, end faces, stops.
void ContactWatch::record(double t0, double t1, State& state, Workspace& ws) {
    std::ranges::fill(now_, JointNow{});
    for_elements(ws, [&](int c) {
        const ContactSample& sample = ws.samples[c];
        if (!(sample.depth > 0) && !(before_[c].depth > 0))
            return;
        const int joint = system_.joints[system_.contacts[c].joint].contact;
        JointNow& now = now_[joint];
        ContactHistory& history = state.history[joint];
        now.touches = now.touches || sample.depth > 0;
        double& deepest = system_.contacts[c].rotation ? history.deepest_angle : history.deepest;
        deepest = std::max(deepest, greatest_depth(t1 - t0, before_[c], sample));
        now.resultant += sample.normal_force + sample.friction_force;
        if (system_.contacts[c].rotation)
            now.moment = std::max(now.moment, sample.force);
    });
    for (std::size_t joint = 0; joint < now_.size(); ++joint) {
        ContactHistory& history = state.history[joint];
        history.peak_force = std::max(history.peak_force, now_[joint].resultant.norm());
        history.peak_moment = std::max(history.peak_moment, now_[joint].moment);
        if (now_[joint].touches)
            history.touching += t1 - t0;
    }
}

} // namespace gudgeon

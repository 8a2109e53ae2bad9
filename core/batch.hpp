// Batches: all elements of one kind in one flat array, evaluated by one virtual call.
//
// Elements of a batch are sorted into colours; no two elements of a colour touch the same moving
// body, so a colour can be evaluated in parallel and every sum is formed in the same order for any
// number of threads.
#pragma once

#include "core/contact.hpp"
#include "core/parallel.hpp"
#include "core/relative_motion.hpp"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gudgeon {

/// What every kernel may read.
struct Evaluation {
    double t = 0;
    const BodyMotion* body = nullptr;
    int moving = 0; // bodies [0, moving) have unknowns, the others are fixed
    /// Unwrapped angles of the last accepted step, to choose the branch of an angle measure.
    const double* angle = nullptr;
    const double* angle_rate = nullptr;
    double t_accepted = 0;
    int threads = 1;
    const double* start_speed = nullptr; // per contact channel, at the last accepted step
    const double* place = nullptr;
    const double* z = nullptr;      // friction states
    const double* lambda = nullptr; // multipliers that friction in perfect joints takes its force from
    double* scratch = nullptr;      // for the batches' own use, each its part
    const double* mass = nullptr;   // kg, moving bodies
    const Mat3* inverse_inertia = nullptr;
    bool frozen = false;            // what moves by itself is at rest
    unsigned char* apart = nullptr; // Workspace::apart

    double angle_reference(int i) const { return angle[i] + (t - t_accepted) * angle_rate[i]; }
};

/// Where the generalised forces go: six per moving body, force (global), moment (body frame).
struct ForceSink {
    double* f;
    int moving;
    void add(int body, const Vec3& force, const Vec3& moment) const {
        if (body >= moving)
            return;
        double* g = f + 6 * static_cast<std::ptrdiff_t>(body);
        for (int i = 0; i < 3; ++i)
            g[i] += force[i];
        for (int i = 0; i < 3; ++i)
            g[3 + i] += moment[i];
    }
};

/// Block numbers of an ordered pair of bodies: id[i][j] for parts (r_a, t_a, r_b, t_b), -1: none.
struct PairBlocks {
    int id[4][4];
};

/// 3 x 3 blocks (column major) of C = -df/du and S = -df/dq + d(G^T lambda)/dq.
struct Linearisation {
    std::vector<double> C, S;
    /// Not zero: C + joined S is formed in C, and S stays empty; half the memory where the sum alone is
    /// wanted.
    double joined = 0;
    std::span<const PairBlocks> pairs;
    /// A friction state z' = source - decay z between two bodies. Eliminated, it adds
    /// -(df/dz) (dz'/du) / (s + decay) to C, s the leading coefficient of the integrator. All states are
    /// listed, always in the same order.
    struct StateCoupling {
        int state = 0;              // number in Evaluation::z
        int pair = 0, a = 0, b = 0; // blocks, bodies
        double decay = 0;           // 1/s
        Gradient<1> force;          // df/dz over (v_a, w_a, v_b, w_b); zero where nothing is pressed
        Gradient<1> rate;           // dz'/du
    };
    std::vector<StateCoupling> states;
    /// Forces that depend on a multiplier, beside G^T: -df/dlambda of a row over (v_a, w_a, v_b, w_b) of its
    /// bodies. Always the same rows in the same order.
    struct ReactionCoupling {
        int row;
        Gradient<1> force;
    };
    std::vector<ReactionCoupling> reactions;

    static void add(std::vector<double>& values, int block, const Mat3& m) {
        double* v = values.data() + 9 * static_cast<std::ptrdiff_t>(block);
        for (int i = 0; i < 9; ++i)
            v[i] += m.data()[i];
    }
    void add(std::vector<double>& values, int pair, CouplingMask mask, const BlockMatrix& m) const {
        const PairBlocks& blocks = pairs[pair];
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                if ((mask & coupling_bit(i, j)) && blocks.id[i][j] >= 0)
                    add(values, blocks.id[i][j], m.block[i][j]);
    }
    void add_damping(int pair, CouplingMask mask, const BlockMatrix& c) { add(C, pair, mask, c); }
    void add_stiffness(int pair, CouplingMask mask, const BlockMatrix& s) {
        if (joined == 0)
            return add(S, pair, mask, s);
        const PairBlocks& blocks = pairs[pair];
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j)
                if ((mask & coupling_bit(i, j)) && blocks.id[i][j] >= 0)
                    add(C, blocks.id[i][j], joined * s.block[i][j]);
    }
};

/// Collects which blocks exist while a System is compiled.
class BlockLayoutBuilder;

/// Stored energy (J) and powers (W) of a batch: dissipated >= 0 leaves the system, input enters it.
struct EnergyRates {
    double elastic = 0;
    double dissipated_power = 0;
    double input_power = 0;
    EnergyRates& operator+=(const EnergyRates& o) {
        elastic += o.elastic;
        dissipated_power += o.dissipated_power;
        input_power += o.input_power;
        return *this;
    }
};

/// Force and moment on the two bodies of an element (moments about the mass centres, body frames).
struct PairWrench {
    Vec3 force_a = Vec3::Zero(), moment_a = Vec3::Zero();
    Vec3 force_b = Vec3::Zero(), moment_b = Vec3::Zero();
    PairWrench& operator+=(const PairWrench& o) {
        force_a += o.force_a;
        moment_a += o.moment_a;
        force_b += o.force_b;
        moment_b += o.moment_b;
        return *this;
    }
};

/// A joint's force and moment on b about b's mass centre: force global, moment in b's frame.
struct Wrench {
    Vec3 force = Vec3::Zero();
    Vec3 moment = Vec3::Zero();
};

/// An element for a message.
struct ElementName {
    std::string name; // of a force; empty: an element of a joint
    int joint = -1;
    int a = 0, b = 0; // bodies
};

/// Elements that push: f += forces, C, S += their derivatives.
class ForceBatch {
  public:
    virtual ~ForceBatch() = default;
    virtual const char* kind() const = 0;
    virtual int size() const = 0;
    virtual void finish(BlockLayoutBuilder& layout) = 0; // declare blocks, sort into colours
    virtual void add_forces(const Evaluation& e, ForceSink f) const = 0;
    virtual void add_linearisation(const Evaluation& e, Linearisation& lin) const = 0;
    virtual EnergyRates energies(const Evaluation& e) const = 0;
    /// For joints made of this batch: their wrench on b, added to wrenches[joint].
    virtual void add_joint_wrenches(const Evaluation&, std::span<Wrench>) const {}

    /// The first element whose force, derivatives or energies are no finite numbers.
    virtual std::optional<ElementName> find_bad(const Evaluation&) const { return {}; }

    // Contacts: batches that have them
    /// Appends its channels once; the batch keeps the number of its first one.
    virtual void declare_contacts(int /*batch*/, std::vector<ContactChannel>&) {}
    virtual bool has_contacts() const { return false; }
    /// samples[channel] of all own channels: exact where something touches, else a negative bound may do.
    virtual void sample_contacts(const Evaluation&, std::span<ContactSample>) const {}
    /// One of them, exactly, by its number in the system; reads the motion of its two bodies only.
    virtual ContactSample sample_contact(const Evaluation&, int /*channel*/) const { return {}; }
    /// The same, but of depth, rate and share alone.
    virtual ContactSample approach(const Evaluation& e, int channel) const {
        return sample_contact(e, channel);
    }
    /// The first channel of each of its elements, appended.
    virtual void list_elements(std::vector<int>& /*first_channels*/) const {}
    /// marks[first channel of an element] = 1 where one of its channels may touch that did not, else 0.
    virtual void find_fresh(const Evaluation&, unsigned char* /*marks*/) const {}
    /// samples[channel] of the channels of one element, by its first channel.
    virtual void sample_element(const Evaluation&, int /*first*/, std::span<ContactSample>) const {}
    /// Depth at which the whole joint's law has stored an energy (J), or pushes with a force (N): divide by
    /// ContactSample::share first.
    virtual double depth_of_energy(int /*channel*/, double) const { return 0; }
    virtual double depth_of_force(int /*channel*/, double) const { return 0; }

    // Friction states: z' = source - decay z, source and decay functions of q and u alone
    virtual void declare_states(std::vector<double>& /*scales*/) {}
    virtual void state_terms(const Evaluation&, double* /*source*/, double* /*decay*/) const {}

    /// Doubles of Evaluation::scratch wanted; told where they begin.
    virtual std::size_t scratch_size() const { return 0; }
    virtual void place_scratch(std::size_t /*first*/) {}
};

/// Outputs of a constraint evaluation; null pointers are not wanted.
struct ConstraintSink {
    double* phi = nullptr;          // m
    double* rate = nullptr;         // G u + dPhi/dt, m
    double* rows = nullptr;         // G, 12 per row over (v_a, w_a, v_b, w_b)
    const double* lambda = nullptr; // f -= G^T lambda where given
    ForceSink f{nullptr, 0};
};

/// Constraint rows of one kind: Phi(q, t) = 0.
class ConstraintBatch {
  public:
    virtual ~ConstraintBatch() = default;
    virtual int size() const = 0;
    virtual void finish(BlockLayoutBuilder& layout) = 0;
    virtual void evaluate(const Evaluation& e, const ConstraintSink& sink) const = 0;
    /// rhs of G u' = gamma = -(d(G u)/dq u) - d2Phi/dt2.
    virtual void acceleration_rhs(const Evaluation& e, double* gamma) const = 0;
    /// S += d(G^T lambda)/dq.
    virtual void add_geometric(const Evaluation& e, const double* lambda, Linearisation& lin) const = 0;
    /// d(G u)/dq, 12 per row.
    virtual void rate_gradient(const Evaluation& e, double* rows) const = 0;
    /// dPhi/dt (the drives' own speed, negative), m.
    virtual void time_rate(const Evaluation& e, double* out) const = 0;
    /// Power the drives put in, W: lambda . dPhi/dt.
    virtual double drive_power(const Evaluation& e, const double* lambda) const = 0;
};

/// Elements sorted by colour. Element: members a, b (body numbers).
template <class Element> class ColouredElements {
  public:
    std::vector<Element>& items() { return items_; }
    const std::vector<Element>& items() const { return items_; }

    void colour(int moving);
    /// Colour c holds the items [starts[c], starts[c + 1]).
    std::span<const int> colour_starts() const { return start_; }

    /// f(element) for all, colour by colour; parallel inside a colour.
    template <class F> void for_each(int threads, F&& f) const {
        for (std::size_t c = 0; c + 1 < start_.size(); ++c)
            parallel_for(threads, start_[c], start_[c + 1], parallel_threshold,
                         [&](std::ptrdiff_t i) { f(items_[i]); });
    }

  private:
    static constexpr int parallel_threshold = 128;
    std::vector<Element> items_;
    std::vector<int> start_;
};

template <class Element> void ColouredElements<Element>::colour(int moving) {
    std::vector<std::vector<bool>> used(moving);
    std::vector<int> colour_of(items_.size());
    int colours = 0;
    const auto taken = [&](int body, int c) {
        return body < moving && c < static_cast<int>(used[body].size()) && used[body][c];
    };
    const auto take = [&](int body, int c) {
        if (body >= moving)
            return;
        if (c >= static_cast<int>(used[body].size()))
            used[body].resize(c + 1, false);
        used[body][c] = true;
    };
    for (std::size_t i = 0; i < items_.size(); ++i) {
        int c = 0;
        while (taken(items_[i].a, c) || taken(items_[i].b, c))
            ++c;
        take(items_[i].a, c);
        take(items_[i].b, c);
        colour_of[i] = c;
        colours = std::max(colours, c + 1);
    }
    start_.assign(colours + 1, 0);
    for (int c : colour_of)
        ++start_[c + 1];
    for (int c = 0; c < colours; ++c)
        start_[c + 1] += start_[c];
    std::vector<int> next(start_.begin(), start_.end() - 1), order(items_.size());
    for (std::size_t i = 0; i < items_.size(); ++i)
        order[next[colour_of[i]]++] = static_cast<int>(i);
    std::vector<Element> sorted;
    sorted.reserve(items_.size());
    for (int i : order)
        sorted.push_back(std::move(items_[i]));
    items_ = std::move(sorted);
}

} // namespace gudgeon

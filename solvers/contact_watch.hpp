// Physics takes part in accepting a step (Flores & Ambrosio 2010, AP 2.1): a contact that is new in a step
// must start shallow, else the step is rejected and shortened. What contacts remember, and their history,
// change here, on accepted steps only.
//
// Threshold of a new contact, in this order: the model's `onset` (depth, force or energy); else the depth at
// which the law has stored the share 20 rtol (at most 1 %) of the kinetic energy of the approach,
// 1/2 v^2 / (B M^-1 B^T) of the two bodies as if they were free; each strip counts alone, so N strips that
// start together may store N times as much. The force error of a step with an onset inside grows with the
// depth to the same power as that energy, so contacts begin as exactly as the rest of the motion.
#pragma once

#include "core/assembly.hpp"
#include "solvers/integrator.hpp"

#include <algorithm>
#include <functional>
#include <vector>

namespace gudgeon {

class ContactWatch {
  public:
    ContactWatch(const System& system, const IntegratorOptions& options);

    /// Nothing can touch.
    bool idle() const { return system_.contacts.empty(); }

    /// At a start: contacts that touch without a memory begin now, with their present speed. ws.motion set.
    void begin(State& state, Workspace& ws);

    /// Motion of one body at a time inside the step being tried.
    using MotionAt = std::function<void(double t, int body, BodyMotion& out)>;

    struct Verdict {
        bool ok = true;
        double end = 0; // s, where the next try should end
        int channel = -1;
        double depth = 0, threshold = 0;
    };
    /// Of a step [t0, t1] that passed the error test; ws.motion is that of t1.
    Verdict judge(double t0, double t1, Workspace& ws, const MotionAt& motion_at,
                  ContactEvent::Kind told = ContactEvent::Kind::rejected);

    /// The end that judge() would ask for, by a motion carried on beyond the last step, at t1 in ws.motion:
    /// spares the work of a step that would be rejected. t1 where nothing speaks against it. ws.motion and
    /// ws.samples are left anywhere. Only channels that may touch anew are sampled.
    double foresee(double t0, double t1, Workspace& ws, const MotionAt& carried_on);

    /// The step is accepted: memory into state and ws, history, events. ws as for judge().
    void commit(double t0, double t1, State& state, Workspace& ws);

    /// For a message: the contact that last had a step rejected since the last accepted one, else the one
    /// that presses most on a body (on any for body < 0); empty: none.
    std::string culprit(int body) const;

    /// What contacts remember inside the last accepted step: those that ended in it still do.
    void memory_inside(ContactMemory& out) const;

    /// Something began or ended in the last committed step: forces are others than before.
    bool changed() const { return changed_; }

    /// Step that follows the contacts begun in the last committed step, s; infinite if there were none.
    double suggested_step() const { return suggested_; }

    void visit(Archive& archive) {
        archive(starts_, before_, before_speed_, rejected_, changed_, suggested_);
        if (archive.reading())
            std::ranges::fill(before_apart_, 0);
    }

    /// Starts, ends and rejected starts are told to this function where set.
    std::function<void(const ContactEvent&)> on_contact;

  private:
    struct Crossing {
        int channel;
        double t, speed;
        double depth; // m or rad, there: 0 but for contacts that appear at a depth
        void visit(Archive& archive) { archive(channel, t, speed, depth); }
    };
    void weigh(double t0, double t1, int channel, bool start_wanted, double& guess, Workspace& ws,
               const MotionAt& motion_at, Verdict& verdict);
    void mark(int channel);
    void sample_marked(double t, Workspace& ws) const;
    void move_bodies(double t, int channel, Workspace& ws, const MotionAt& motion_at) const;
    Crossing crossing(double t0, double t1, int channel, double guess, Workspace& ws,
                      const MotionAt& motion_at);
    ContactEvent end_of_contact(double t0, double t1, int channel, Workspace& ws) const;
    double threshold(int channel, double speed, const ContactSample& sample) const;
    void begin_contact(const Crossing& start, const ContactSample& sample, State& state);
    void record(double t0, double t1, State& state, Workspace& ws);
    void tell(ContactEvent::Kind kind, int channel, double t, double depth, double speed) const;

    const System& system_;
    Onset onset_;
    double share_; // of the energy of approach
    std::vector<Crossing> starts_;
    struct Before {
        double depth = -1, rate = 0, force = 0; // as in ContactSample
        void visit(Archive& archive) { archive(depth, rate, force); }
    };
    void keep(const Workspace& ws);
    /// f(channel) of what may have changed with a step: not of elements apart at both its ends.
    template <class F> void for_elements(const Workspace& ws, F&& f) const;
    std::vector<Before> before_;              // at the last accepted step
    std::vector<unsigned char> before_apart_; // of each element, then: nothing of it remembers or is kept
    std::vector<int> deep_;                   // scratch of foresee()
    std::vector<unsigned char> fresh_;        // scratch, of elements as Workspace::apart
    struct JointNow {
        Vec3 resultant = Vec3::Zero();
        double moment = 0;
        bool touches = false;
    };
    std::vector<JointNow> now_; // scratch of record()
    VecX before_speed_;         // ContactMemory::start_speed before the last commit
    int rejected_ = -1;         // channel of the last verdict against a step since the last commit
    bool changed_ = false;
    double suggested_ = 0;
};

} // namespace gudgeon

// Cylinder in cylinder by strips (AP 25-42): the bearings of a scene as one flat array of strips.
//
// A strip carries 1/N of the joint's law, times the part of it that the journal covers. Where a tilted
// circle touches on two sides both points count, each with a memory of its own: a point keeps its memory by
// its place around the bearing. A joint whose bound says that it cannot touch evaluates no strip.
// Forces are found block by block of a joint's strips, blocks in parallel, then summed joint by joint in the
// order of the blocks: the same bits for any number of threads. All of a joint depends on the relative motion
// of its bodies: derivatives are summed over the strips in six columns and taken to the bodies once.
//
// Friction acts at every point that touches (friction_point.hpp), with three states for each memory.
//
// The edge of a journal on a strip that it covers in part pushes along its axis by the stored energy per
// length: cover times energy is a potential, so sliding in and out makes no energy.
//
// strip_batch.cpp: forces and derivatives; strip_samples.cpp: contact channels; strip_friction.cpp: friction
// states; strip_builder.cpp: from the model.
#pragma once

#include "contact/contact_batch.hpp"
#include "contact/contact_law.hpp"
#include "contact/gap_strip.hpp"
#include "core/system.hpp"

#include <limits>
#include <optional>

namespace gudgeon {

struct StripJoint : ContactElement {
    CylinderPair cylinders;
    int first_strip = 0, strips = 0; // in the flat arrays
    int first_block = 0, blocks = 0;
    double half_span = 0;                                            // m, |offset| of the outermost circle
    double least_radius = 0;                                         // m
    double width = 0;                                                // m, of a strip
    double journal_length = std::numeric_limits<double>::infinity(); // m
    Vec3 reference = Vec3::UnitX(), across = Vec3::UnitY(); // across the bearing's axis, in a: place 0, pi/2
};

class StripBatch final : public ForceBatch {
  public:
    /// offsets (m, along the bearing's axis) and radii (m) of the strips of x.
    void add(StripJoint x, const std::vector<double>& offsets, const std::vector<double>& radii);

    const char* kind() const override { return "strips"; }
    int size() const override { return static_cast<int>(joints_.items().size()); }
    void finish(BlockLayoutBuilder& layout) override;
    void add_forces(const Evaluation& e, ForceSink f) const override;
    void add_linearisation(const Evaluation& e, Linearisation& lin) const override;
    EnergyRates energies(const Evaluation& e) const override;
    void add_joint_wrenches(const Evaluation& e, std::span<Wrench> wrenches) const override;

    bool has_contacts() const override { return true; }
    void declare_contacts(int batch, std::vector<ContactChannel>& channels) override;
    void sample_contacts(const Evaluation& e, std::span<ContactSample> samples) const override;
    ContactSample sample_contact(const Evaluation& e, int channel) const override;
    ContactSample approach(const Evaluation& e, int channel) const override;
    void list_elements(std::vector<int>& first_channels) const override;
    void find_fresh(const Evaluation& e, unsigned char* marks) const override;
    void sample_element(const Evaluation& e, int first, std::span<ContactSample> samples) const override;
    double depth_of_energy(int channel, double energy) const override;
    double depth_of_force(int channel, double force) const override;

    void declare_states(std::vector<double>& scales) override;
    void state_terms(const Evaluation& e, double* source, double* decay) const override;

    std::optional<ElementName> find_bad(const Evaluation& e) const override;
    std::size_t scratch_size() const override;
    void place_scratch(std::size_t first) override { scratch_ = first; }

    /// Strips of the batch, and those whose joint the bound does not exclude.
    std::size_t strips() const { return offset_.size(); }
    std::size_t strips_in_reach(const Evaluation& e) const;

  private:
    struct Pose;
    struct Touch;  // one point of a strip
    struct Found;  // the points of a strip with the memories they own
    struct Block { // strips [first, last) of a joint
        int joint, first, last;
    };
    void find(const Evaluation& e, const StripJoint& x, const Pose& pose, const StripRow& row, int i,
              double above, Found& out) const;
    template <class F>
    void touch(const Evaluation& e, const StripJoint& x, const Pose& pose, int strip, const StripPoint& point,
               int memory, F&& f) const;
    template <class F>
    void for_touches(const Evaluation& e, const StripJoint& x, const Pose& pose, int first, int last,
                     F&& f) const;
    template <class F>
    void for_touches(const Evaluation& e, const StripJoint& x, const Pose& pose, F&& f) const {
        for_touches(e, x, pose, x.first_strip, x.first_strip + x.strips, f);
    }
    template <class F> void in_parallel(const Evaluation& e, int count, F&& f) const;
    PointFriction friction_of(const Evaluation& e, const StripJoint& x, const Touch& touch) const;
    void add_state_couplings(const Evaluation& e, Linearisation& lin) const;
    std::optional<CylinderPose> near_pose(const Evaluation& e, const StripJoint& x) const;
    std::optional<Pose> in_reach(const Evaluation& e, const StripJoint& x) const;
    Vec6 block_wrench(const Evaluation& e, const Block& block) const;
    Vec6 joint_wrench(const Evaluation& e, const StripJoint& x) const;
    void add_wrench(const Evaluation& e, const StripJoint& x, const Vec6& wrench, ForceSink f) const;
    void add_touch(const Evaluation& e, const StripJoint& x, const Pose& pose, const Touch& touch,
                   RelativeWrench& sum) const;
    EnergyRates joint_energies(const Evaluation& e, const StripJoint& x) const;
    void blank_samples(const StripJoint& x, ContactSample* out) const;
    void sample_joint(const Evaluation& e, const StripJoint& x, std::span<ContactSample> samples) const;
    bool may_be_fresh(const Evaluation& e, const StripJoint& x) const;
    void strip_samples(const Evaluation& e, const StripJoint& x, const Pose& pose, const StripRow& row, int i,
                       bool exactly, Found& found, ContactSample* out) const;
    const StripJoint& joint_of(int channel) const;

    ColouredElements<StripJoint> joints_;
    std::vector<double> offset_, radius_; // per strip
    std::vector<Block> blocks_;
    std::size_t scratch_ = 0;
    int first_channel_ = 0;
    int states_ = 0; // contacts with friction states
    std::vector<int> joint_of_channel_;
};

ForceBatchBuilder strip_builder(); // "model": "strips", the default of cylinders

} // namespace gudgeon

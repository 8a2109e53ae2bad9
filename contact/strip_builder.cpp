#include "contact/clearance.hpp"
#include "contact/strip_batch.hpp"

namespace gudgeon {

namespace {

StripJoint strip_joint(const CompileContext& context, int j) {
    const JointSide side = bearing_side(context, j);
    const Clearance& clearance = *context.model.joints[j].clearance;
    StripJoint x;
    place(side, x);
    x.law = radial_law(context, j);
    x.friction = contact_friction(context, j);
    x.cylinders = {side.a.point, side.a.axes.col(2), side.b.point, side.b.axes.col(2),
                   contact_geometry(clearance).journal_radius};
    x.reference = side.a.axes.col(0);
    x.across = side.a.axes.col(1);
    if (clearance.journal_length)
        x.journal_length = *clearance.journal_length;
    return x;
}

std::unique_ptr<ForceBatch> build(const CompileContext& context) {
    auto batch = std::make_unique<StripBatch>();
    for (int j = 0; j < static_cast<int>(context.model.joints.size()); ++j) {
        const Joint& joint = context.model.joints[j];
        if (!uses_model(joint, "strips"))
            continue;
        const Clearance& clearance = *joint.clearance;
        const int n =
            clearance.profile.empty() ? clearance.strips : static_cast<int>(clearance.profile.size());
        StripJoint x = strip_joint(context, j);
        x.width = clearance.length.value_or(0) / n;
        std::vector<double> offsets, radii;
        for (int k = 1; k <= n; ++k) { // b_k = (N - 2 k + 1)/2 l/N
            offsets.push_back(0.5 * (n - 2 * k + 1) * x.width);
            radii.push_back(clearance.profile.empty() ? *clearance.radius : clearance.profile[k - 1]);
        }
        batch->add(std::move(x), offsets, radii);
    }
    return batch;
}

} // namespace

ForceBatchBuilder strip_builder() { return build; }

} // namespace gudgeon

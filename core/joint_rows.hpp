// Which constraint rows and coordinates each joint kind is made of.
#pragma once

#include "core/constraints.hpp"
#include "core/system.hpp"

namespace gudgeon {

/// Batches being filled while a model is compiled, one per kernel.
struct ConstraintBatches {
    ConstraintBatchOf<CoincidentKernel> coincident;
    ConstraintBatchOf<DisplacementKernel> displacement;
    ConstraintBatchOf<DrivenDisplacementKernel> driven_displacement;
    ConstraintBatchOf<AlignmentKernel> alignment;
    ConstraintBatchOf<DistanceKernel> distance;
    ConstraintBatchOf<DrivenAngleKernel> driven_angle;
};

/// Appends rows of a perfect joint (record: anchors set; first_row, rows and coordinates are filled) to
/// the system and the batches.
void add_joint_rows(const Joint& joint, int joint_index, System& system, ConstraintBatches& batches);

/// Coordinates of the joint as outputs; angles get a number in System::angles.
void add_joint_coordinates(const Joint& joint, JointRecord& record, System& system);

} // namespace gudgeon

// What the batches of joints with clearance share when a model is compiled.
#pragma once

#include "contact/friction_law.hpp"
#include "contact/normal_law.hpp"
#include "core/force_batch.hpp"
#include "core/joint_motions.hpp"
#include "core/system.hpp"

namespace gudgeon {

/// The two sides of a joint as a contact sees them: a the bearing, socket or guide, b the journal.
struct JointSide {
    int joint;
    Anchor a, b;
    bool swapped; // the bearing sits on the joint's second body
};
JointSide plain_side(const CompileContext& context, int joint);   // as the joint names its bodies
JointSide bearing_side(const CompileContext& context, int joint); // after "bearing"

/// An element between the two sides.
void place(const JointSide& side, ForceElement& element);

/// A cylinder in a bearing whose radial motion is held by contact after this Clearance::model.
bool uses_model(const Joint& joint, std::string_view model);

/// The motion belongs to the joint and contact holds it after a free play.
bool held_by_contact(const Joint& joint, Motion motion);

/// Radii, length and clearance of a joint's bearing, as its laws want them.
ContactGeometry contact_geometry(const Clearance& clearance);

/// Compiles a law; what is wrong with it becomes a ModelError at the joint's member.
NormalLaw joint_law(const CompileContext& context, int joint, const ContactLaw& law,
                    const ContactGeometry& geometry, const std::string& member);
NormalLaw radial_law(const CompileContext& context, int joint);
/// Where end faces or a key rub, m: the friction's radius, else that of the bearing (a profile's mean); 0:
/// unknown.
double rubbing_radius(const Clearance& clearance);
/// Friction of the bearing's contacts, where it is named.
std::optional<FrictionLaw> contact_friction(const CompileContext& context, int joint);
NormalLaw axial_law(const CompileContext& context, int joint);
NormalLaw rotation_law(const CompileContext& context, int joint);

} // namespace gudgeon

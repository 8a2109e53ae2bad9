#include "core/joint_kinds.hpp"
#include "core/joint_motions.hpp"
#include "core/validate_laws.hpp"
#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

constexpr std::array<Motion, 4> all_motions{Motion::radial, Motion::axial, Motion::misalignment,
                                            Motion::rotation};

const char* member_of(Motion motion) { return motion_names[static_cast<std::size_t>(motion)].data(); }

/// Place of the word that holds a motion.
std::string word_of(const Joint& joint, Motion motion) {
    return joint.motions[static_cast<std::size_t>(motion)] ? fmt::format("/fidelity/{}", member_of(motion))
                                                           : "/fidelity";
}

void check_words(const Checker& check, const std::string& at, const Joint& joint) {
    const std::string_view kind = joint_kind(joint.kind).name;
    for (const Motion motion : all_motions) {
        const std::string pointer = at + word_of(joint, motion);
        if (joint.motions[static_cast<std::size_t>(motion)] && !holds_motion(joint.kind, motion))
            check.refuse(pointer, fmt::format("a {} joint holds no motion '{}'", kind, member_of(motion)),
                         listed(held_motions(joint.kind)));
        if (joint.holds(motion) == Fidelity::clearance && !may_have_clearance(joint.kind))
            check.refuse(pointer, fmt::format("clearance in a {} joint", kind),
                         "clearance in revolute, translation, cylindrical, spherical, universal joints");
    }
    if (joint.fidelity == Fidelity::free)
        check.refuse(at + "/fidelity", "a joint that holds nothing", "perfect, bushing, clearance");
    // Misalignment of a cylinder shows in the contact along the bearing only.
    if (joint.kind != JointKind::universal && holds_motion(joint.kind, Motion::misalignment) &&
        joint.holds(Motion::misalignment) == Fidelity::clearance &&
        joint.holds(Motion::radial) != Fidelity::clearance)
        check.refuse(at + word_of(joint, Motion::misalignment),
                     "clearance of the misalignment without radial clearance",
                     "clearance where 'radial' is clearance too");
}

/// The data of a clearance. Where the joint holds nothing by clearance they wait for a change of the
/// fidelity: then they may be incomplete, and fit any motion that the kind holds.
class ClearanceCheck {
  public:
    ClearanceCheck(const Checker& check, const std::string& at, const Joint& joint)
        : check_(check), joint_(joint), data_(*joint.clearance), at_(at + "/clearance"),
          used_(holds_any(joint, Fidelity::clearance)),
          ball_(joint.kind == JointKind::spherical || joint.kind == JointKind::universal),
          slot_(data_.model == "slot") {}

    void run() const {
        if (!may_have_clearance(joint_.kind))
            check_.refuse(at_, fmt::format("clearance in a {} joint", kind()),
                          "clearance in revolute, translation, cylindrical, spherical, universal joints");
        model();
        plays();
        sizes();
        profile();
        section();
        laws();
        if (data_.friction)
            friction(at_ + "/friction", *data_.friction);
    }

  private:
    std::string_view kind() const { return joint_kind(joint_.kind).name; }
    bool by_clearance(Motion motion) const {
        return holds_motion(joint_.kind, motion) && (!used_ || joint_.holds(motion) == Fidelity::clearance);
    }
    /// Of the key or of a universal joint's right angle.
    bool turns() const {
        return ball_ ? joint_.kind == JointKind::universal && by_clearance(Motion::misalignment)
                     : by_clearance(Motion::rotation) && !slot_;
    }
    void need(const char* member, bool given, const std::string& why) const {
        if (used_ && !given)
            check_.refuse(at_ + '/' + member, fmt::format("'{}' is missing", member),
                          fmt::format("'{}' is required {}", member, why));
    }
    void no_use(const char* member, bool given, const std::string& where) const {
        if (given)
            check_.refuse(at_ + '/' + member, fmt::format("'{}' {}", member, where), "leave it out");
    }

    void model() const {
        static const std::vector<std::string> known{"strips", "planar", "two-end", "slot"};
        const std::string& name = data_.model;
        if (std::ranges::find(known, name) == known.end())
            check_.refuse(at_ + "/model", fmt::format("unknown model '{}'", name),
                          suggestion(name, known) + listed(known));
        if (ball_ && name != "strips")
            check_.refuse(at_ + "/model", fmt::format("the model '{}' of a ball in a socket", name),
                          "no model in spherical and universal joints");
        if (!slot_)
            return;
        if (joint_.kind != JointKind::translation)
            check_.refuse(at_ + "/model", fmt::format("a slot in a {} joint", kind()),
                          "a slot in translation joints");
        if (!by_clearance(Motion::radial))
            check_.refuse(at_ + "/model", "a slot without radial clearance",
                          "a slot where 'radial' is held by clearance");
    }

    void plays() const {
        const auto not_negative = [&](const char* member, const std::optional<double>& value) {
            if (value)
                check_.not_negative(at_, member, *value);
        };
        not_negative("radial", data_.radial);
        not_negative("axial", data_.axial);
        not_negative("rotation", data_.rotation);
        not_negative("misalignment", data_.misalignment);
        const auto other = [&](Motion motion) {
            return holds_motion(joint_.kind, motion)
                       ? fmt::format("where '{}' is not held by clearance", member_of(motion))
                       : fmt::format("in a {} joint", kind());
        };
        no_use("axial", data_.axial && !by_clearance(Motion::axial), other(Motion::axial));
        no_use("rotation", data_.rotation && slot_, "in a slot, whose four sides hold it");
        no_use("rotation", data_.rotation && !by_clearance(Motion::rotation), other(Motion::rotation));
        no_use("misalignment", data_.misalignment && !ball_,
               "where it comes out of the contact along the bearing");
        no_use("misalignment", data_.misalignment && !by_clearance(Motion::misalignment),
               other(Motion::misalignment));
        if (by_clearance(Motion::radial))
            need("radial", data_.radial.has_value(), "where 'radial' is held by clearance");
        if (by_clearance(Motion::axial))
            need("axial", data_.axial || data_.radial, "where 'axial' is held by clearance");
        if (by_clearance(Motion::rotation) && !slot_)
            need("rotation", data_.rotation.has_value(), "where 'rotation' is held by clearance");
        if (ball_ && by_clearance(Motion::misalignment))
            need("misalignment", data_.misalignment.has_value(), "where it is held by clearance");
    }

    void sizes() const {
        if (data_.radius)
            check_.positive(at_, "radius", *data_.radius);
        if (data_.length)
            check_.positive(at_, "length", *data_.length);
        if (data_.journal_length)
            check_.positive(at_, "journal_length", *data_.journal_length);
        if (data_.strips < 1)
            check_.refuse(at_ + "/strips", fmt::format("{} strips", data_.strips), "1 or more");
        if (data_.radius && data_.radial && *data_.radius <= *data_.radial)
            check_.refuse(
                at_ + "/radius",
                fmt::format("the radius {} does not exceed the clearance {}", *data_.radius, *data_.radial),
                "more than 'radial'");
        if (ball_) {
            no_use("length", data_.length.has_value(), "of a ball in a socket");
            no_use("journal_length", data_.journal_length.has_value(), "of a ball in a socket");
        } else if (by_clearance(Motion::radial) && data_.model != "planar") {
            const std::string why = fmt::format("by the model '{}'", data_.model);
            if (!slot_)
                need("radius", data_.radius || !data_.profile.empty(), why);
            need("length", data_.length.has_value(), why);
        }
    }

    void profile() const {
        const auto& radii = data_.profile;
        if (radii.empty())
            return;
        if (ball_ || data_.model != "strips")
            no_use("profile", true,
                   ball_ ? "of a ball in a socket" : fmt::format("in the model '{}'", data_.model));
        no_use("profile", data_.radius.has_value(), "beside 'radius'");
        if (radii.size() != static_cast<std::size_t>(data_.strips))
            check_.refuse(at_ + "/profile", fmt::format("{} radii of {} strips", radii.size(), data_.strips),
                          "a radius for each strip");
        for (std::size_t i = 0; i < radii.size(); ++i) {
            check_.positive(at_ + "/profile", std::to_string(i).c_str(), radii[i]);
            if (data_.radial && radii[i] <= *data_.radial)
                check_.refuse(
                    fmt::format("{}/profile/{}", at_, i),
                    fmt::format("the radius {} does not exceed the clearance {}", radii[i], *data_.radial),
                    "more than 'radial'");
        }
    }

    void section() const {
        if (!slot_) {
            no_use("section", data_.section.has_value(), "without the model 'slot'");
            return;
        }
        need("section", data_.section.has_value(), "by the model 'slot'");
        no_use("radius", data_.radius.has_value(), "of a slot");
        for (std::size_t i = 0; data_.section && i < 2; ++i) {
            const double size = (*data_.section)[i];
            check_.positive(at_ + "/section", i == 0 ? "0" : "1", size);
            if (data_.radial && size <= 2 * *data_.radial)
                check_.refuse(
                    fmt::format("{}/section/{}", at_, i),
                    fmt::format("{} leaves no slider between clearances of {}", size, *data_.radial),
                    "more than twice 'radial'");
        }
    }

    void laws() const {
        check_law(check_, at_ + "/law", data_.law,
                  {slot_   ? "a slot"
                   : ball_ ? "a ball in a socket"
                           : "a bearing",
                   !slot_, !slot_ && !ball_});
        geometry_of(data_.law);
        other_law("axial_law", data_.axial_law, by_clearance(Motion::axial), "end faces");
        other_law("rotation_law", data_.rotation_law, turns(), ball_ ? "a right angle" : "a key");
    }

    /// What a law needs of the bearing. The hard part of a blend touches where the bushing ends: its
    /// clearance is larger by the thickness.
    void geometry_of(const ContactLaw& law, double thickness = 0) const {
        if (!law.hard.empty())
            geometry_of(law.hard[0], law.thickness.value_or(0));
        if (!by_clearance(Motion::radial))
            return;
        if (law.kind == "cylinder")
            cylinder_clearance(thickness);
        if (!law.materials)
            return;
        const std::string why = "for a stiffness from materials";
        if (law.kind == "cylinder")
            need("length", data_.length.has_value(), why);
        else
            need("radius", data_.radius || !data_.profile.empty(), why);
        if (data_.radial && *data_.radial + thickness == 0)
            check_.refuse(at_ + "/radial", "the clearance 0 with a stiffness from materials",
                          "more than 0, or 'stiffness' in the law");
    }

    void cylinder_clearance(double thickness) const {
        constexpr double least = 5e-6, most = 1e-2, round_off = 1e-12; // m, AP 47-48
        if (!data_.radial)
            return;
        const double clearance = *data_.radial + thickness;
        if (clearance < least * (1 - round_off) || clearance > most * (1 + round_off))
            check_.refuse(at_ + "/radial", fmt::format("the clearance {} with the law 'cylinder'", clearance),
                          "5e-6 to 1e-2 m, or another law");
    }

    void other_law(const char* member, const std::optional<ContactLaw>& law, bool used,
                   const char* place) const {
        if (law && !used)
            check_.refuse(at_ + '/' + member, fmt::format("'{}' without such a clearance", member),
                          "leave it out");
        if (law)
            check_law(check_, at_ + '/' + member, *law, {place});
        else if (used)
            need(member, !from_materials(data_.law), "beside a stiffness from materials");
    }

    static bool from_materials(const ContactLaw& law) {
        return law.materials || (!law.hard.empty() && from_materials(law.hard[0]));
    }

    void friction(const std::string& at, const Friction& friction) const {
        check_friction_law(check_, at, friction);
        const bool faces = by_clearance(Motion::axial), key = !ball_ && turns();
        if (!faces && !key)
            refuse_radius_and_coordinate(check_, at, friction, "a contact without end faces or key");
        refuse_coordinate_and_force(check_, at, friction, "a contact");
        if (ball_ || data_.model == "planar")
            need("radius", data_.radius.has_value(), "where the contact rubs");
        if ((faces || key) && used_ && !friction.radius && !data_.radius && data_.profile.empty())
            check_.refuse(at + "/radius", "'radius' is missing",
                          fmt::format("the radius at which {} here or as that of the bearing",
                                      faces ? "the end faces rub," : "the key rubs,"));
    }

    const Checker& check_;
    const Joint& joint_;
    const Clearance& data_;
    std::string at_;
    bool used_, ball_, slot_;
};

} // namespace

void check_contacts(const Checker& check, const std::string& at, const Joint& joint) {
    check_words(check, at, joint);
    if (joint.clearance)
        ClearanceCheck(check, at, joint).run();
    else if (holds_any(joint, Fidelity::clearance))
        check.refuse(at + "/clearance", "the data of the clearance are missing",
                     "'clearance' is required here");
    check_stops(check, at, joint);
    check_joint_friction(check, at, joint);
}

} // namespace gudgeon

// Shared by the checks of validate(): look-ups, simple rules, refusal with place.
#pragma once

#include "core/model.hpp"

#include <string_view>
#include <unordered_map>

namespace gudgeon {

class Checker {
  public:
    explicit Checker(const Model& model);

    const Model& model() const { return model_; }
    [[noreturn]] void refuse(const std::string& pointer, const std::string& problem,
                             const std::string& allowed) const;

    // Rules; the member's name is appended to the pointer only when refused.
    void finite(const std::string& at, const char* member, double value) const;
    void finite(const std::string& at, const std::string& member, const Vec3& value) const;
    void not_negative(const std::string& at, const char* member, double value) const;
    void positive(const std::string& at, const char* member, double value) const;
    void direction(const std::string& pointer, const Vec3& value) const;
    void table(const std::string& at, const char* member, const Table& table) const;
    void function(const std::string& pointer, const TimeFunction& f) const;

    // Look-ups
    void body_exists(const std::string& pointer, const std::string& name) const;
    /// An existing body that is neither fixed nor ground.
    void body_moves(const std::string& at, const std::string& name) const;
    /// Both exist, differ, and at least one of them moves.
    void body_pair(const std::string& at, const std::array<std::string, 2>& names) const;
    const Joint* find_joint(const std::string& name) const;
    /// nullptr: ground.
    const Body* find_body(const std::string& name) const;
    std::string body_names() const;

    Vec3 global_point(const std::string& body, bool body_frame, const Vec3& point) const;
    Vec3 global_direction(const std::string& body, bool body_frame, const Vec3& v) const;
    /// Points of both sides lie apart in the pose as given.
    void points_apart(const std::string& at, const std::array<std::string, 2>& bodies, bool body_frame,
                      const std::array<Vec3, 2>& points) const;

  private:
    bool moves(const std::string& name) const;

    const Model& model_;
    std::unordered_map<std::string_view, const Body*> bodies_; // the first of each name
    std::unordered_map<std::string_view, const Joint*> joints_;
};

void check_joints(const Checker& check);
void check_forces(const Checker& check);
void check_beams(const Checker& check);
/// Fidelity of the motions, clearance, stops and friction of a joint.
void check_contacts(const Checker& check, const std::string& at, const Joint& joint);
void check_stops(const Checker& check, const std::string& at, const Joint& joint);
void check_joint_friction(const Checker& check, const std::string& at, const Joint& joint);

std::string shown(const Vec3& v);

} // namespace gudgeon

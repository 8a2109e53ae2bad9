// Named output columns and how to read them from a sample.
//
// <body>.x .y .z .e0 .. .e3 .vx .vy .vz .wx .wy .wz .ax .ay .az .alx .aly .alz (angular acceleration, body
// frame); <joint>.<coordinate>, .fx .. .mz (a on b at b's point, global axes), .fjx .. .mjz (joint frame
// of a); where something can touch: <joint>.penetration .normal_force .friction_force .strips .dissipated;
// <marker>.x .y .z .vx .vy .vz; energy.kinetic .potential .elastic .dissipated .input .balance.
#pragma once

#include "core/sample.hpp"

#include <span>
#include <string>
#include <vector>

namespace gudgeon {

/// Fixed choice of columns of one system.
class Channels {
  public:
    /// All columns, or those that match one of the globs (* and ?), in the order of the full list.
    /// Throws std::invalid_argument naming a glob that matches nothing.
    Channels(const System& system, const std::vector<std::string>& globs = {});

    /// Number of columns there would be without globs.
    static std::size_t count_all(const System& system);

    const std::vector<std::string>& names() const { return names_; }
    /// SI unit of each column ("m", "rad", "N", ...; "1" for Euler parameters).
    const std::vector<std::string>& units() const { return units_; }
    /// One value per name.
    void read(const Sample& sample, std::span<double> values) const;

  private:
    struct Source {
        enum class Kind { body, joint_coordinate, joint_wrench, contact, marker, energy } kind;
        int index;     // body, joint, marker
        int component; // within the kind's fixed list
    };
    void add(const std::vector<std::string>& globs, std::vector<bool>& used, std::string name,
             std::string unit, Source source);

    const System* system_;
    std::vector<std::string> names_, units_;
    std::vector<Source> sources_;
};

} // namespace gudgeon

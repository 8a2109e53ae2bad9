// Mechanisms of any size on their way.
#pragma once

#include "core/assembly.hpp"
#include "kernels.hpp"

#include <array>
#include <complex>
#include <memory>
#include <span>
#include <vector>

namespace gudgeon::kernels {

/// chain or suspension-chain of about so many bodies.
Model sized_model(const std::string& mechanism, int bodies);
const std::vector<std::string>& scene_mechanisms();

/// After twenty steps of gear at 1e-4; evaluated, linearised, and its matrices at two step lengths, as gear
/// and radau have.
struct Scene {
    System system;
    State state;
    Workspace ws;
    SaddleMatrix saddle;
    std::array<std::vector<double>, 2> values;
    std::array<std::vector<std::complex<double>>, 2> complex_values;
    VecX rhs; // two columns

    Scene(const std::string& mechanism, const Setup& setup);
    std::span<double> right_hand_sides(int columns) {
        return {rhs.data(), static_cast<std::size_t>(columns * saddle.pattern().cols)};
    }
};
using ScenePointer = std::shared_ptr<Scene>;

/// The one that someone still holds, where there is one of this kind; else a new one.
ScenePointer scene(const std::string& mechanism, const Setup& setup);

/// Calls add(suffix, source) for each mechanism: "/chain" and a function from a Setup to its scene.
template <class Add> void for_scenes(Add&& add) {
    for (const std::string& mechanism : scene_mechanisms())
        add("/" + mechanism, [mechanism](const Setup& setup) { return scene(mechanism, setup); });
}
using SceneSource = std::function<ScenePointer(const Setup&)>;

inline constexpr int scene_bodies = 50; // counted

} // namespace gudgeon::kernels

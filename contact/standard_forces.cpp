#include "contact/standard_forces.hpp"

#include "contact/bushing.hpp"
#include "contact/friction_batch.hpp"
#include "contact/limits.hpp"
#include "contact/point_batches.hpp"
#include "contact/strip_batch.hpp"

namespace gudgeon {

std::vector<ForceBatchBuilder> standard_force_builders() {
    std::vector<ForceBatchBuilder> builders = core_force_builders();
    builders.push_back(bushing_builder());
    builders.push_back(tabulated_bushing_builder());
    builders.push_back(sphere_builder());
    builders.push_back(planar_builder());
    builders.push_back(two_end_builder());
    builders.push_back(slot_builder());
    builders.push_back(strip_builder());
    builders.push_back(displacement_limit_builder());
    builders.push_back(angle_limit_builder());
    builders.push_back(key_limit_builder());
    builders.push_back(cosine_limit_builder());
    builders.push_back(swing_limit_builder());
    builders.push_back(displacement_friction_builder());
    builders.push_back(angle_friction_builder());
    return builders;
}

} // namespace gudgeon

#include "contact/standard_forces.hpp"

#include "contact/bushing.hpp"

namespace gudgeon {

std::vector<ForceBatchBuilder> standard_force_builders() {
    std::vector<ForceBatchBuilder> builders = core_force_builders();
    builders.push_back(bushing_builder());
    builders.push_back(tabulated_bushing_builder());
    return builders;
}

} // namespace gudgeon

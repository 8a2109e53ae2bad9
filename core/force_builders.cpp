#include "core/forces_applied.hpp"
#include "core/forces_spring_damper.hpp"
#include "core/forces_torsion_spring.hpp"
#include "core/forces_tyre.hpp"

namespace gudgeon {

std::vector<ForceBatchBuilder> core_force_builders() {
    return {build_spring_dampers, build_torsion_springs,       build_tyres<true>,
            build_tyres<false>,   build_applied_forces<false>, build_applied_forces<true>};
}

} // namespace gudgeon

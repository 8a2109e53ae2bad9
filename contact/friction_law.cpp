#include "contact/friction_law.hpp"

namespace gudgeon {

FrictionLaw compile_friction(const Friction& friction) {
    FrictionLaw law;
    law.kinetic = law.statics = friction.kinetic;
    law.speed = friction.speed.value_or(law.speed);
    if (friction.kind == "coulomb")
        return law;
    if (friction.kind == "coulomb-smooth") {
        law.kind = FrictionKind::coulomb_smooth;
        return law;
    }
    law.kind = FrictionKind::bristles;
    law.sigma0 = friction.sigma0.value_or(0);
    if (friction.kind == "lugre") {
        law.statics = friction.statics.value_or(friction.kinetic);
        law.exponent = friction.exponent;
        law.sigma1 = friction.sigma1;
        law.sigma2 = friction.sigma2;
    }
    return law;
}

} // namespace gudgeon

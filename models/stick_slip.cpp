// A block held by a spring on a moving belt: stick-slip.
#include "models/builders.hpp"

#include <cmath>

namespace gudgeon {

namespace {

Model build_stick_slip(const ParameterValues&) {
    Model model;
    const Vec3 at_block(0, 0, 0.05), at_belt(0, 0, -0.05), contact = Vec3::Zero();
    model.bodies = {make_body("block", 1, Vec3::Constant(1e-3), at_block),
                    make_body("belt", 1, Vec3::Constant(1e-3), at_belt)};
    model.bodies[1].velocity = {0.1, 0, 0};
    model.joints = {
        make_joint("guide", JointKind::translation, "ground", "block", at_block, Vec3::UnitX()),
        make_joint("track", JointKind::translation, "ground", "belt", at_belt, Vec3::UnitX()),
    };
    model.joints[1].drives["slide"] = RampFunction{0, 0.1, 0};

    SpringDamper spring;
    spring.name = "spring";
    spring.bodies = {"ground", "block"};
    spring.points = {at_block - 10 * Vec3::UnitX(), at_block};
    spring.stiffness = 2;
    spring.free_length = 10;
    FrictionForce friction;
    friction.name = "friction";
    friction.bodies = {"belt", "block"};
    friction.points = {contact, contact};
    friction.axis = Vec3::UnitX();
    friction.friction.kind = "lugre";
    friction.friction.kinetic = 1;
    friction.friction.statics = 1.5;
    friction.friction.speed = 1e-3;
    friction.friction.sigma0 = 1e5;
    friction.friction.sigma1 = std::sqrt(1e5);
    friction.friction.sigma2 = 0.4;
    friction.friction.normal_force = 1;
    model.forces = {spring, friction};
    return model;
}

} // namespace

Mechanism stick_slip() {
    return {"stick-slip",
            "block of 1 kg on a spring, dragged by a belt at 0.1 m/s through LuGre friction (Augustynek & "
            "Urbas 2018, 14-15)",
            {},
            40,
            0.01,
            &build_stick_slip};
}

} // namespace gudgeon

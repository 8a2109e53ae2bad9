#include "contact/friction_law.hpp"
#include "contact/normal_law.hpp"
#include "kernels.hpp"
#include "models/builders.hpp"

#include <memory>

namespace gudgeon::kernels {

namespace {

constexpr int points = 1000;

ContactLaw law_of(const std::string& kind) {
    ContactLaw law;
    if (kind == "cylinder")
        law = steel_cylinders(0.8);
    else
        law.kind = kind;
    if (kind == "tabulated")
        law.table = {{0, 1e-4, 3e-4, 1e-3}, {0, 20, 50, 400}};
    else if (kind != "cylinder")
        law.stiffness = 1e5;
    if (kind == "linear" || kind == "tabulated" || kind == "blend")
        law.damping = 30;
    else if (kind != "hertz")
        law.restitution = 0.8;
    if (kind == "kelvin-voigt")
        law.speed = 0.1;
    if (kind == "blend") {
        law.thickness = 4e-4;
        law.width = 2e-4;
        law.hard = {law_of("lankarani-nikravesh")};
    }
    return law;
}

counted::Work normal_law(const std::string& kind) {
    ContactGeometry geometry{
        .bearing_radius = 0.0101, .journal_radius = 0.01, .length = 0.04, .clearance = 1e-4};
    const auto law = std::make_shared<NormalLaw>(compile_law(law_of(kind), geometry));
    const auto sum = std::make_shared<double>(0);
    return {[law, sum] { // depths up to 1 mm, pressed in and let go, one in ten apart
                for (int i = 0; i < points; ++i) {
                    const double depth = 1e-6 * (i - points / 10), rate = i % 2 ? 0.05 : -0.03;
                    const NormalForce f = law->evaluate({depth, rate, 0.1});
                    *sum += f.force + f.by_depth + f.by_rate + f.energy;
                }
            },
            {},
            {}};
}

counted::Work friction_law(const std::string& kind) {
    Friction friction;
    friction.kind = kind;
    friction.kinetic = 0.1;
    if (kind != "dahl")
        friction.speed = 1e-3;
    if (kind == "lugre" || kind == "dahl")
        friction.sigma0 = 1e5;
    if (kind == "lugre") {
        friction.statics = 0.15;
        friction.sigma1 = 300;
    }
    const auto law = std::make_shared<FrictionLaw>(compile_friction(friction));
    const auto sum = std::make_shared<double>(0);
    return {[law, sum] { // slip up to twice the threshold
                for (int i = 0; i < points; ++i) {
                    const Vec3 slip(2e-6 * i, 1e-6 * i, 0), bristles(1e-7, -2e-7, 0);
                    const FrictionValue<3> f = evaluate_friction<3>(*law, slip, bristles);
                    *sum += f.mu.sum() + f.by_speed.sum() + f.rate_by_speed.sum() + f.decay;
                }
            },
            {},
            {}};
}

} // namespace

Kernels law_kernels() {
    Kernels list;
    for (const NormalLawInfo& info : normal_law_kinds())
        list.push_back({"normal-law/" + std::string(info.name),
                        [kind = std::string(info.name)](const Setup&) { return normal_law(kind); }, 0,
                        points});
    for (const std::string kind : {"coulomb", "coulomb-smooth", "lugre", "dahl"})
        list.push_back(
            {"friction-law/" + kind, [kind](const Setup&) { return friction_law(kind); }, 0, points});
    return list;
}

} // namespace gudgeon::kernels

#include "bench/peers/simbody_forces.hpp"

#include <cmath>

namespace gudgeon::peers {

using SimTK::Rotation;
using SimTK::SpatialVec;
using SimTK::State;
using SimTK::Transform;

namespace {

using V = SimTK::Vec3;
using Loads = SimTK::Vector_<SpatialVec>;

// A station's body in motion, in the ground frame.
struct Moving {
    const Transform& pose;
    const SpatialVec& velocity;
    V arm, place, speed;

    Moving(const State& state, const Station& s)
        : pose(s.body.getBodyTransform(state)), velocity(s.body.getBodyVelocity(state)),
          arm(pose.R() * s.point), place(pose.p() + arm), speed(velocity[1] + velocity[0] % arm) {}
};

void push(Loads& loads, const Station& s, const V& moment, const V& force) {
    loads[s.body.getMobilizedBodyIndex()] += SpatialVec(moment, force);
}

// (1 - (t/2) cot(t/2)) / t^2 of the square of t: the coefficient of theta x (theta x .) in theta'.
double curvature(double square) {
    if (square < 1e-2)
        return 1.0 / 12 + square * (1.0 / 720 + square * (1.0 / 30240 + square / 1209600));
    const double half = 0.5 * std::sqrt(square);
    return (1 - half / std::tan(half)) / square;
}

struct Displacement {
    V d, theta, d_rate, theta_rate; // along the axes of the bushing on a
    Rotation axes;                  // of the bushing on a, in the ground frame
    double curvature;
};

Displacement displacement(const Moving& a, const Moving& b, const BushingElement& x) {
    Displacement m;
    m.axes = a.pose.R() * x.a.axes;
    const V between = b.place - a.place;
    m.d = ~m.axes * between;
    m.d_rate = ~m.axes * (b.speed - a.speed - a.velocity[0] % between);
    m.theta = rotation_vector_of(~m.axes * (b.pose.R() * x.b.axes));
    m.curvature = curvature(m.theta.normSqr());
    const V turn = ~m.axes * (b.velocity[0] - a.velocity[0]);
    m.theta_rate = turn - 0.5 * (m.theta % turn) + m.curvature * (m.theta % (m.theta % turn));
    return m;
}

class Bushings : public SimTK::Force::Custom::Implementation {
  public:
    explicit Bushings(std::vector<BushingElement> elements) : elements_(std::move(elements)) {}

    void calcForce(const State& state, Loads& loads, SimTK::Vector_<V>&, SimTK::Vector&) const override {
        for (const BushingElement& x : elements_) {
            const Moving a(state, x.a), b(state, x.b);
            const Displacement m = displacement(a, b, x);
            const V force = -(x.preload[0] + x.stiffness[0].elementwiseMultiply(m.d) +
                              x.damping[0].elementwiseMultiply(m.d_rate));
            const V twist = -(x.preload[1] + x.stiffness[1].elementwiseMultiply(m.theta) +
                              x.damping[1].elementwiseMultiply(m.theta_rate));
            const V moment = twist + 0.5 * (m.theta % twist) + m.curvature * (m.theta % (m.theta % twist));
            const V f = m.axes * force, t = m.axes * moment;
            push(loads, x.b, t + b.arm % f, f);
            push(loads, x.a, -t - (b.place - a.pose.p()) % f, -f);
        }
    }

    double calcPotentialEnergy(const State& state) const override {
        double sum = 0;
        for (const BushingElement& x : elements_) {
            const Displacement m = displacement(Moving(state, x.a), Moving(state, x.b), x);
            sum += ~m.d * (x.preload[0] + 0.5 * x.stiffness[0].elementwiseMultiply(m.d));
            sum += ~m.theta * (x.preload[1] + 0.5 * x.stiffness[1].elementwiseMultiply(m.theta));
        }
        return sum;
    }

  private:
    std::vector<BushingElement> elements_;
};

class Springs : public SimTK::Force::Custom::Implementation {
  public:
    explicit Springs(std::vector<SpringElement> elements) : elements_(std::move(elements)) {}

    void calcForce(const State& state, Loads& loads, SimTK::Vector_<V>&, SimTK::Vector&) const override {
        for (const SpringElement& x : elements_) {
            const Moving a(state, x.a), b(state, x.b);
            const V line = b.place - a.place;
            const double length = line.norm();
            const V along = line / length;
            const double tension =
                x.stiffness * (length - x.free_length) + x.damping * (~along * (b.speed - a.speed));
            const V f = tension * along;
            push(loads, x.a, a.arm % f, f);
            push(loads, x.b, -(b.arm % f), -f);
        }
    }

    double calcPotentialEnergy(const State& state) const override {
        double sum = 0;
        for (const SpringElement& x : elements_) {
            const double stretch =
                (Moving(state, x.b).place - Moving(state, x.a).place).norm() - x.free_length;
            sum += 0.5 * x.stiffness * stretch * stretch;
        }
        return sum;
    }

  private:
    std::vector<SpringElement> elements_;
};

class Tyres : public SimTK::Force::Custom::Implementation {
  public:
    explicit Tyres(std::vector<TyreLoad> elements) : elements_(std::move(elements)) {}

    void calcForce(const State& state, Loads& loads, SimTK::Vector_<V>&, SimTK::Vector&) const override {
        for (const TyreLoad& x : elements_) {
            const Moving wheel(state, x.at);
            const TimeValue road = evaluate(x.road, state.getTime());
            const double lift = x.preload - x.stiffness * (wheel.place[2] - x.reference - road.value) -
                                x.damping * (wheel.speed[2] - road.rate);
            const V f(0, 0, lift);
            push(loads, x.at, wheel.arm % f, f);
        }
    }

    double calcPotentialEnergy(const State& state) const override {
        double sum = 0;
        for (const TyreLoad& x : elements_) {
            const double rise =
                Moving(state, x.at).place[2] - x.reference - evaluate(x.road, state.getTime()).value;
            sum += (0.5 * x.stiffness * rise - x.preload) * rise;
        }
        return sum;
    }

  private:
    std::vector<TyreLoad> elements_;
};

} // namespace

V rotation_vector_of(const Rotation& turn) {
    const V sine(0.5 * (turn[2][1] - turn[1][2]), 0.5 * (turn[0][2] - turn[2][0]),
                 0.5 * (turn[1][0] - turn[0][1]));
    const double cosine = 0.5 * (turn.trace() - 1), square = sine.normSqr();
    if (cosine > 0 && square < 1e-4) // arcsin(s)/s
        return (1 +
                square * (1.0 / 6 + square * (3.0 / 40 + square * (15.0 / 336 + square * 105.0 / 3456)))) *
               sine;
    const SimTK::Vec4 turned = turn.convertRotationToAngleAxis();
    return turned[0] * turned.getSubVec<3>(1);
}

void add_bushings(SimTK::GeneralForceSubsystem& forces, std::vector<BushingElement> elements) {
    if (!elements.empty())
        SimTK::Force::Custom(forces, new Bushings(std::move(elements)));
}

void add_springs(SimTK::GeneralForceSubsystem& forces, std::vector<SpringElement> elements) {
    if (!elements.empty())
        SimTK::Force::Custom(forces, new Springs(std::move(elements)));
}

void add_library_bushings(SimTK::GeneralForceSubsystem& forces, const std::vector<BushingElement>& elements) {
    const auto six = [](const V(&parts)[2]) {
        return SimTK::Vec6(parts[1][0], parts[1][1], parts[1][2], parts[0][0], parts[0][1], parts[0][2]);
    };
    for (const BushingElement& x : elements)
        SimTK::Force::LinearBushing(forces, x.a.body, Transform(x.a.axes, x.a.point), x.b.body,
                                    Transform(x.b.axes, x.b.point), six(x.stiffness), six(x.damping));
}

void add_library_springs(SimTK::GeneralForceSubsystem& forces, const std::vector<SpringElement>& elements) {
    for (const SpringElement& x : elements) {
        SimTK::Force::TwoPointLinearSpring(forces, x.a.body, x.a.point, x.b.body, x.b.point, x.stiffness,
                                           x.free_length);
        SimTK::Force::TwoPointLinearDamper(forces, x.a.body, x.a.point, x.b.body, x.b.point, x.damping);
    }
}

void add_tyres(SimTK::GeneralForceSubsystem& forces, std::vector<TyreLoad> elements) {
    if (!elements.empty())
        SimTK::Force::Custom(forces, new Tyres(std::move(elements)));
}

} // namespace gudgeon::peers

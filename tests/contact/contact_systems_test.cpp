// Every kind of contact in a compiled system: derivatives against differences of the forces, balance of the
// pair of wrenches, energy, samples, threads.
#include "contact/strip_batch.hpp"
#include "core/assembly.hpp"
#include "core/matrices.hpp"
#include "models/builders.hpp"
#include "tests/core/motion_tools.hpp"
#include "tests/solvers/system_tools.hpp"

#include <gtest/gtest.h>

#include <functional>

namespace gudgeon {
namespace {

using namespace test;

ContactLaw soft_law() {
    ContactLaw law;
    law.stiffness = 30;
    law.restitution = 0.5;
    return law;
}

struct Case {
    std::string name;
    JointKind kind;
    Vec3 shift; // of b's point in a's joint frame (h, t, b)
    Vec3 turn;  // of b about a's joint axes
    std::function<void(Joint&)> change = [](Joint&) {};
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

// Two free bodies in general position whose joint is worn by a tenth of its radius.
Model worn(const Case& c) {
    std::mt19937 rng(3);
    Model model;
    for (const char* name : {"a", "b"}) {
        Body body = make_body(name, 1.3, {0.3, 0.4, 0.5}, random_vector(rng));
        body.orientation = random_orientation(rng);
        model.bodies.push_back(body);
    }
    model.gravity = Vec3::Zero();
    Joint joint = make_joint("J", c.kind, "a", "b", Vec3::Zero());
    joint.body_frame = true;
    joint.points = {random_vector(rng), random_vector(rng)};
    joint.axes = {Vec3(0, 0, 1), Vec3(0, 0, 1)};
    joint.references = {Vec3(1, 0, 0), Vec3(1, 0, 0)};
    if (c.kind == JointKind::universal) {
        joint.axes = {Vec3(0, 0, 1), Vec3(1, 0, 0)};
        joint.references.reset();
    }
    joint.fidelity = Fidelity::clearance;
    joint.clearance = Clearance{};
    joint.clearance->radial = 0.1;
    joint.clearance->radius = 1;
    joint.clearance->length = 1.2;
    joint.clearance->strips = 4;
    joint.clearance->law = soft_law();
    if (c.kind == JointKind::spherical || c.kind == JointKind::universal)
        joint.clearance->length.reset();
    if (c.kind == JointKind::spherical) {
        joint.axes.reset();
        joint.references.reset();
    }
    c.change(joint);
    model.joints.push_back(joint);
    return model;
}

class ContactSystem : public testing::TestWithParam<Case> {
  protected:
    ContactSystem() : system_(compiled(worn(GetParam()))), ws_(make_workspace(system_)) {
        const Case& c = GetParam();
        const JointRecord& j = system_.joints[0];
        state_ = initial_state(system_);
        std::mt19937 rng(8);
        for (double& u : state_.u)
            u = std::uniform_real_distribution<double>(-0.4, 0.4)(rng);
        set_motion(system_, state_.q, state_.u, ws_);
        const BodyMotion& a = ws_.motion[0];
        const Mat3 frame = a.A * j.a.axes;
        const double angle = c.turn.norm();
        const Mat3 turn = angle > 0 ? Mat3(Eigen::AngleAxisd(angle, c.turn / angle)) : Mat3(Mat3::Identity());
        // the universal joint's second axis lies across the first
        const Mat3 rest = c.kind == JointKind::universal ? Mat3(Eigen::AngleAxisd(pi / 2, Vec3::UnitY()))
                                                         : Mat3(Mat3::Identity());
        const Mat3 A = frame * turn * rest * j.b.axes.transpose();
        state_.q.segment<4>(10) = test::euler_parameters(A);
        state_.q.segment<3>(7) = point_position(a, j.a.point) + frame * c.shift - A * j.b.point;
        set_motion(system_, state_.q, state_.u, ws_);
        update_angles(system_, 0, ws_, ws_.angles);
        ws_.contacts.start_speed.setConstant(1.7);
    }

    VecX forces(const VecX& q, const VecX& u) {
        set_motion(system_, q, u, ws_);
        evaluate_forces(system_, 0, ws_);
        return ws_.f;
    }
    VecX moved_along(const VecX& step, double h) const {
        VecX q = state_.q;
        move(system_, h * step, q);
        return q;
    }
    template <class F> void expect_derivative(const MatX& matrix, F f, double tolerance = 2e-7) {
        for (Eigen::Index k = 0; k < 12; ++k) {
            const VecX step = VecX::Unit(12, k);
            const VecX truth = derivative([&](double h) { return MatX(f(step, h)); }, 1e-3);
            const double size = 1 + matrix.cwiseAbs().maxCoeff();
            for (Eigen::Index i = 0; i < 12; ++i)
                EXPECT_NEAR(matrix(i, k), truth[i], tolerance * size) << "row " << i << ", column " << k;
        }
    }

    System system_;
    Workspace ws_;
    State state_;
};

TEST_P(ContactSystem, DerivativesOfTheForces) {
    ASSERT_GT(forces(state_.q, state_.u).norm(), 0.1);
    linearise(system_, 0, state_.lambda.data(), ws_);
    const MatX C = dense(blocks_as_matrix(system_, ws_.lin.C));
    const MatX S = dense(blocks_as_matrix(system_, ws_.lin.S));
    expect_derivative(
        C, [&](const VecX& step, double h) -> VecX { return -forces(state_.q, state_.u + h * step); });
    expect_derivative(
        S, [&](const VecX& step, double h) -> VecX { return -forces(moved_along(step, h), state_.u); });
}

TEST_P(ContactSystem, WrenchesBalanceAndAreTheJoints) {
    state_.u.setZero();
    const VecX f = forces(state_.q, state_.u);
    const BodyMotion &a = ws_.motion[0], &b = ws_.motion[1];
    const Vec3 fa = f.segment<3>(0), fb = f.segment<3>(6);
    const Vec3 moment = a.r.cross(fa) + a.A * f.segment<3>(3) + b.r.cross(fb) + b.A * f.segment<3>(9);
    EXPECT_LT((fa + fb).norm(), 1e-13 * (1 + f.norm()));
    EXPECT_LT(moment.norm(), 1e-12 * (1 + f.norm()));

    std::vector<Wrench> wrench(1);
    const Evaluation e = evaluation(system_, ws_, 0);
    for (const auto& batch : system_.forces)
        batch->add_joint_wrenches(e, wrench);
    EXPECT_LT((wrench[0].force - fb).norm(), 1e-13 * (1 + f.norm()));
    EXPECT_LT((wrench[0].moment - f.segment<3>(9)).norm(), 1e-13 * (1 + f.norm()));
}

// wrench . u + d(elastic)/dt + dissipated = 0 along the motion at constant velocities.
TEST_P(ContactSystem, EnergyIsKept) {
    const double power = forces(state_.q, state_.u).dot(state_.u);
    // the gyroscopic forces do no work
    const Energies now = energies(system_, 0, nullptr, ws_);
    const double stored = derivative(
        [&](double h) {
            set_motion(system_, moved_along(state_.u, h), state_.u, ws_);
            return MatX::Constant(1, 1, energies(system_, 0, nullptr, ws_).elastic);
        },
        1e-3)(0);
    EXPECT_NEAR(power + stored + now.dissipated_power, 0, 1e-7 * (1 + std::abs(power)));
}

TEST_P(ContactSystem, SamplesAgreeWithForcesAndEnergies) {
    forces(state_.q, state_.u);
    sample_contacts(system_, 0, ws_);
    const Energies all = energies(system_, 0, nullptr, ws_);
    double elastic = 0, dissipated = 0;
    for (std::size_t c = 0; c < system_.contacts.size(); ++c) {
        const ContactSample& s = ws_.samples[c];
        elastic += s.elastic;
        dissipated += s.dissipated_power;
        if (s.depth <= 0)
            continue;
        const ContactSample one = system_.forces[system_.contacts[c].batch]->sample_contact(
            evaluation(system_, ws_, 0), static_cast<int>(c));
        EXPECT_GT(one.inverse_mass, 0);
        EXPECT_EQ(one.depth, s.depth);
        EXPECT_EQ(one.rate, s.rate);
        const auto depth_after = [&](double h) {
            set_motion(system_, moved_along(state_.u, h), state_.u, ws_);
            return MatX::Constant(1, 1,
                                  system_.forces[system_.contacts[c].batch]
                                      ->sample_contact(evaluation(system_, ws_, 0), static_cast<int>(c))
                                      .depth);
        };
        EXPECT_NEAR(s.rate, derivative(depth_after, 1e-3)(0), 1e-8);
        set_motion(system_, state_.q, state_.u, ws_);
    }
    const bool bushing = GetParam().name == "MixedWithBushing";
    if (!bushing) {
        EXPECT_NEAR(elastic, all.elastic, 1e-13 * (1 + elastic));
        EXPECT_NEAR(dissipated, all.dissipated_power, 1e-13 * (1 + elastic));
    }
}

void no_axial(Joint& j) {
    j.fidelity = Fidelity::perfect;
    j.motions[static_cast<std::size_t>(Motion::radial)] = Fidelity::clearance;
    j.motions[static_cast<std::size_t>(Motion::misalignment)] = Fidelity::clearance;
}

Stop stop_between(double lower, double upper) {
    Stop stop;
    stop.lower = lower;
    stop.upper = upper;
    stop.law = soft_law();
    return stop;
}

void blend(Joint& j) {
    ContactLaw law;
    law.kind = "blend";
    law.stiffness = 20;
    law.damping = 2;
    law.thickness = 0.05;
    law.width = 0.3;
    law.smooth = true;
    law.hard = {soft_law()};
    j.clearance->law = law;
}

const std::vector<Case> cases{
    {"Ball", JointKind::spherical, {0.2, -0.15, 0.1}, {0.3, -0.7, 0.4}},
    {"BallBearingOnB",
     JointKind::spherical,
     {0.2, -0.15, 0.1},
     {0.3, -0.7, 0.4},
     [](Joint& j) { j.clearance->bearing_on_b = true; }},
    {"BallBlend", JointKind::spherical, {0.2, -0.15, 0.1}, {0.3, -0.7, 0.4}, blend},
    {"Strips", JointKind::cylindrical, {0.18, 0.12, 0.3}, {0.05, 0.1, 0.7}},
    {"StripsBearingOnB",
     JointKind::cylindrical,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.7},
     [](Joint& j) { j.clearance->bearing_on_b = true; }},
    {"StripsParallel", JointKind::cylindrical, {0.18, 0.12, 0.3}, {0, 0, 0.4}},
    {"StripsOnTwoSides", JointKind::cylindrical, {0.02, 0.01, 0}, {0.7, 0.1, 0.2}},
    {"StripsPartlyCovered",
     JointKind::cylindrical,
     {0.18, 0.12, 0.5},
     {0.05, 0.1, 0.7},
     [](Joint& j) { j.clearance->journal_length = 1.1; }},
    {"StripsOfABarrel",
     JointKind::cylindrical,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.7},
     [](Joint& j) {
         j.clearance->radius.reset();
         j.clearance->profile = {1.02, 1.0, 1.01, 1.05};
     }},
    {"StripsBlend", JointKind::cylindrical, {0.18, 0.12, 0.3}, {0.05, 0.1, 0.7}, blend},
    {"RevoluteWithEndFace", JointKind::revolute, {0.18, 0.12, 0.3}, {0.05, 0.1, 0.7}},
    {"MixedRevolute", JointKind::revolute, {0.18, 0.12, 0.3}, {0.05, 0.1, 0.7}, no_axial},
    {"MixedWithBushing",
     JointKind::revolute,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.7},
     [](Joint& j) {
         j.fidelity = Fidelity::bushing;
         j.motions[static_cast<std::size_t>(Motion::radial)] = Fidelity::clearance;
         j.bushing = Bushing{};
         j.bushing->stiffness = {1e9, 1e9, 50, 3, 4, 5};
         j.bushing->damping = {1e9, 1e9, 1, 0.3, 0.2, 0.1};
     }},
    {"Planar",
     JointKind::cylindrical,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.7},
     [](Joint& j) { j.clearance->model = "planar"; }},
    {"TwoEnds",
     JointKind::cylindrical,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.7},
     [](Joint& j) { j.clearance->model = "two-end"; }},
    {"KeyOfASlider",
     JointKind::translation,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.7},
     [](Joint& j) { j.clearance->rotation = 0.2; }},
    {"Slot",
     JointKind::translation,
     {0.18, 0.12, 0.3},
     {0.05, 0.1, 0.2},
     [](Joint& j) {
         j.clearance->model = "slot";
         j.clearance->radius.reset();
         j.clearance->section = std::array<double, 2>{2, 1.5};
         j.clearance->journal_length = 2;
     }},
    {"Universal",
     JointKind::universal,
     {0.2, -0.15, 0.1},
     {0.3, -0.7, 0.4},
     [](Joint& j) { j.clearance->misalignment = 0.05; }},
    {"StopOfASlide",
     JointKind::cylindrical,
     {0.02, 0.03, 0.6},
     {0.05, 0.1, 0.7},
     [](Joint& j) {
         j.clearance->radial = 0.5;
         j.stops["slide"] = stop_between(-0.2, 0.4);
     }},
    {"StopOfAnAngle",
     JointKind::cylindrical,
     {0.02, 0.03, -0.3},
     {0.05, 0.1, -0.7},
     [](Joint& j) {
         j.clearance->radial = 0.5;
         j.stops["angle"] = stop_between(-0.4, 0.4);
     }},
};

INSTANTIATE_TEST_SUITE_P(Every, ContactSystem, testing::ValuesIn(cases),
                         [](const auto& info) { return info.param.name; });

// A row of journals in their bearings, each pressed into the wall or clear of it.
Model row_of_journals(int count) {
    Model model;
    for (int k = 0; k < count; ++k) {
        const std::string name = "j" + std::to_string(k);
        Body body = make_body(name, 1, {0.1, 0.1, 0.1}, {double(k), 0, 0});
        body.orientation = Vec4(1, 0.01 * k, 0.002, 0).normalized();
        body.velocity = {0.01 * k, 0.1, -0.2};
        model.bodies.push_back(body);
        Joint joint =
            make_joint("B" + std::to_string(k), JointKind::cylindrical,
                       k == 0 ? "ground" : "j" + std::to_string(k - 1), name, Vec3(double(k), 0, 0));
        joint.axes = {Vec3(0, 0, 1), Vec3(0, 0, 1)};
        joint.fidelity = Fidelity::clearance;
        joint.clearance = Clearance{};
        joint.clearance->radial = 1e-3;
        joint.clearance->radius = 0.2;
        joint.clearance->length = 0.3;
        joint.clearance->strips = 16;
        joint.clearance->law = soft_law();
        joint.body_frame = true;
        joint.points = {Vec3(k % 3 == 0 ? 0.0 : 1.003, 0, 0), Vec3::Zero()};
        model.joints.push_back(joint);
    }
    return model;
}

// Everything a batch gives, in one row.
std::vector<double> all_results(const System& system, const State& state, int threads) {
    Workspace ws = make_workspace(system, threads);
    for (int c = 0; c < system.channels(); c += 3) // some contacts last, the others are new
        ws.contacts.start_speed[c] = 0.3;
    ws.z.setLinSpaced(-1e-4, 1e-4);
    set_motion(system, state.q, state.u, ws);
    evaluate_forces(system, 0, ws);
    linearise(system, 0, state.lambda.data(), ws);
    sample_contacts(system, 0, ws);
    VecX source = VecX::Zero(system.friction_states()), decay = source;
    state_terms(system, 0, ws, source, decay);
    const Energies e = energies(system, 0, nullptr, ws);
    EXPECT_GT(ws.f.norm(), 1e-3);
    EXPECT_GT(e.elastic, 0);
    std::vector<double> out{e.elastic, e.dissipated_power};
    const auto add = [&out](const auto& range) { out.insert(out.end(), range.begin(), range.end()); };
    add(ws.f);
    add(ws.lin.C);
    add(ws.lin.S);
    add(source);
    add(decay);
    for (const Linearisation::StateCoupling& x : ws.lin.states) {
        out.push_back(x.decay);
        add(x.force.tb);
        add(x.rate.ta);
    }
    for (const ContactSample& x : ws.samples) {
        add(std::initializer_list<double>{x.depth, x.rate, x.force, x.friction, x.dissipated_power, x.place});
        add(x.normal_force);
    }
    return out;
}

TEST(Strips, SameBitsForAnyNumberOfThreads) {
    for (const char* friction : {"", "lugre"}) {
        Model model = row_of_journals(80); // enough for several threads to start
        if (*friction)
            for (Joint& joint : model.joints) {
                joint.clearance->friction = Friction{};
                joint.clearance->friction->kind = friction;
                joint.clearance->friction->kinetic = 0.2;
                joint.clearance->friction->statics = 0.3;
                joint.clearance->friction->speed = 0.1;
                joint.clearance->friction->sigma0 = 1e4;
                joint.clearance->friction->sigma1 = 1;
            }
        const System system = compiled(std::move(model));
        const State state = initial_state(system);
        const std::vector<double> one = all_results(system, state, 1);
        for (const int threads : {2, 3})
            EXPECT_EQ(all_results(system, state, threads), one) << threads;
    }
}

// Many strips are found block by block: as many as the same bearing cut into as many joints.
TEST(Strips, BlocksOfALongBearing) {
    Model model = row_of_journals(2);
    model.joints.pop_back();
    model.joints[0].points[1] = Vec3(0.3e-3, 1.004e-3, 0);
    double truth = 0;
    for (const int strips : {16, 100, 1000}) {
        model.joints[0].clearance->strips = strips;
        const System system = compiled(model);
        Workspace ws = make_workspace(system);
        const State state = initial_state(system);
        set_motion(system, state.q, state.u, ws);
        const double energy = energies(system, 0, nullptr, ws).elastic;
        if (strips == 16)
            truth = energy;
        EXPECT_GT(energy, 0);
        EXPECT_NEAR(energy, truth, 1e-2 * truth) << strips;
    }
}

TEST(Strips, JointsOutOfReachEvaluateNone) {
    Model model = row_of_journals(6);
    for (Joint& joint : model.joints) // all centred
        joint.points = {Vec3(joint.name == "B0" ? 0.0 : 1.0, 0, 0), Vec3::Zero()};
    for (Body& body : model.bodies)
        body.orientation = {1, 0, 0, 0};
    const System system = compiled(model);
    Workspace ws = make_workspace(system);
    set_motion(system, initial_state(system).q, initial_state(system).u, ws);
    int batches = 0;
    for (const auto& batch : system.forces)
        if (const auto* strips = dynamic_cast<const StripBatch*>(batch.get())) {
            ++batches;
            EXPECT_EQ(strips->strips(), 6u * 16u);
            EXPECT_EQ(strips->strips_in_reach(evaluation(system, ws, 0)), 0u);
        }
    EXPECT_EQ(batches, 1);
}

} // namespace
} // namespace gudgeon

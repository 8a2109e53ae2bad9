#include "bench/peers/simbody_system.hpp"

#include "bench/peers/simbody_forces.hpp"
#include "bench/peers/spanning_tree.hpp"
#include "core/motion.hpp"

#include <fnmatch.h>

namespace gudgeon::peers {

using SimTK::Constraint;
using SimTK::MobilizedBody;
using SimTK::Rotation;
using SimTK::SpatialVec;
using SimTK::Transform;

namespace {

constexpr double start_tolerance = 1e-9; // m, rad, m/s, rad/s

SimTK::Vec3 vec(const Vec3& v) { return {v[0], v[1], v[2]}; }

Rotation rotation_of(const Mat3& m) {
    return Rotation(
        SimTK::Mat33(m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2)), true);
}

Transform pose_of(const Model& model, int body) {
    if (body == ground)
        return Transform();
    const Body& b = model.bodies[static_cast<std::size_t>(body)];
    return Transform(rotation_of(rotation(b.orientation.normalized())), vec(b.position));
}

// Angular and linear velocity of the mass centre in the ground frame.
SpatialVec velocity_of(const Model& model, int body) {
    if (body == ground)
        return SpatialVec(SimTK::Vec3(0), SimTK::Vec3(0));
    const Body& b = model.bodies[static_cast<std::size_t>(body)];
    return SpatialVec(pose_of(model, body).R() * vec(b.angular_velocity), vec(b.velocity));
}

SimTK::Body::Rigid rigid_body(const Body& body) {
    const Mat3& i = body.inertia;
    const SimTK::Inertia inertia(SimTK::Vec3(i(0, 0), i(1, 1), i(2, 2)),
                                 SimTK::Vec3(i(0, 1), i(0, 2), i(1, 2)));
    return SimTK::Body::Rigid(SimTK::MassProperties(body.mass, SimTK::Vec3(0), inertia));
}

/// Frames on both sides of a joint: z along the axis, in the pose as given.
Transform joint_frame(const Model& model, const Joint& joint, int side) {
    const Transform body = pose_of(model, body_index(model, joint.bodies[static_cast<std::size_t>(side)]));
    const Mat3 axes =
        joint.axes ? joint_triad((*joint.axes)[static_cast<std::size_t>(side)]) : Mat3::Identity();
    return ~body * Transform(rotation_of(axes), vec(joint.points[static_cast<std::size_t>(side)]));
}

class Assembler {
  public:
    Assembler(const Model& model, const SimbodyOptions& options, SimbodySystem& out)
        : model_(model), options_(options), out_(out), tree_(spanning_tree(model)) {}

    void build() {
        SimTK::Force::Gravity(out_.forces, out_.matter, vec(model_.gravity));
        out_.bodies.resize(model_.bodies.size());
        for (const TreeBody& body : tree_.bodies)
            add_body(body);
        for (std::size_t i = 0; i < tree_.loops.size(); ++i)
            close_loop(model_.joints[static_cast<std::size_t>(tree_.loops[i])],
                       tree_.planar[i] && !options_.full_loops);
        add_forces();
        out_.start = out_.system.realizeTopology();
        out_.matter.setUseEulerAngles(out_.start, options_.euler_angles);
        out_.system.realizeModel(out_.start);
        for (const TreeBody& body : tree_.bodies)
            set_start(body);
        check_start();
    }

  private:
    MobilizedBody& mobilizer(int body) {
        return body == ground ? out_.matter.updGround() : out_.bodies[static_cast<std::size_t>(body)];
    }
    MobilizedBody& mobilizer(const std::string& name) { return mobilizer(body_index(model_, name)); }

    void add_body(const TreeBody& at) {
        const SimTK::Body::Rigid info = rigid_body(model_.bodies[static_cast<std::size_t>(at.body)]);
        MobilizedBody& inboard = mobilizer(at.inboard);
        MobilizedBody& out = out_.bodies[static_cast<std::size_t>(at.body)];
        if (at.joint < 0) {
            out = MobilizedBody::Free(inboard, Transform(), info, Transform());
            return;
        }
        const Joint& joint = model_.joints[static_cast<std::size_t>(at.joint)];
        const int side = body_index(model_, joint.bodies[0]) == at.inboard ? 0 : 1;
        const Transform f = joint_frame(model_, joint, side), m = joint_frame(model_, joint, 1 - side);
        if (joint.kind == JointKind::revolute)
            out = MobilizedBody::Pin(inboard, f, info, m);
        else if (joint.kind == JointKind::spherical)
            out = MobilizedBody::Ball(inboard, f, info, m);
        else
            out = MobilizedBody::Weld(inboard, f, info, m);
    }

    void close_loop(const Joint& joint, bool planar) {
        MobilizedBody &a = mobilizer(joint.bodies[0]), &b = mobilizer(joint.bodies[1]);
        const Transform fa = joint_frame(model_, joint, 0), fb = joint_frame(model_, joint, 1);
        if (joint.kind == JointKind::distance) {
            const Vec3 between = joint.points[1] - joint.points[0];
            Constraint::Rod(a, fa.p(), b, fb.p(), joint.length.value_or(between.norm()));
        } else if (joint.kind == JointKind::rigid) {
            Constraint::Weld(a, fa, b, fb);
        } else if (planar) {
            Constraint::PointOnLine(a, fa.z(), fa.p(), b, fb.p());
        } else {
            Constraint::Ball(a, fa.p(), b, fb.p());
            if (joint.kind == JointKind::revolute) {
                Constraint::ConstantAngle(a, fa.x(), b, fb.z());
                Constraint::ConstantAngle(a, fa.y(), b, fb.z());
            }
        }
    }

    Station station(const std::string& name, const Vec3& point, const Mat3& axes = Mat3::Identity()) {
        const Transform local =
            ~pose_of(model_, body_index(model_, name)) * Transform(rotation_of(axes), vec(point));
        return {mobilizer(name), local.p(), local.R()};
    }

    BushingElement bushing(const Joint& joint) {
        const Bushing& law = *joint.bushing;
        BushingElement x;
        for (int side = 0; side < 2; ++side) {
            const auto i = static_cast<std::size_t>(side);
            x.stiffness[i] = SimTK::Vec3(&law.stiffness[3 * i]);
            x.damping[i] = SimTK::Vec3(&law.damping[3 * i]);
            x.preload[i] = SimTK::Vec3(&law.preload[3 * i]);
            const bool global = law.global_axes || !joint.axes;
            const Mat3 axes = global ? Mat3::Identity() : Mat3(joint_triad((*joint.axes)[i]));
            (side == 0 ? x.a : x.b) = station(joint.bodies[i], joint.points[i], axes);
        }
        return x;
    }

    void add_forces() {
        std::vector<BushingElement> bushings;
        for (const Joint& joint : model_.joints)
            if (joint.fidelity == Fidelity::bushing)
                bushings.push_back(bushing(joint));
        std::vector<SpringElement> springs;
        std::vector<TyreLoad> tyres;
        for (const Force& force : model_.forces) {
            if (const auto* f = std::get_if<SpringDamper>(&force)) {
                const double given = (f->points[1] - f->points[0]).norm();
                springs.push_back({station(f->bodies[0], f->points[0]), station(f->bodies[1], f->points[1]),
                                   f->stiffness, f->damping, f->free_length.value_or(given)});
            } else if (const auto* tyre = std::get_if<Tyre>(&force)) {
                tyres.push_back({station(tyre->body, tyre->point), tyre->stiffness, tyre->damping,
                                 tyre->preload, tyre->reference.value_or(tyre->point[2]),
                                 tyre->road ? *tyre->road : TimeFunction(ConstantFunction{0})});
            }
        }
        if (options_.library_forces) {
            add_library_bushings(out_.forces, bushings);
            add_library_springs(out_.forces, springs);
        } else {
            add_bushings(out_.forces, std::move(bushings));
            add_springs(out_.forces, std::move(springs));
        }
        add_tyres(out_.forces, std::move(tyres));
    }

    // Motion of the outboard frame relative to the inboard one.
    void set_start(const TreeBody& at) {
        const MobilizedBody& body = mobilizer(at.body);
        const Transform inboard = pose_of(model_, at.inboard) * body.getDefaultInboardFrame();
        const Transform outboard = pose_of(model_, at.body) * body.getDefaultOutboardFrame();
        body.setQToFitTransform(out_.start, ~inboard * outboard);
        const SpatialVec parent = velocity_of(model_, at.inboard), child = velocity_of(model_, at.body);
        const SimTK::Vec3 parent_speed =
            parent[1] + parent[0] % (outboard.p() - pose_of(model_, at.inboard).p());
        const SimTK::Vec3 child_speed = child[1] + child[0] % (outboard.p() - pose_of(model_, at.body).p());
        body.setUToFitVelocity(out_.start, SpatialVec(~inboard.R() * (child[0] - parent[0]),
                                                      ~inboard.R() * (child_speed - parent_speed)));
    }

    void check_start() {
        out_.system.realize(out_.start, SimTK::Stage::Velocity);
        double worst = std::max(out_.start.getNQErr() ? out_.start.getQErr().normInf() : 0,
                                out_.start.getNUErr() ? out_.start.getUErr().normInf() : 0);
        for (std::size_t i = 0; i < model_.bodies.size(); ++i) {
            const Transform wanted = pose_of(model_, static_cast<int>(i));
            const SpatialVec speed = velocity_of(model_, static_cast<int>(i));
            const Transform& is = out_.bodies[i].getBodyTransform(out_.start);
            const SpatialVec& moves = out_.bodies[i].getBodyVelocity(out_.start);
            worst = std::max({worst, (is.p() - wanted.p()).norm(),
                              (is.R().asMat33() - wanted.R().asMat33()).norm(), (moves[0] - speed[0]).norm(),
                              (moves[1] - speed[1]).norm()});
        }
        if (!(worst < start_tolerance))
            throw ModelError(model_.source, "/bodies",
                             "the start violates the joints by " + std::to_string(worst),
                             "a start that needs no assembly");
    }

    const Model& model_;
    const SimbodyOptions& options_;
    SimbodySystem& out_;
    SpanningTree tree_;
};

} // namespace

std::unique_ptr<SimbodySystem> build_simbody(const Model& model, const SimbodyOptions& options) {
    refuse_unknown(model);
    auto out = std::make_unique<SimbodySystem>();
    Assembler(model, options, *out).build();
    return out;
}

double Channel::value(const SimTK::State& state) const {
    const SimTK::Vec3 v = velocity ? body.findStationVelocityInGround(state, point)
                                   : body.findStationLocationInGround(state, point);
    return v[axis];
}

std::vector<Channel> choose_channels(const Model& model, const SimbodySystem& built,
                                     const std::vector<std::string>& patterns) {
    static const std::vector<std::string> suffixes{".x", ".y", ".z", ".vx", ".vy", ".vz"};
    std::vector<Channel> all;
    const auto offer = [&](const std::string& name, int body, const SimTK::Vec3& point) {
        for (int i = 0; i < 6; ++i)
            all.push_back({name + suffixes[static_cast<std::size_t>(i)],
                           body == ground ? MobilizedBody(built.matter.getGround())
                                          : built.bodies[static_cast<std::size_t>(body)],
                           point, i >= 3, i % 3});
    };
    for (std::size_t i = 0; i < model.bodies.size(); ++i)
        offer(model.bodies[i].name, static_cast<int>(i), SimTK::Vec3(0));
    for (const Marker& marker : model.markers) {
        const int body = body_index(model, marker.body);
        offer(marker.name, body, ~pose_of(model, body) * vec(marker.point));
    }
    std::vector<Channel> chosen;
    std::vector<bool> fits(patterns.size());
    for (const Channel& channel : all)
        for (std::size_t i = 0; i < patterns.size(); ++i)
            if (fnmatch(patterns[i].c_str(), channel.name.c_str(), 0) == 0) {
                fits[i] = true;
                chosen.push_back(channel);
                break;
            }
    for (std::size_t i = 0; i < patterns.size(); ++i)
        if (!fits[i])
            throw ModelError(model.source, "", "no channel fits " + patterns[i],
                             "x y z vx vy vz of mass centres and markers");
    return chosen;
}

} // namespace gudgeon::peers

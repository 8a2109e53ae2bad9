#include "core/tree_kinematics.hpp"

#include <algorithm>
#include <cmath>

namespace gudgeon {

namespace {

// Euler parameters of A(p) A(r).
Vec4 product(const Vec4& p, const Vec4& r) {
    return {p[0] * r[0] - p[1] * r[1] - p[2] * r[2] - p[3] * r[3],
            p[0] * r[1] + p[1] * r[0] + p[2] * r[3] - p[3] * r[2],
            p[0] * r[2] - p[1] * r[3] + p[2] * r[0] + p[3] * r[1],
            p[0] * r[3] + p[1] * r[2] - p[2] * r[1] + p[3] * r[0]};
}
Vec4 inverse(const Vec4& p) { return {p[0], -p[1], -p[2], -p[3]}; }
Vec4 parameters(const Mat3& frame) {
    const Eigen::Quaterniond x(frame);
    return {x.w(), x.x(), x.y(), x.z()};
}
const Vec4 quarter{0, 0, 0, 1}; // half a turn about b: d/d(s/2) at 0

// h into b, as the frames of universal joints lie in the pose as given: (h, t, b) of the body = (b, -t, h).
Mat3 universal_frame() {
    Mat3 m;
    m << 0, 0, 1, 0, -1, 0, 1, 0, 0;
    return m;
}

// Near unit length already: one step of Newton's method for 1/|p|.
void to_unit(Vec4& p) { p *= 1.5 - 0.5 * p.squaredNorm(); }

bool is_turned_about_b(TreeKind kind) {
    return kind == TreeKind::revolute || kind == TreeKind::cylindrical || kind == TreeKind::planar;
}

} // namespace

TreeKinematics::TreeKinematics(const System& system)
    : system_(system), tree_(spanning_tree(system)), geometry_(tree_.links.size()),
      closure_(tree_.links.size()) {
    for (std::size_t i = 0; i < geometry_.size(); ++i)
        set_geometry(i);
}

void TreeKinematics::set_geometry(std::size_t link) {
    const TreeLink& x = tree_.links[link];
    Geometry& g = geometry_[link];
    const int ground = static_cast<int>(tree_.links.size());
    g = {x.kind,           x.body,       x.parent,         x.parent_link < 0 ? ground : x.parent_link,
         x.coordinate,     x.speed,      Vec3::Zero(),     Vec3::Zero(),
         Mat3::Identity(), Vec3::Zero(), Vec4(1, 0, 0, 0), Vec4::Zero(),
         Vec4::Zero(),     Vec4::Zero()};
    if (x.joint < 0)
        return;
    const JointRecord& joint = system_.joints[x.joint];
    const Anchor &parent = x.swapped ? joint.b : joint.a, &body = x.swapped ? joint.a : joint.b;
    g.point_parent = parent.point;
    g.point_body = body.point;
    g.frame_parent = parent.axes;
    g.axis_body = body.axes.col(2);
    const Closure& closure = closure_[link];
    Vec4 half_turn(1, 0, 0, 0);
    if (closure.half_turn > 0) {
        half_turn.setZero();
        half_turn[closure.half_turn] = 1;
    }
    const Vec4 first = parameters(parent.axes), last = inverse(product(parameters(body.axes), half_turn));
    if (x.kind == TreeKind::universal) {
        const Vec4 middle = parameters(universal_frame());
        g.turn0 = closure.sign * product(first, middle);
        g.turn1 = closure.sign * product(product(first, quarter), middle);
        g.second0 = last;
        g.second1 = product(quarter, last);
    } else {
        g.turn0 = closure.sign * product(first, last);
        g.turn1 = closure.sign * product(product(first, quarter), last);
    }
}

// Euler parameters of the body relative to its parent.
inline Vec4 TreeKinematics::relative_turn(const Geometry& g, const double* s) const {
    const auto turned_by = [](double angle, const Vec4& turn0, const Vec4& turn1) -> Vec4 {
        return std::cos(0.5 * angle) * turn0 + std::sin(0.5 * angle) * turn1;
    };
    switch (g.kind) {
    case TreeKind::rigid:
    case TreeKind::translation:
        return g.turn0;
    case TreeKind::revolute:
    case TreeKind::cylindrical:
    case TreeKind::planar:
        return turned_by(s[0], g.turn0, g.turn1);
    case TreeKind::universal:
        return product(turned_by(s[0], g.turn0, g.turn1), turned_by(s[1], g.second0, g.second1));
    case TreeKind::spherical:
        return Eigen::Map<const Vec4>(s).normalized();
    case TreeKind::free:
        break;
    }
    return Eigen::Map<const Vec4>(s + 3).normalized();
}

// The half turn that brings the joint's closed positions nearest to the present one.
void TreeKinematics::choose_closure(std::size_t link, const Vec4& relative) {
    const Geometry& g = geometry_[link];
    const bool fixed = g.kind == TreeKind::rigid || g.kind == TreeKind::translation;
    if (!fixed && !is_turned_about_b(g.kind))
        return;
    Closure best;
    double nearest = 0;
    for (int half_turn = 0; half_turn < (fixed ? 4 : 2); ++half_turn) {
        closure_[link] = {half_turn, 1};
        set_geometry(link);
        const double c = relative.dot(g.turn0), s = fixed ? 0 : relative.dot(g.turn1);
        if (c * c + s * s > nearest + 1e-6) {
            nearest = c * c + s * s;
            best = {half_turn, fixed && c < 0 ? -1 : 1};
        }
    }
    closure_[link] = best;
    set_geometry(link);
}

// Angles over (-2 pi, 2 pi]: their half angles give the sign of the Euler parameters too.
void TreeKinematics::take_angles(const Geometry& g, const Vec4& relative, double* s) const {
    const auto angle = [](const Vec4& x, const Vec4& turn0, const Vec4& turn1) {
        return 2 * std::atan2(x.dot(turn1), x.dot(turn0));
    };
    if (is_turned_about_b(g.kind)) {
        s[0] = angle(relative, g.turn0, g.turn1);
    } else if (g.kind == TreeKind::universal) {
        const Vec3 second = g.frame_parent.transpose() * (rotation(relative) * g.axis_body);
        s[0] = std::atan2(second[1], second[0]);
        const Vec4 first = std::cos(0.5 * s[0]) * g.turn0 + std::sin(0.5 * s[0]) * g.turn1;
        s[1] = angle(product(inverse(first), relative), g.second0, g.second1);
    } else if (g.kind == TreeKind::spherical) {
        Eigen::Map<Vec4> out(s);
        out = relative.normalized();
    }
}

void TreeKinematics::take(const VecX& q, const VecX& u, VecX& s, VecX& w) {
    s.resize(tree_.coordinates);
    w.resize(tree_.speeds);
    std::vector<BodyMotion> motion = system_.start;
    for (int i = 0; i < system_.moving; ++i)
        set_body_motion(q.segment<7>(7 * i), u.segment<6>(6 * i), motion[i]);
    for (std::size_t i = 0; i < geometry_.size(); ++i) {
        const Geometry& g = geometry_[i];
        const BodyMotion &parent = motion[g.parent], &body = motion[g.body];
        double* coordinate = s.data() + g.coordinate;
        if (g.kind == TreeKind::free) {
            Eigen::Map<Eigen::Matrix<double, 7, 1>>(coordinate) << body.r, body.p;
            continue;
        }
        const Vec4 relative = product(inverse(parent.p), body.p);
        choose_closure(i, relative);
        take_angles(g, relative, coordinate);
        const Vec3 d = (parent.A * g.frame_parent).transpose() *
                       (point_position(body, g.point_body) - point_position(parent, g.point_parent));
        if (g.kind == TreeKind::translation)
            coordinate[0] = d[2];
        if (g.kind == TreeKind::cylindrical)
            coordinate[1] = d[2];
        if (g.kind == TreeKind::planar) {
            coordinate[1] = d[0];
            coordinate[2] = d[1];
        }
    }
    w.setZero();
    std::vector<LinkMotion> links = make_links();
    set_motion(s, w, motion, links);
    project(motion, links, u, w);
}

void TreeKinematics::set_motion(const VecX& s, const VecX& w, std::span<BodyMotion> motion,
                                std::span<LinkMotion> links) const {
    const std::size_t n = geometry_.size();
    for (std::size_t i = 0; i < n; ++i) {
        const Geometry& g = geometry_[i];
        const double *coordinate = s.data() + g.coordinate, *speed = w.data() + g.speed;
        BodyMotion& m = motion[g.body];
        LinkMotion& x = links[i];
        if (g.kind == TreeKind::free) {
            m.r = Eigen::Map<const Vec3>(coordinate);
            m.p = Eigen::Map<const Vec4>(coordinate + 3).normalized();
            m.A = rotation(m.p);
            m.v = Eigen::Map<const Vec3>(speed);
            m.w = Eigen::Map<const Vec3>(speed + 3);
            x.axes = m.A;
            x.omega = m.A * m.w;
            continue;
        }
        const BodyMotion& parent = motion[g.parent];
        const LinkMotion& up = links[g.parent_link];
        m.p = product(parent.p, relative_turn(g, coordinate));
        to_unit(m.p);
        m.A = rotation(m.p);
        Vec3 arm = parent.A * g.point_parent; // from the parent's mass centre to P
        Vec3 turning = Vec3::Zero(), sliding = Vec3::Zero(), turning_alpha = Vec3::Zero();
        switch (g.kind) {
        case TreeKind::revolute:
            x.axes.col(0) = parent.A * g.frame_parent.col(2);
            turning = speed[0] * x.axes.col(0);
            break;
        case TreeKind::translation:
            x.axes.col(0) = parent.A * g.frame_parent.col(2);
            arm += coordinate[0] * x.axes.col(0);
            sliding = speed[0] * x.axes.col(0);
            break;
        case TreeKind::cylindrical:
            x.axes.col(0) = parent.A * g.frame_parent.col(2);
            x.axes.col(1) = x.axes.col(0);
            turning = speed[0] * x.axes.col(0);
            arm += coordinate[1] * x.axes.col(1);
            sliding = speed[1] * x.axes.col(1);
            break;
        case TreeKind::universal:
            x.axes.col(0) = parent.A * g.frame_parent.col(2);
            x.axes.col(1) = m.A * g.axis_body;
            turning = speed[0] * x.axes.col(0) + speed[1] * x.axes.col(1);
            turning_alpha = (speed[0] * speed[1]) * x.axes.col(0).cross(x.axes.col(1));
            break;
        case TreeKind::spherical:
            x.axes = m.A;
            turning = m.A * Eigen::Map<const Vec3>(speed);
            break;
        case TreeKind::planar:
            x.axes.col(0) = parent.A * g.frame_parent.col(2);
            x.axes.col(1) = parent.A * g.frame_parent.col(0);
            x.axes.col(2) = parent.A * g.frame_parent.col(1);
            turning = speed[0] * x.axes.col(0);
            arm += coordinate[1] * x.axes.col(1) + coordinate[2] * x.axes.col(2);
            sliding = speed[1] * x.axes.col(1) + speed[2] * x.axes.col(2);
            break;
        case TreeKind::rigid:
        case TreeKind::free:
            break;
        }
        x.from_parent = up.centre + arm;
        x.centre = -(m.A * g.point_body);
        x.omega = up.omega + turning;
        m.r = parent.r + arm + x.centre;
        m.v = parent.v + up.omega.cross(arm) + sliding + x.omega.cross(x.centre);
        m.w = m.A.transpose() * x.omega;
        const Vec3& d = x.from_parent;
        x.alpha = up.alpha + up.omega.cross(turning) + turning_alpha;
        x.a = up.a + up.alpha.cross(d) + up.omega.cross(up.omega.cross(d) + 2 * sliding);
    }
}

void TreeKinematics::store(std::span<const BodyMotion> motion, VecX& q, VecX& u) const {
    for (int i = 0; i < system_.moving; ++i) {
        const BodyMotion& m = motion[i];
        q.segment<3>(7 * i) = m.r;
        q.segment<4>(7 * i + 3) = m.p;
        u.segment<3>(6 * i) = m.v;
        u.segment<3>(6 * i + 3) = m.w;
    }
}

namespace {
// What turns or moves alone in a joint: straight(coordinate, speed, count) for coordinates whose rates are
// the speeds, turn(coordinate, speed) for Euler parameters with an angular velocity; numbers within the
// joint.
template <class Straight, class Turn> void for_parts(TreeKind kind, Straight&& straight, Turn&& turn) {
    switch (kind) {
    case TreeKind::free:
        straight(0, 0, 3);
        turn(3, 3);
        break;
    case TreeKind::spherical:
        turn(0, 0);
        break;
    default:
        straight(0, 0, speed_count(kind));
    }
}
} // namespace

void TreeKinematics::rates(const VecX& s, const VecX& w, VecX& out) const {
    for (const Geometry& g : geometry_) {
        const double* speed = w.data() + g.speed;
        double* rate = out.data() + g.coordinate;
        for_parts(
            g.kind, [&](int c, int v, int count) { std::copy_n(speed + v, count, rate + c); },
            [&](int c, int v) {
                Eigen::Map<Vec4>(rate + c) =
                    0.5 * lt_times(s.segment<4>(g.coordinate + c), Eigen::Map<const Vec3>(speed + v));
            });
    }
}

void TreeKinematics::move(const VecX& step, VecX& s) const {
    for (const Geometry& g : geometry_)
        for_parts(
            g.kind,
            [&](int c, int v, int count) {
                s.segment(g.coordinate + c, count) += step.segment(g.speed + v, count);
            },
            [&](int c, int v) {
                auto p = s.segment<4>(g.coordinate + c);
                p = turned(p, step.segment<3>(g.speed + v));
            });
}

void TreeKinematics::difference(const VecX& s, const VecX& s2, VecX& step) const {
    for (const Geometry& g : geometry_)
        for_parts(
            g.kind,
            [&](int c, int v, int count) {
                step.segment(g.speed + v, count) =
                    s.segment(g.coordinate + c, count) - s2.segment(g.coordinate + c, count);
            },
            [&](int c, int v) {
                const int i = g.coordinate + c;
                step.segment<3>(g.speed + v) = -2 * l_times(s.segment<4>(i), s2.segment<4>(i));
            });
}

void TreeKinematics::normalise(VecX& s) const {
    for (const Geometry& g : geometry_)
        for_parts(
            g.kind, [](int, int, int) {}, [&](int c, int) { s.segment<4>(g.coordinate + c).normalize(); });
}

namespace {
// Angular velocity and velocity of the reference point, global.
struct Twist {
    Vec3 turn = Vec3::Zero(), point = Vec3::Zero();
};
} // namespace

void TreeKinematics::project(std::span<const BodyMotion> motion, std::span<const LinkMotion> links,
                             const VecX& u, VecX& w) const {
    const auto twist = [&](int body, const Vec3& centre) -> Twist {
        if (body >= system_.moving)
            return {};
        const Vec3 turn = motion[body].A * u.segment<3>(6 * body + 3);
        return {turn, u.segment<3>(6 * body) - turn.cross(centre)};
    };
    for (std::size_t i = 0; i < geometry_.size(); ++i) {
        const Geometry& g = geometry_[i];
        if (g.kind == TreeKind::free) {
            w.segment<6>(g.speed) = u.segment<6>(6 * g.body);
            continue;
        }
        const LinkMotion& x = links[i];
        const Twist body = twist(g.body, x.centre), parent = twist(g.parent, links[g.parent_link].centre);
        const Vec3 turn = body.turn - parent.turn;
        const Vec3 slide = body.point - parent.point - parent.turn.cross(x.from_parent);
        const Freedoms f = freedoms(g.kind);
        for (int k = 0; k < f.rotations; ++k)
            w[g.speed + k] = x.axes.col(k).dot(turn);
        for (int k = f.rotations; k < f.rotations + f.displacements; ++k)
            w[g.speed + k] = x.axes.col(k).dot(slide);
    }
}

void TreeKinematics::expand(std::span<const BodyMotion> motion, std::span<const LinkMotion> links,
                            const VecX& w, VecX& u) const {
    for (std::size_t i = 0; i < geometry_.size(); ++i) {
        const Geometry& g = geometry_[i];
        if (g.kind == TreeKind::free) {
            u.segment<6>(6 * g.body) = w.segment<6>(g.speed);
            continue;
        }
        const LinkMotion& x = links[i];
        Vec3 turn = Vec3::Zero(), point = Vec3::Zero();
        if (g.parent < system_.moving) {
            turn = motion[g.parent].A * u.segment<3>(6 * g.parent + 3);
            point = u.segment<3>(6 * g.parent) + turn.cross(x.from_parent - links[g.parent_link].centre);
        }
        const Freedoms f = freedoms(g.kind);
        for (int k = 0; k < f.rotations; ++k)
            turn += w[g.speed + k] * x.axes.col(k);
        for (int k = f.rotations; k < f.rotations + f.displacements; ++k)
            point += w[g.speed + k] * x.axes.col(k);
        u.segment<3>(6 * g.body) = point + turn.cross(x.centre);
        u.segment<3>(6 * g.body + 3) = motion[g.body].A.transpose() * turn;
    }
}

void TreeKinematics::products(std::span<const BodyMotion> motion, std::span<const LinkMotion> links,
                              VecX& out) const {
    for (std::size_t i = 0; i < geometry_.size(); ++i) {
        const LinkMotion& x = links[i];
        const int body = geometry_[i].body;
        out.segment<3>(6 * body) = x.a + x.alpha.cross(x.centre) + x.omega.cross(x.omega.cross(x.centre));
        out.segment<3>(6 * body + 3) = motion[body].A.transpose() * x.alpha;
    }
}

// The geometry follows from the closures; the motion is set anew before anything reads it.
void TreeKinematics::visit(Archive& archive) {
    archive(closure_);
    for (std::size_t i = 0; archive.reading() && i < geometry_.size(); ++i)
        set_geometry(i);
}

} // namespace gudgeon

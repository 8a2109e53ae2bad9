// Joint coordinates s and speeds w of a spanning tree, and the motion of the bodies they stand for (AU 5-6).
//
// A body's frame is its parent's, displaced and turned by the joint: A = A_p R(s), r = r_p + A_p x(s), AU's
// product of homogeneous transformations in its parts. With F_p, F_c the joint frames (h, t, b) of parent and
// body, s_p, s_c the joint points, d = P_c - P_p in F_p and Rz the turn about b:
//
//   rigid        R = F_p F_c^T,                   d = 0
//   revolute     R = F_p Rz(s) F_c^T,             d = 0                  w = s'
//   translation  R = F_p F_c^T,                   d = (0, 0, s)          w = s'
//   cylindrical  R = F_p Rz(s1) F_c^T,            d = (0, 0, s2)         w = s'
//   universal    R = F_p Rz(s1) Q Rz(s2) F_c^T,   d = 0                  w = s'; Q turns h into b
//   spherical    R = A(s), Euler parameters,      d = 0                  w: relative, in the body's frame
//   planar       R = F_p Rz(s1) F_c^T,            d = (s2, s3, 0)        w = s'
//   free         s = (r, p), w = (v, omega') as in System
//
// All these joints look the same from both of their bodies, so that F_p is that of the parent whichever of
// the two the joint calls a; coordinates are the tree's own, not those of the outputs.
#pragma once

#include "core/archive.hpp"
#include "core/spanning_tree.hpp"
#include "core/state.hpp"

#include <span>
#include <vector>

namespace gudgeon {

/// Where a body's joint is and how it moves, global. The reference point P of a body is its joint point; of a
/// free body, its mass centre.
struct LinkMotion {
    Mat3 axes = Mat3::Identity();    // directions of the speeds as columns, rotations before displacements
    Vec3 from_parent = Vec3::Zero(); // P - P of the parent, m; from the ground's: any
    Vec3 centre = Vec3::Zero();      // mass centre - P, m
    Vec3 omega = Vec3::Zero();       // rad/s
    Vec3 alpha = Vec3::Zero();       // rad/s2, with w' = 0
    Vec3 a = Vec3::Zero();           // m/s2, of P with w' = 0
};

/// Speeds along directions: so many rotations first, then so many displacements.
struct Freedoms {
    int rotations, displacements;
};
constexpr Freedoms freedoms(TreeKind kind) {
    constexpr std::array<Freedoms, 8> counts{
        {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {2, 0}, {3, 0}, {1, 2}, {3, 3}}};
    return counts[static_cast<std::size_t>(kind)];
}

class TreeKinematics {
  public:
    explicit TreeKinematics(const System& system);

    const SpanningTree& tree() const { return tree_; }
    int coordinates() const { return tree_.coordinates; }
    int speeds() const { return tree_.speeds; }

    /// s and w of a state whose tree joints are closed; what it leaves open there is dropped. Joint frames
    /// are taken as they lie in it (axes may be antiparallel), Euler parameters of bodies keep their signs.
    void take(const VecX& q, const VecX& u, VecX& s, VecX& w);

    /// Room for set_motion(): one per link, and the ground at rest.
    std::vector<LinkMotion> make_links() const { return std::vector<LinkMotion>(tree_.links.size() + 1); }
    /// Poses and velocities of the moving bodies into motion (all bodies) and links. s need not be
    /// normalised.
    void set_motion(const VecX& s, const VecX& w, std::span<BodyMotion> motion,
                    std::span<LinkMotion> links) const;

    /// q and u of the system.
    void store(std::span<const BodyMotion> motion, VecX& q, VecX& u) const;

    /// s' = N(s) w
    void rates(const VecX& s, const VecX& w, VecX& out) const;
    /// s moved along N(s): Euler parameters turned by exact rotations.
    void move(const VecX& step, VecX& s) const;
    /// Along the speeds, the step that moves s2 to s, rotations to first order; s normalised.
    void difference(const VecX& s, const VecX& s2, VecX& step) const;
    /// Euler parameters to unit length.
    void normalise(VecX& s) const;

    // At what set_motion() left, vectors over bodies as u:
    /// Speeds of velocities (or of small displacements) that keep the tree joints: each joint's relative
    /// motion along its freedoms.
    void project(std::span<const BodyMotion> motion, std::span<const LinkMotion> links, const VecX& u,
                 VecX& w) const;
    /// Velocities u = J w.
    void expand(std::span<const BodyMotion> motion, std::span<const LinkMotion> links, const VecX& w,
                VecX& u) const;
    /// Accelerations u' with w' = 0, the velocity products: u' = J w' + this.
    void products(std::span<const BodyMotion> motion, std::span<const LinkMotion> links, VecX& out) const;

    void visit(Archive& archive);

  private:
    /// What does not change: joint points and frames.
    struct Geometry {
        TreeKind kind;
        int body, parent, parent_link; // parent_link: the ground's for fixed parents
        int coordinate, speed;
        Vec3 point_parent, point_body; // body frames
        Mat3 frame_parent;             // F_p in the parent's frame
        Vec3 axis_body;                // second axis of a universal joint, in the body's frame
        Vec4 turn0, turn1;             // Euler parameters of R: cos(s/2) turn0 + sin(s/2) turn1,
        Vec4 second0, second1;         // universal: times the same of its second angle
    };
    /// Which of the joint's equal closures: the body's joint frame turned by half a turn about h, t or b, and
    /// the sign of its Euler parameters.
    struct Closure {
        int half_turn = 0; // 0: none, 1 to 3
        int sign = 1;
        void visit(Archive& archive) { archive(half_turn, sign); }
    };

    void set_geometry(std::size_t link);
    void choose_closure(std::size_t link, const Vec4& relative);
    Vec4 relative_turn(const Geometry& g, const double* s) const;
    void take_angles(const Geometry& g, const Vec4& relative, double* s) const;

    const System& system_;
    SpanningTree tree_;
    std::vector<Geometry> geometry_;
    std::vector<Closure> closure_;
};

} // namespace gudgeon

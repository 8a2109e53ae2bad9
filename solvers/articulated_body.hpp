// Accelerations of an open tree by the articulated-body recursion (Featherstone 2008), linear in its length.
//
// Quantities are global, about the reference points P of core/tree_kinematics.hpp. A body with all that hangs
// on it answers accelerations (alpha, a of P) beyond those with w' = 0 by the wrench of its joint
//
//   [ n ]   [ J    H ] [ alpha ]   [ p_n ]
//   [ f ] = [ H^T  M ] [ a     ] + [ p_f ],        J, M symmetric 3 x 3.
//
// From the tips to the ground, with the joint's directions S, U = I S, D = S^T U,
//
//   w'_0 = -D^-1 S^T p,   I <- I - U D^-1 U^T,   p <- p + U w'_0,
//
// moved to P of the parent and added there; then from the ground to the tips w' = w'_0 - D^-1 U^T (alpha, a).
// Taking accelerations beyond those with w' = 0 saves I times the velocity products at every joint.
#pragma once

#include "core/tree_kinematics.hpp"

#include <span>
#include <vector>

namespace gudgeon {

class ArticulatedBody {
  public:
    ArticulatedBody(const System& system, const SpanningTree& tree);

    /// w' at the tree's last set_motion(). motion: of all bodies; f: forces on them as ws.f (gyroscopic ones
    /// included).
    void solve(std::span<const LinkMotion> links, std::span<const BodyMotion> motion, const VecX& f,
               VecX& speeds);

  private:
    /// Symmetric 3 x 3.
    struct Symmetric {
        double xx, yy, zz, xy, xz, yz;
    };
    struct Body {
        Symmetric J, M;
        Mat3 H;
        Vec3 moment, force; // p; once solved, alpha and a
    };
    struct Joint {
        TreeKind kind;
        int parent, speed, body; // parent: link, -1: the ground
        bool alone;              // free, and nothing hangs on it
    };

    void set_inertia(std::span<const LinkMotion> links, std::span<const BodyMotion> motion, const VecX& f);
    template <int R, int T> void reduce(std::size_t i, const LinkMotion& x, double* speeds);
    template <int R, int T> void expand(std::size_t i, const LinkMotion& x, double* speeds);
    void solve_alone(const Joint& joint, const VecX& f, double* speeds) const;
    void solve_free(std::size_t i, const Mat3& A, double* speeds);
    void add_to_parent(std::size_t i, const Vec3& d);

    const System& system_;
    std::vector<Joint> joints_;
    std::vector<Body> bodies_;
    std::vector<int> place_;      // of a link's factors
    std::vector<double> factors_; // U D^-1: 3 x F of rotations, then of displacements
};

} // namespace gudgeon

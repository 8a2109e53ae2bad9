// Evaluation of a System at one instant: forces, constraints, their derivatives, energies.
#pragma once

#include "core/sparse.hpp"
#include "core/state.hpp"

#include <complex>
#include <span>

namespace gudgeon {

/// Poses and velocities of all moving bodies into ws.motion. q need not be normalised.
void set_motion(const System& system, const VecX& q, const VecX& u, Workspace& ws);

Evaluation evaluation(const System& system, Workspace& ws, double t);

/// ws.f = applied, elastic, external, gravity and gyroscopic forces (without reactions).
void evaluate_forces(const System& system, double t, Workspace& ws);

/// ws.phi and ws.rate = G u + dPhi/dt; with lambda, ws.f -= G^T lambda; with_rows also ws.rows = G.
void evaluate_constraints(const System& system, double t, const double* lambda, bool with_rows,
                          Workspace& ws);

/// ws.lin.C = -df/du, ws.lin.S = -df/dq + d(G^T lambda)/dq and ws.rows = G. joined, not zero: ws.lin.C is the
/// sum C + joined S instead, and ws.lin.S empty.
void linearise(const System& system, double t, const double* lambda, Workspace& ws, double joined = 0);

/// Wrench on the second body of each joint, at its joint point, global (N, N m): multipliers times ws.rows,
/// and what bushings, contacts and friction of the joint pass on, at ws.motion.
void joint_wrenches(const System& system, double t, const VecX& lambda, Workspace& ws,
                    std::vector<Wrench>& out);

/// ws.rate_rows = R = d(G u)/dq at ws.motion: how the velocity constraints change with the pose.
void evaluate_rate_rows(const System& system, double t, Workspace& ws);

/// out = M x, x and out 6 per moving body (may be the same vector).
void mass_times(const System& system, const VecX& x, VecX& out);
/// out = M^-1 x
void inverse_mass_times(const System& system, const VecX& x, VecX& out);

/// out += factor G^T x and out = G x from ws.rows.
void add_transposed_rows(const System& system, const Workspace& ws, const VecX& x, double factor, VecX& out);
void rows_times(const System& system, const Workspace& ws, const VecX& x, VecX& out);
/// out = R x from ws.rate_rows.
void rate_rows_times(const System& system, const Workspace& ws, const VecX& x, VecX& out);

/// out = S x (or C x) with blocks as in ws.lin.
void blocks_times(const System& system, const std::vector<double>& blocks, const VecX& x, VecX& out);

/// |x|^T |S| |x| with ws.lin.S: what cancels in x^T S x.
double cancelling_stiffness(const System& system, const Workspace& ws, const VecX& x);

/// q moved along T(q): positions by dx, orientations turned by the body-frame vector dtheta.
void move(const System& system, const VecX& step, VecX& q);

struct Energies {
    double kinetic = 0, potential = 0, elastic = 0;
    double dissipated_power = 0, input_power = 0;
    double mechanical() const { return kinetic + potential + elastic; }
};
/// Energies and powers at ws.motion; lambda gives the power of the drives. Potential energy is zero at
/// the global origin's height.
Energies energies(const System& system, double t, const double* lambda, Workspace& ws);

/// Powers as State::work counts them, at ws.motion; fills ws.samples where there are contacts, unless they
/// are known already.
void powers(const System& system, double t, const double* lambda, Workspace& ws, VecX& out,
            bool sampled = false);

/// ws.samples: all contacts at ws.motion.
void sample_contacts(const System& system, double t, Workspace& ws);

/// What touches in a joint.
struct JointContact {
    double penetration = 0;    // m or rad, the deepest now
    double normal_force = 0;   // N (N m where only rotations touch), of the resultant
    double friction_force = 0; // likewise
    int touching = 0;          // contacts that touch now
};

/// ws.samples gathered by joint, in the order of System::contact_joints.
std::vector<JointContact> joint_contacts(const System& system, const Workspace& ws);

/// z' = source - decay z of the friction states at ws.motion.
void state_terms(const System& system, double t, Workspace& ws, VecX& source, VecX& decay);

/// Current values of all angle measures, on the branch of the memory.
void update_angles(const System& system, double t, const Workspace& ws, AngleMemory& angles);

/// Whether rows of G may repeat each other.
enum class Rows { independent, soft };

/// The saddle-point matrix K = [a M + C + s S, G^T; G, -E]: fixed pattern, values to known slots.
///
/// E = 0 for independent rows. Soft rows have a small diagonal E, `softness` times that of G D^-1 G^T with D
/// the diagonal of the leading block: rows that repeat others, always or for an instant, leave K regular.
/// E acts on changes of the multipliers only, so that sweeps still end at residuals of zero.
class SaddleMatrix {
  public:
    static constexpr double softness = 1e-8;

    explicit SaddleMatrix(const System& system, Rows rows = Rows::independent);
    const CscPattern& pattern() const { return pattern_; }
    /// Lets go of the pattern, which assembly does not read: where a solver has made its own of it.
    void forget_pattern() { pattern_ = {}; }
    /// Every slot is written. Reads ws.lin and ws.rows. Where C + s S are joined in ws.lin, it was with this
    /// s.
    void assemble(const System& system, const Workspace& ws, double a, double s,
                  std::span<double> values) const;
    void assemble(const System& system, const Workspace& ws, std::complex<double> a, std::complex<double> s,
                  std::span<std::complex<double>> values) const;
    /// a M only in the leading block (acceleration equations).
    void assemble_mass(const System& system, const Workspace& ws, double a, std::span<double> values) const;

    /// E of assembled values times a factor.
    void scale_softness(double factor, std::span<double> values) const;
    /// out = E x from assembled values; zero for independent rows.
    void soft_times(std::span<const double> values, const VecX& x, Eigen::Ref<VecX> out) const;

  private:
    void build_pattern(const System& system, Rows rows);
    int diagonal_slot(int body, int k) const;
    template <class Scalar> void soften(const System& system, std::span<Scalar> values) const;
    template <class Scalar>
    void assemble_scalars(const System& system, const Workspace& ws, Scalar a, Scalar s,
                          std::span<Scalar> values) const;
    template <class Scalar>
    void place_rows(const System& system, std::span<const double> rows, int threads,
                    std::span<Scalar> values) const;

    CscPattern pattern_;
    std::vector<int> block_slot_;    // three per block: slot of its first row in each column, -1: inactive
    std::vector<int> mass_slot_;     // three per body: diagonal of the translation block
    std::vector<int> lower_, upper_; // twelve per row: slots of G and G^T, -1: none
    std::vector<int> soft_slot_;     // of -E, one per row; empty for independent rows
};

} // namespace gudgeon

// Weighted norm of coordinate and velocity errors: the worst body counts, so that control does not
// depend on how many other bodies a scene has. Each friction state counts like a body with one coordinate;
// its absolute tolerance is atol times System::state_scales, a change of the friction coefficient by atol.
#pragma once

#include "core/archive.hpp"
#include "core/system.hpp"

#include <cmath>

namespace gudgeon {

class ErrorNorm {
  public:
    ErrorNorm(const System& system, double rtol, double atol, int threads = 1);

    /// Weights 1 / (rtol |y| + atol) at a state.
    void set_scale(const VecX& q, const VecX& u, const VecX& z = VecX());

    struct Value {
        double norm = 0;    // root mean square over the 13 numbers of the worst body
        int body = -1;      // none: a friction state
        int component = -1; // of that body, the one with the largest share; named by component_name()
        void visit(Archive& archive) { archive(norm, body, component); }
    };
    /// Of a difference (q - q2, u - u2) times factor.
    Value difference(const VecX& q, const VecX& q2, const VecX& u, const VecX& u2, double factor) const;
    /// Of an increment along T(q): step and velocity change, 6 per body each.
    Value increment(const double* step, const double* du) const;
    /// Of rates (q', u').
    Value rates(const VecX& q, const VecX& u) const;
    /// Of changes of the friction states.
    Value states(const VecX& dz) const;
    /// "x", ..., "orientation", "vx", ..., "wz"
    static const char* component_name(int component);
    static Value worse(const Value& x, const Value& y) {
        return x.norm >= y.norm || std::isnan(x.norm) ? x : y;
    }

    void visit(Archive& archive) { archive(q_weight_, u_weight_, z_weight_); }

  private:
    int moving_, threads_;
    double rtol_, atol_;
    VecX q_weight_, u_weight_, z_weight_;
    std::vector<double> z_scale_;
};

} // namespace gudgeon

// Constraint kernels: the rows from which every perfect joint is built (AP 7-10, corrected).
//
// A kernel binds one measure of relative_motion.hpp to an element; ConstraintBatchOf turns it into a
// batch. Rows read Phi = measure - prescribed value, the prescribed value being 0, a constant, or a
// function of time (drives).
#pragma once

#include "core/batch.hpp"
#include "core/block_layout.hpp"
#include "core/time_function.hpp"

#include <utility>

namespace gudgeon {

/// Common part of all constraint elements.
struct ConstraintElement {
    int a = 0, b = 0; // bodies
    int row = 0;      // first row
    int pair = 0;     // blocks of the geometric stiffness
};

/// P_a and P_b coincide: three rows, global components.
struct CoincidentKernel {
    struct Element : ConstraintElement {
        Vec3 sa, sb; // points, body frames
    };
    static constexpr int rows = 3;
    static constexpr CouplingMask coupling = point_difference::coupling;
    static Vec3 value(const Evaluation& e, const Element& x) {
        return point_difference::value(e.body[x.a], e.body[x.b], x.sa, x.sb);
    }
    static Gradient<3> gradient(const Evaluation& e, const Element& x) {
        return point_difference::gradient(e.body[x.a], e.body[x.b], x.sa, x.sb);
    }
    /// gradient().times(velocities)
    static Vec3 rate(const Evaluation& e, const Element& x) {
        return point_velocity(e.body[x.b], x.sb) - point_velocity(e.body[x.a], x.sa);
    }
    /// -gradient()^T lambda on the two bodies
    static PairWrench reaction(const Evaluation& e, const Element& x, const Vec3& lambda) {
        return {lambda, x.sa.cross(e.body[x.a].A.transpose() * lambda), -lambda,
                (e.body[x.b].A.transpose() * lambda).cross(x.sb)};
    }
    static Gradient<3> rate_gradient(const Evaluation& e, const Element& x) {
        return point_difference::rate_gradient(e.body[x.a], e.body[x.b], x.sa, x.sb);
    }
    static void add_geometric(const Evaluation& e, const Element& x, const Vec3& g, BlockMatrix& out) {
        point_difference::add_geometric(e.body[x.a], e.body[x.b], x.sa, x.sb, g, out);
    }
};

using Scalar1 = Eigen::Matrix<double, 1, 1>;

/// x . d = 0 with x fixed in a: no displacement along x.
struct DisplacementKernel {
    struct Element : ConstraintElement {
        Vec3 sa, sb, x;
    };
    static constexpr int rows = 1;
    static constexpr CouplingMask coupling = displacement::coupling;
    static Scalar1 value(const Evaluation& e, const Element& x) {
        return Scalar1(displacement::value(e.body[x.a], e.body[x.b], x.sa, x.sb, x.x));
    }
    static Gradient<1> gradient(const Evaluation& e, const Element& x) {
        return displacement::gradient(e.body[x.a], e.body[x.b], x.sa, x.sb, x.x);
    }
    static Gradient<1> rate_gradient(const Evaluation& e, const Element& x) {
        return displacement::rate_gradient(e.body[x.a], e.body[x.b], x.sa, x.sb, x.x);
    }
    static void add_geometric(const Evaluation& e, const Element& x, const Scalar1& g, BlockMatrix& out) {
        displacement::add_geometric(e.body[x.a], e.body[x.b], x.sa, x.sb, g[0] * x.x, out);
    }
};

/// x . d = f(t)
struct DrivenDisplacementKernel : DisplacementKernel {
    struct Element : DisplacementKernel::Element {
        TimeFunction function;
    };
};

/// x . y = 0 with x fixed in a, y in b.
struct AlignmentKernel {
    struct Element : ConstraintElement {
        Vec3 x, y;
    };
    static constexpr int rows = 1;
    static constexpr CouplingMask coupling = alignment::coupling;
    static Scalar1 value(const Evaluation& e, const Element& x) {
        return Scalar1(alignment::value(e.body[x.a], e.body[x.b], x.x, x.y));
    }
    static Gradient<1> gradient(const Evaluation& e, const Element& x) {
        return alignment::gradient(e.body[x.a], e.body[x.b], x.x, x.y);
    }
    static Gradient<1> rate_gradient(const Evaluation& e, const Element& x) {
        return alignment::rate_gradient(e.body[x.a], e.body[x.b], x.x, x.y);
    }
    static void add_geometric(const Evaluation& e, const Element& x, const Scalar1& g, BlockMatrix& out) {
        alignment::add_geometric(e.body[x.a], e.body[x.b], x.x, x.y, g[0], out);
    }
};

/// |P_b - P_a| = length
struct DistanceKernel {
    struct Element : ConstraintElement {
        Vec3 sa, sb;
        double length;
    };
    static constexpr int rows = 1;
    static constexpr CouplingMask coupling = distance::coupling;
    static Scalar1 value(const Evaluation& e, const Element& x) {
        return Scalar1(distance::value(e.body[x.a], e.body[x.b], x.sa, x.sb) - x.length);
    }
    static Gradient<1> gradient(const Evaluation& e, const Element& x) {
        return distance::gradient(e.body[x.a], e.body[x.b], x.sa, x.sb);
    }
    static Gradient<1> rate_gradient(const Evaluation& e, const Element& x) {
        return distance::rate_gradient(e.body[x.a], e.body[x.b], x.sa, x.sb);
    }
    static void add_geometric(const Evaluation& e, const Element& x, const Scalar1& g, BlockMatrix& out) {
        distance::add_geometric(e.body[x.a], e.body[x.b], x.sa, x.sb, g[0], out);
    }
};

/// Unwrapped angle = f(t)
struct DrivenAngleKernel {
    struct Element : ConstraintElement {
        AngleFrames frames;
        int angle; // number in System::angles
        TimeFunction function;
    };
    static constexpr int rows = 1;
    static constexpr CouplingMask coupling = angle::coupling;
    static Scalar1 value(const Evaluation& e, const Element& x) {
        return Scalar1(angle::value(e.body[x.a], e.body[x.b], x.frames, e.angle_reference(x.angle)));
    }
    static Gradient<1> gradient(const Evaluation& e, const Element& x) {
        return angle::gradient(e.body[x.a], e.body[x.b], x.frames);
    }
    static Gradient<1> rate_gradient(const Evaluation& e, const Element& x) {
        return angle::rate_gradient(e.body[x.a], e.body[x.b], x.frames);
    }
    static void add_geometric(const Evaluation& e, const Element& x, const Scalar1& g, BlockMatrix& out) {
        angle::add_geometric(e.body[x.a], e.body[x.b], x.frames, g[0], out);
    }
};

template <class Kernel> class ConstraintBatchOf final : public ConstraintBatch {
  public:
    using Element = typename Kernel::Element;
    static constexpr int R = Kernel::rows;
    using Rows = Eigen::Matrix<double, R, 1>;

    void add(Element element) { elements_.items().push_back(std::move(element)); }

    int size() const override { return static_cast<int>(elements_.items().size()); }

    void finish(BlockLayoutBuilder& layout) override {
        elements_.colour(layout.moving());
        for (Element& x : elements_.items())
            x.pair = layout.pair(x.a, x.b, Kernel::coupling);
    }

    void evaluate(const Evaluation& e, const ConstraintSink& sink) const override {
        elements_.for_each(e.threads, [&](const Element& x) {
            if constexpr (requires { &Kernel::reaction; })
                if (!sink.rows)
                    return evaluate_quickly(e, x, sink);
            const TimeValue drive = prescribed(x, e.t);
            const Gradient<R> g = Kernel::gradient(e, x);
            if (sink.phi) {
                const Rows phi = Kernel::value(e, x);
                for (int k = 0; k < R; ++k)
                    sink.phi[x.row + k] = phi[k] - drive.value;
            }
            if (sink.rate) {
                const Rows rate = g.times(e.body[x.a], e.body[x.b]);
                for (int k = 0; k < R; ++k)
                    sink.rate[x.row + k] = rate[k] - drive.rate;
            }
            if (sink.rows)
                store(g, sink.rows + 12 * static_cast<std::ptrdiff_t>(x.row));
            if (sink.lambda) {
                const Rows l = Eigen::Map<const Rows>(sink.lambda + x.row);
                sink.f.add(x.a, -(g.ra.transpose() * l), -(g.ta.transpose() * l));
                sink.f.add(x.b, -(g.rb.transpose() * l), -(g.tb.transpose() * l));
            }
        });
    }

    void acceleration_rhs(const Evaluation& e, double* gamma) const override {
        elements_.for_each(e.threads, [&](const Element& x) {
            const Rows drift = Kernel::rate_gradient(e, x).times(e.body[x.a], e.body[x.b]);
            const TimeValue drive = prescribed(x, e.t);
            for (int k = 0; k < R; ++k)
                gamma[x.row + k] = drive.acceleration - drift[k];
        });
    }

    void add_geometric(const Evaluation& e, const double* lambda, Linearisation& lin) const override {
        elements_.for_each(e.threads, [&](const Element& x) {
            BlockMatrix blocks;
            blocks.set_zero();
            Kernel::add_geometric(e, x, Eigen::Map<const Rows>(lambda + x.row), blocks);
            lin.add_stiffness(x.pair, Kernel::coupling, blocks);
        });
    }

    void rate_gradient(const Evaluation& e, double* rows) const override {
        elements_.for_each(e.threads, [&](const Element& x) {
            store(Kernel::rate_gradient(e, x), rows + 12 * static_cast<std::ptrdiff_t>(x.row));
        });
    }

    void time_rate(const Evaluation& e, double* out) const override {
        for (const Element& x : elements_.items())
            for (int k = 0; k < R; ++k)
                out[x.row + k] = -prescribed(x, e.t).rate;
    }

    double drive_power(const Evaluation& e, const double* lambda) const override {
        double sum = 0;
        if constexpr (requires(Element x) { x.function; })
            for (const Element& x : elements_.items())
                for (int k = 0; k < R; ++k)
                    sum -= lambda[x.row + k] * prescribed(x, e.t).rate;
        return sum;
    }

  private:
    /// Without the rows, where the kernel has its rate and its reaction at hand; nothing prescribed.
    static void evaluate_quickly(const Evaluation& e, const Element& x, const ConstraintSink& sink) {
        if (sink.phi)
            Eigen::Map<Rows>(sink.phi + x.row) = Kernel::value(e, x);
        if (sink.rate)
            Eigen::Map<Rows>(sink.rate + x.row) = Kernel::rate(e, x);
        if (sink.lambda) {
            const PairWrench w = Kernel::reaction(e, x, Eigen::Map<const Rows>(sink.lambda + x.row));
            sink.f.add(x.a, w.force_a, w.moment_a);
            sink.f.add(x.b, w.force_b, w.moment_b);
        }
    }

    static TimeValue prescribed(const Element& x, double t) {
        if constexpr (requires { x.function; })
            return gudgeon::evaluate(x.function, t);
        else
            return {};
    }
    static void store(const Gradient<R>& g, double* rows) {
        for (int k = 0; k < R; ++k)
            for (int part = 0; part < 4; ++part)
                for (int i = 0; i < 3; ++i)
                    rows[12 * k + 3 * part + i] = g.part(part)(k, i);
    }

    ColouredElements<Element> elements_;
};

} // namespace gudgeon

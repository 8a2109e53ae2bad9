// Turns a force kernel into a batch. A kernel is a struct with
//   Element          with members a, b (bodies), pair (int, filled here), joint (int, -1: none)
//   coupling         which blocks it can fill
//   wrench           (Evaluation, Element) -> PairWrench
//   linearise        (Evaluation, Element, BlockMatrix& C, BlockMatrix& S): adds -d/du and -d/dq
//   energies         (Evaluation, Element) -> EnergyRates
#pragma once

#include "core/batch.hpp"
#include "core/block_layout.hpp"

#include <cmath>
#include <utility>

namespace gudgeon {

/// Common part of all force elements.
struct ForceElement {
    int a = 0, b = 0;     // bodies
    int pair = 0;         // blocks of the derivatives, filled by the batch
    int joint = -1;       // joint whose reaction this is
    bool swapped = false; // a is the joint's second body
    int name = -1;        // in the batch's list of names, -1: none
};

template <class Kernel> class ForceBatchOf : public ForceBatch {
  public:
    using Element = typename Kernel::Element;

    /// name: of a force of the model; elements of joints have none.
    void add(Element element, const std::string& name = {}) {
        if (!name.empty()) {
            element.name = static_cast<int>(names_.size());
            names_.push_back(name);
        }
        elements_.items().push_back(std::move(element));
    }
    const std::vector<Element>& elements() const { return elements_.items(); }

    const char* kind() const override { return Kernel::name; }
    int size() const override { return static_cast<int>(elements_.items().size()); }

    void finish(BlockLayoutBuilder& layout) override {
        elements_.colour(layout.moving());
        for (Element& x : elements_.items())
            x.pair = layout.pair(x.a, x.b, Kernel::coupling);
    }

    void add_forces(const Evaluation& e, ForceSink f) const override {
        elements_.for_each(e.threads, [&](const Element& x) {
            const PairWrench w = Kernel::wrench(e, x);
            f.add(x.a, w.force_a, w.moment_a);
            f.add(x.b, w.force_b, w.moment_b);
        });
    }

    void add_linearisation(const Evaluation& e, Linearisation& lin) const override {
        elements_.for_each(e.threads, [&](const Element& x) {
            BlockMatrix c, s;
            c.set_zero();
            s.set_zero();
            Kernel::linearise(e, x, c, s);
            lin.add_damping(x.pair, Kernel::coupling, c);
            lin.add_stiffness(x.pair, Kernel::coupling, s);
        });
    }

    EnergyRates energies(const Evaluation& e) const override {
        EnergyRates sum;
        for (const Element& x : elements_.items())
            sum += Kernel::energies(e, x);
        return sum;
    }

    void add_joint_wrenches(const Evaluation& e, std::span<Wrench> wrenches) const override {
        for (const Element& x : elements_.items()) {
            if (x.joint < 0)
                continue;
            const PairWrench w = Kernel::wrench(e, x);
            const bool swapped = x.swapped;
            wrenches[x.joint].force += swapped ? w.force_a : w.force_b;
            wrenches[x.joint].moment += swapped ? w.moment_a : w.moment_b;
        }
    }

    std::optional<ElementName> find_bad(const Evaluation& e) const override {
        for (const Element& x : elements_.items()) {
            const PairWrench w = Kernel::wrench(e, x);
            const EnergyRates r = Kernel::energies(e, x);
            BlockMatrix c, s;
            c.set_zero();
            s.set_zero();
            Kernel::linearise(e, x, c, s);
            bool good = w.force_a.allFinite() && w.moment_a.allFinite() && w.force_b.allFinite() &&
                        w.moment_b.allFinite() && std::isfinite(r.elastic) &&
                        std::isfinite(r.dissipated_power) && std::isfinite(r.input_power);
            for (int i = 0; i < 4; ++i)
                for (int j = 0; j < 4; ++j)
                    good = good && c.block[i][j].allFinite() && s.block[i][j].allFinite();
            if (!good)
                return ElementName{x.name < 0 ? "" : names_[x.name], x.joint, x.a, x.b};
        }
        return {};
    }

  protected:
    ColouredElements<Element> elements_;
    std::vector<std::string> names_;
};

/// -B^T g on the two bodies: the wrench of a force g conjugate to a measure with gradient B.
template <int R> PairWrench conjugate_wrench(const Gradient<R>& b, const Eigen::Matrix<double, R, 1>& g) {
    return {-(b.ra.transpose() * g), -(b.ta.transpose() * g), -(b.rb.transpose() * g),
            -(b.tb.transpose() * g)};
}

/// out += left^T right over all parts.
template <int R>
inline void add_product(const Gradient<R>& left, const Gradient<R>& right, BlockMatrix& out) {
    for (int i = 0; i < 4; ++i)
        for (int j = 0; j < 4; ++j)
            out.block[i][j] += left.part(i).transpose().lazyProduct(right.part(j));
}

/// out += left^T right for measures of a difference of positions: ra = -rb on both sides.
inline void add_difference_product(const Gradient<3>& left, const Gradient<3>& right, BlockMatrix& out) {
    for (int i = 1; i < 4; ++i)
        for (int j = 1; j < 4; ++j) {
            const Mat3 m = left.part(i).transpose().lazyProduct(right.part(j));
            out.block[i][j] += m;
            if (i == 2)
                out.block[0][j] -= m;
            if (j == 2)
                out.block[i][0] -= m;
            if (i == 2 && j == 2)
                out.block[0][0] += m;
        }
}

/// x f + y g
template <int R> Gradient<R> combined(double x, const Gradient<R>& f, double y, const Gradient<R>& g) {
    return {x * f.ra + y * g.ra, x * f.ta + y * g.ta, x * f.rb + y * g.rb, x * f.tb + y * g.tb};
}

} // namespace gudgeon

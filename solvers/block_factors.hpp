// Factors of a saddle-point matrix, real or complex, by block elimination.
#pragma once

#include "core/archive.hpp"
#include "solvers/block_structure.hpp"

#include <complex>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace gudgeon {

/// Fronts are assembled, eliminated by dense kernels and stored as three dense blocks each (inverse of the
/// pivot block, and it times both couplings), which solve() passes through once forwards and once backwards.
/// Pivots are chosen inside a front only, and unknowns scaled by powers of two (same for rows and columns).
/// Nothing is allocated after the first factor() and the first solve() of as many columns, but for the first
/// change of precision.
template <class Scalar> class BlockFactors {
  public:
    /// threads: for the subtrees; the same bits for any number. single_precision: factors are kept as such
    /// (their arithmetic stays double) while the pivots are large; solutions are then good to four to six
    /// digits, which sweeps that form residuals anew do not notice, at half the memory.
    BlockFactors(std::shared_ptr<const BlockStructure> structure, int threads = 1,
                 bool single_precision = false);

    /// What a factorisation was like. Not usable: a front without pivot, in unknown (old number) `column`.
    struct Quality {
        bool usable = false;
        double smallest_pivot = 0; // of the scaled matrix, at most 1
        int column = -1;           // of that pivot
    };
    Quality factor(std::span<const Scalar> values);

    /// In place, unknowns x columns, column by column.
    void solve(std::span<Scalar> rhs, int columns);

    /// Allocates, so for doubtful matrices: largest residual of K x = K e over its largest terms, e of +1 and
    /// -1 in the scaled unknowns.
    double backward_error(std::span<const Scalar> values);

    /// The factors themselves: loading gives the same bits.
    void visit(Archive& archive);

    bool in_single_precision() const { return in_single_; }
    const BlockStructure& structure() const { return *structure_; }
    std::shared_ptr<const BlockStructure> shared_structure() const { return structure_; }

  private:
    static constexpr int planes = std::is_same_v<Scalar, double> ? 1 : 2;

    /// What the elimination of one part works with.
    struct Bench {
        std::vector<double> front, scale; // being eliminated
        std::vector<double> updates;      // stack of B - L P^-1 U of fronts whose parent waits
        std::vector<double> product, gathered;
        std::vector<int> swaps;
        Quality quality;
    };

    template <class Visit> void for_subtrees(Visit&& visit);
    void find_scale(std::span<const Scalar> values);
    void factor_part(int part, std::span<const Scalar> values);
    void assemble(const Front& front, std::span<const Scalar> values, Bench& bench) const;
    void add_children(const Front& front, Bench& bench) const;
    template <class Stored> void keep(const Front& front, std::vector<Stored>& factors, Bench& bench);
    Quality factor_once(std::span<const Scalar> values);
    void load(int first, int last, std::span<const Scalar> rhs, int columns);
    void unload(int first, int last, std::span<Scalar> rhs, int columns) const;
    template <class Stored> void forward(int part, const std::vector<Stored>& factors, int columns);
    template <class Stored> void backward(int part, const std::vector<Stored>& factors, int columns);
    template <class Stored>
    void substitute(const std::vector<Stored>& factors, std::span<Scalar> rhs, int columns);
    void reserve_columns(int columns);

    std::shared_ptr<const BlockStructure> structure_;
    std::vector<double> scale_; // of each unknown, new numbering
    // of each front: [P^-1; -L P^-1] (height x pivots), P^-1 U (pivot height x boundary); one of both in use
    std::vector<float> single_;
    std::vector<double> double_;
    bool may_be_single_, in_single_;
    std::vector<Bench> benches_; // of each part
    std::vector<double> x_; // right-hand sides in elimination order, then the subtrees' sums; planes in a row
    int threads_;
};

extern template class BlockFactors<double>;
extern template class BlockFactors<std::complex<double>>;

} // namespace gudgeon

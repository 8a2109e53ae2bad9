// Block elimination of saddle-point matrices: which unknowns are eliminated together, in which order, and
// where every entry goes.
#pragma once

#include "core/sparse.hpp"

#include <span>
#include <vector>

namespace gudgeon {

/// One dense front: `pivots` unknowns eliminated together, then `boundary` unknowns they are coupled with.
struct Front {
    int first = 0;    // its pivots are the unknowns first ... first + pivots - 1 of the new numbering
    int pivots = 0;   // a body, and the constraint rows whose last body it is
    int boundary = 0; // unknowns of later fronts
    int boundary_start = 0;
    int entry_start = 0, row_end = 0, entry_end = 0; // into BlockStructure::entries; those of G^T first
    int last_child = -1;                             // front
    int part = 0;                                    // of BlockStructure::parts
    long factor_start = 0;                           // into the factors, in numbers
    long update_start = 0;                           // into its part's stack of updates, in numbers
    int size() const { return pivots + boundary; }
    int height() const { return padded(size()); } // rows as stored
    int pivot_height() const { return padded(pivots); }
    static int padded(int n) { return (n + 3) & ~3; } // whole vectors of four doubles
};

/// Fronts that one thread eliminates: a subtree, or, the last part, the trunk that joins the subtrees.
struct FrontPart {
    std::vector<int> fronts; // ascending
    int first = 0, last = 0; // of a subtree: its unknowns, first ... last - 1
    int largest = 0;         // front
    long stack = 0;          // numbers on the stack of updates at its highest
    int sums_start = 0; // of a subtree: where the sums for unknowns of the trunk are gathered (sum_place)
    int root = -1;      // of a subtree
};

/// Entries of the matrix inside their front: 1 + more of one column, one below the other there and in a row
/// among the matrix' values.
struct FrontEntries {
    static constexpr int most = 4, most_slots = 1 << 29;
    int slot : 30; // of the matrix' values, the first
    unsigned more : 2;
    unsigned short row, col; // of the first
    int count() const { return 1 + static_cast<int>(more); }
};

/// Fronts in postorder (children before parents, each subtree together). A row is eliminated with the last of
/// its bodies: with the first, or alone, its pivot could vanish though the matrix is regular; so every
/// leading block is the matrix of a mechanism of its own, and regular where the rows are independent.
struct BlockStructure {
    std::vector<Front> fronts;
    std::vector<FrontEntries> entries;
    std::vector<int> boundary;  // unknowns (new numbering, ascending) of each front
    std::vector<int> sum_place; // the same, but unknowns beyond a subtree are numbered from `unknowns` on
    std::vector<int> boundary_place; // their places in the parent's front
    std::vector<int> parent;         // front, -1: root
    std::vector<int> sibling;        // the child before this one of the same parent, -1: first
    std::vector<int> order;          // order[k]: old number of unknown k
    std::vector<int> diagonal;       // slot of a body's unknown k on the diagonal, -1: of a row
    std::vector<FrontPart> parts;    // the trunk is the last
    int unknowns = 0, leading = 0;   // CscPattern::leading
    int matrix_entries = 0;
    int sums = 0;          // unknowns of the trunk, once for each subtree that adds to them
    int largest = 0;       // front
    long factors = 0;      // numbers stored, with padding (twice as many where they are complex)
    long nonzeros = 0;     // without padding
    double operations = 0; // multiplications of a factorisation

    /// f(row, column, slot) of the matrix' entries [begin, end) of `entries`, by their places in the front.
    template <class F> void for_entries(int begin, int end, F&& f) const {
        for (int e = begin; e < end; ++e)
            for (int i = 0; i < entries[e].count(); ++i)
                f(entries[e].row + i, entries[e].col, entries[e].slot + i);
    }
    /// The unknown (new numbering) at a place of a front.
    int unknown(const Front& front, int place) const {
        return place < front.pivots ? front.first + place
                                    : boundary[front.boundary_start + place - front.pivots];
    }
};

/// pattern: structurally symmetric, unknowns 0 ... leading - 1 are bodies of six, the rest constraint rows
/// (CscPattern::leading). Minimum degree on the graph of bodies, or the bodies' own order if that is less
/// work.
/// Empty (no fronts) where that is much more work than eliminating single unknowns: all rows of a body with
/// hundreds of joints would come into one front.
BlockStructure block_structure(const CscPattern& pattern);

/// The same in a given order of the bodies.
BlockStructure block_structure(const CscPattern& pattern, std::span<const int> body_order);

/// The pattern that the structure was made of.
CscPattern pattern_of(const BlockStructure& structure);

/// Cuts the tree of fronts into subtrees of about equal work; called by block_structure().
void cut_into_parts(BlockStructure& structure);

} // namespace gudgeon

// Subtrees of the block elimination that threads take.

#include "solvers/block_structure.hpp"

#include <algorithm>

namespace gudgeon {

namespace {

constexpr std::size_t most_subtrees = 16;
constexpr double small_work = 1e5; // multiplications; a subtree of less is not worth a part
constexpr double trunk_share = 0.1;

double work_of(const Front& front) { return double(front.pivots) * front.size() * front.size(); }

/// Roots of subtrees: the largest is cut again and again while that makes the parts more even and the trunk
/// stays small. The same for any number of threads, so that sums are made in the same order.
std::vector<int> choose_roots(const BlockStructure& s) {
    const int n = static_cast<int>(s.fronts.size());
    std::vector<double> work(n); // of the subtree
    std::vector<int> roots;
    double total = 0, trunk = 0;
    for (int k = 0; k < n; ++k) {
        work[k] += work_of(s.fronts[k]);
        if (s.parent[k] >= 0)
            work[s.parent[k]] += work[k];
        else {
            roots.push_back(k);
            total += work[k];
        }
    }
    while (roots.size() < most_subtrees && !roots.empty()) {
        const auto largest =
            std::max_element(roots.begin(), roots.end(), [&](int x, int y) { return work[x] < work[y]; });
        const int cut = *largest;
        trunk += work_of(s.fronts[cut]);
        if (work[cut] < std::max(small_work, total / most_subtrees) || trunk > trunk_share * total ||
            s.fronts[cut].last_child < 0)
            break;
        roots.erase(largest);
        for (int c = s.fronts[cut].last_child; c >= 0; c = s.sibling[c])
            roots.push_back(c);
    }
    std::erase_if(roots, [&](int k) { return work[k] < small_work; }); // they go with the trunk
    if (roots.size() < 2)
        roots.clear();
    std::sort(roots.begin(), roots.end());
    return roots;
}

/// Where each front leaves its update: on the stack of its part, popped by a parent of the same part.
void lay_out_stack(BlockStructure& s, FrontPart& part, int index) {
    long top = 0;
    for (const int k : part.fronts) {
        Front& front = s.fronts[k];
        for (int c = front.last_child; c >= 0; c = s.sibling[c])
            if (s.fronts[c].part == index)
                top = std::min(top, s.fronts[c].update_start);
        front.update_start = top;
        top += long(front.boundary) * front.boundary;
        part.stack = std::max(part.stack, top);
        part.largest = std::max(part.largest, front.size());
    }
}

} // namespace

void cut_into_parts(BlockStructure& s) {
    const std::vector<int> roots = choose_roots(s);
    const int trunk = static_cast<int>(roots.size());
    for (Front& front : s.fronts)
        front.part = trunk;
    s.parts.assign(trunk + 1, {});
    for (int i = 0; i < trunk; ++i) {
        FrontPart& part = s.parts[i];
        part.root = roots[i];
        int first = part.root; // of the subtree: down the first children
        while (s.fronts[first].last_child >= 0) {
            first = s.fronts[first].last_child;
            while (s.sibling[first] >= 0)
                first = s.sibling[first];
        }
        for (int k = first; k <= part.root; ++k)
            s.fronts[k].part = i;
        const Front& root = s.fronts[part.root];
        part.first = s.fronts[first].first;
        part.last = root.first + root.pivots;
        part.sums_start = s.unknowns + s.sums;
        s.sums += root.boundary;
    }
    s.sum_place = s.boundary;
    for (std::size_t k = 0; k < s.fronts.size(); ++k) {
        const Front& front = s.fronts[k];
        FrontPart& part = s.parts[front.part];
        part.fronts.push_back(static_cast<int>(k));
        if (front.part == trunk)
            continue;
        const auto begin = s.boundary.begin() + s.fronts[part.root].boundary_start;
        const auto end = begin + s.fronts[part.root].boundary;
        for (int i = front.boundary_start; i < front.boundary_start + front.boundary; ++i)
            if (s.boundary[i] >= part.last) // the root is coupled with it too
                s.sum_place[i] =
                    part.sums_start + static_cast<int>(std::lower_bound(begin, end, s.boundary[i]) - begin);
    }
    for (int i = 0; i <= trunk; ++i)
        lay_out_stack(s, s.parts[i], i);
}

} // namespace gudgeon

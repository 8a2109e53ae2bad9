#include "solvers/block_structure.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <numeric>
#include <stdexcept>

#include <amd.h>

namespace gudgeon {

namespace {

constexpr double own_order_worth = 1.25; // of the least work
constexpr double middle_worth = 1.05;
constexpr int large_front = 128;
constexpr double most_work = 20; // of an elimination of single unknowns, which cannot use vectors

/// Lists of variable length, one after the other.
struct Lists {
    std::vector<int> start{0}, item;
    std::span<const int> operator[](int i) const {
        return {item.data() + start[i], static_cast<std::size_t>(start[i + 1] - start[i])};
    }
    void close() { start.push_back(static_cast<int>(item.size())); }
    int size() const { return static_cast<int>(start.size()) - 1; }
};

void keep_distinct(std::vector<int>& item, int begin) {
    std::sort(item.begin() + begin, item.end());
    item.erase(std::unique(item.begin() + begin, item.end()), item.end());
}

/// Unknowns that always go together: the translation or the rotation of a body (groups 2 b and 2 b + 1), or
/// the rows between the same bodies.
struct Groups {
    std::vector<int> first, of; // first unknown of each group (one more at the end); group of each unknown
    Lists neighbours;           // groups coupled with each
    int bodies = 0;
    int parts() const { return 2 * bodies; }
    bool is_part(int g) const { return g < parts(); }
    int count() const { return static_cast<int>(first.size()) - 1; }
    int size(int g) const { return first[g + 1] - first[g]; }
};

Groups find_groups(const CscPattern& a) {
    if (a.leading < 0 || a.leading % 6)
        throw std::invalid_argument("block elimination: bodies of six unknowns are needed");
    Groups g;
    g.bodies = a.leading / 6;
    g.of.resize(a.cols);
    for (int part = 0; part < g.parts(); ++part) {
        g.first.push_back(3 * part);
        std::fill_n(g.of.begin() + 3 * std::ptrdiff_t(part), 3, part);
    }
    std::vector<int> bodies, last;
    for (int j = a.leading; j < a.cols; ++j) {
        bodies.clear();
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            if (a.row[p] < a.leading)
                bodies.push_back(a.row[p] / 6);
        keep_distinct(bodies, 0);
        if (j == a.leading || bodies != last)
            g.first.push_back(j);
        g.of[j] = static_cast<int>(g.first.size()) - 1;
        last = bodies;
    }
    g.first.push_back(a.cols);
    for (int k = 0; k < g.count(); ++k) {
        const int begin = static_cast<int>(g.neighbours.item.size());
        for (int j = g.first[k]; j < g.first[k + 1]; ++j)
            for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
                if (g.of[a.row[p]] != k)
                    g.neighbours.item.push_back(g.of[a.row[p]]);
        keep_distinct(g.neighbours.item, begin);
        g.neighbours.close();
    }
    return g;
}

/// Bodies coupled by forces or constraints.
Lists body_graph(const Groups& groups) {
    Lists graph;
    for (int b = 0; b < groups.bodies; ++b) {
        const int begin = static_cast<int>(graph.item.size());
        const auto meet = [&](int g) {
            if (groups.is_part(g) && g / 2 != b)
                graph.item.push_back(g / 2);
        };
        for (const int part : {2 * b, 2 * b + 1})
            for (const int g : groups.neighbours[part]) {
                meet(g);
                if (!groups.is_part(g))
                    for (const int other : groups.neighbours[g])
                        meet(other);
            }
        keep_distinct(graph.item, begin);
        graph.close();
    }
    return graph;
}

std::vector<int> minimum_degree(const Lists& graph) {
    std::vector<int> order(graph.size());
    std::iota(order.begin(), order.end(), 0);
    if (!graph.item.empty() && amd_order(graph.size(), graph.start.data(), graph.item.data(), order.data(),
                                         nullptr, nullptr) < AMD_OK)
        throw std::bad_alloc();
    return order;
}

/// Groups of each front, and what they are coupled with when their turn comes.
struct Elimination {
    Lists pivots, boundary; // groups
    std::vector<int> front; // of each group
    std::vector<int> parent;
};

void assign_fronts(const Groups& groups, std::span<const int> body_order, Elimination& e) {
    e.front.assign(groups.count(), -1);
    for (int k = 0; k < groups.bodies; ++k)
        e.front[2 * body_order[k]] = e.front[2 * body_order[k] + 1] = k;
    int fronts = groups.bodies;
    for (int g = groups.parts(); g < groups.count(); ++g) {
        for (const int part : groups.neighbours[g])
            e.front[g] = std::max(e.front[g], e.front[part]);
        if (groups.neighbours[g].empty()) // between fixed bodies
            e.front[g] = fronts++;
    }
    e.pivots.start.assign(fronts + 1, 0);
    for (const int f : e.front)
        ++e.pivots.start[f + 1];
    std::partial_sum(e.pivots.start.begin(), e.pivots.start.end(), e.pivots.start.begin());
    e.pivots.item.resize(groups.count());
    std::vector<int> next(e.pivots.start.begin(), e.pivots.start.end() - 1);
    for (int g = 0; g < groups.count(); ++g)
        e.pivots.item[next[e.front[g]]++] = g;
}

Elimination eliminate(const Groups& groups, std::span<const int> body_order) {
    Elimination e;
    assign_fronts(groups, body_order, e);
    const int fronts = e.pivots.size();
    e.parent.assign(fronts, -1);
    std::vector<int> first_child(fronts, -1), next_child(fronts, -1), seen(groups.count(), -1);
    for (int k = 0; k < fronts; ++k) {
        const int begin = static_cast<int>(e.boundary.item.size());
        const auto meet = [&](int g) {
            if (e.front[g] > k && seen[g] != k) {
                seen[g] = k;
                e.boundary.item.push_back(g);
            }
        };
        for (const int pivot : e.pivots[k])
            for (const int g : groups.neighbours[pivot])
                meet(g);
        for (int c = first_child[k]; c >= 0; c = next_child[c])
            for (int i = e.boundary.start[c]; i < e.boundary.start[c + 1]; ++i)
                meet(e.boundary.item[i]);
        const auto later = [&](int x, int y) { return std::pair(e.front[x], x) < std::pair(e.front[y], y); };
        std::sort(e.boundary.item.begin() + begin, e.boundary.item.end(), later);
        e.boundary.close();
        if (std::ssize(e.boundary.item) == begin)
            continue;
        const int p = e.parent[k] = e.front[e.boundary.item[begin]];
        next_child[k] = first_child[p];
        first_child[p] = k;
    }
    return e;
}

double operations(const Groups& groups, const Elimination& e, int front) {
    double pivots = 0, boundary = 0;
    for (const int g : e.pivots[front])
        pivots += groups.size(g);
    for (const int g : e.boundary[front])
        boundary += groups.size(g);
    return pivots * (pivots + boundary) * (pivots + boundary);
}

double operations(const Groups& groups, const Elimination& e) {
    double sum = 0;
    for (int k = 0; k < e.pivots.size(); ++k)
        sum += operations(groups, e, k);
    return sum;
}

int largest_front(const Groups& groups, const Elimination& e) {
    int largest = 0;
    for (int k = 0; k < e.pivots.size(); ++k) {
        int size = 0;
        for (const auto& part : {e.pivots[k], e.boundary[k]})
            for (const int g : part)
                size += groups.size(g);
        largest = std::max(largest, size);
    }
    return largest;
}

/// Multiplications of an LU of single unknowns in an order of minimum degree.
double scalar_operations(const CscPattern& a) {
    std::vector<int> order(a.cols);
    double info[AMD_INFO];
    if (amd_order(a.cols, a.col_start.data(), a.row.data(), order.data(), nullptr, info) < AMD_OK)
        throw std::bad_alloc();
    return info[AMD_NMULTSUBS_LU];
}

/// Fronts so that every subtree stands together, the parent last.
std::vector<int> postorder(const std::vector<int>& parent) {
    const int n = static_cast<int>(parent.size());
    std::vector<int> first_child(n, -1), next(n, -1), order, stack;
    for (int k = n - 1; k >= 0; --k)
        if (parent[k] >= 0) {
            next[k] = first_child[parent[k]];
            first_child[parent[k]] = k;
        }
    order.reserve(n);
    for (int root = 0; root < n; ++root) {
        if (parent[root] >= 0)
            continue;
        stack.push_back(root);
        while (!stack.empty()) {
            const int k = stack.back();
            if (const int child = first_child[k]; child >= 0) {
                first_child[k] = next[child];
                stack.push_back(child);
            } else {
                order.push_back(k);
                stack.pop_back();
            }
        }
    }
    return order;
}

/// The same elimination with its bodies in postorder of the tree.
Elimination in_postorder(const Groups& groups, const Elimination& e, const std::vector<int>& parent) {
    std::vector<int> bodies;
    bodies.reserve(groups.bodies);
    for (const int k : postorder(parent))
        if (const int g = e.pivots[k].front(); groups.is_part(g))
            bodies.push_back(g / 2);
    return eliminate(groups, bodies);
}

/// The tree hung up in its middle, so that threads find subtrees of about equal work: any front can be the
/// last, the fill stays about the same.
std::vector<int> balanced(const Groups& groups, const Elimination& e) {
    const int n = e.pivots.size();
    std::vector<double> work(n);
    std::vector<int> parent = e.parent;
    double total = 0;
    for (int k = 0; k < n; ++k) {
        work[k] += operations(groups, e, k);
        if (parent[k] >= 0)
            work[parent[k]] += work[k];
        else
            total = std::max(total, work[k]);
    }
    for (int root = 0; root < n; ++root) {
        if (e.parent[root] >= 0 || work[root] < total)
            continue;
        int middle = root; // down to the heaviest child while more than half hangs on it
        for (int k = root; k-- > 0;)
            if (e.parent[k] == middle && work[k] > 0.5 * total)
                middle = k;
        for (int k = middle, above = -1; k >= 0;) {
            const int next = parent[k];
            parent[k] = above;
            above = k;
            k = next;
        }
        break;
    }
    return parent;
}

void number_unknowns(const Groups& groups, const Elimination& e, BlockStructure& s,
                     std::vector<int>& number) {
    number.resize(s.unknowns);
    for (int k = 0; k < e.pivots.size(); ++k) {
        Front front;
        front.first = static_cast<int>(s.order.size());
        for (const int g : e.pivots[k])
            for (int j = groups.first[g]; j < groups.first[g + 1]; ++j) {
                number[j] = static_cast<int>(s.order.size());
                s.order.push_back(j);
            }
        front.pivots = static_cast<int>(s.order.size()) - front.first;
        s.fronts.push_back(front);
    }
}

void place_boundaries(const Groups& groups, const Elimination& e, const std::vector<int>& number,
                      BlockStructure& s) {
    std::vector<int> place(s.unknowns, -1); // in the front of the parent
    for (std::size_t k = 0; k < s.fronts.size(); ++k) {
        Front& front = s.fronts[k];
        front.boundary_start = static_cast<int>(s.boundary.size());
        for (const int g : e.boundary[static_cast<int>(k)])
            for (int j = groups.first[g]; j < groups.first[g + 1]; ++j)
                s.boundary.push_back(number[j]);
        front.boundary = static_cast<int>(s.boundary.size()) - front.boundary_start;
        s.largest = std::max(s.largest, front.size());
        front.factor_start = s.factors;
        s.factors += long(front.height()) * front.pivots + long(front.pivot_height()) * front.boundary;
        s.nonzeros += long(front.size()) * front.pivots + long(front.pivots) * front.boundary;
        s.operations += double(front.pivots) * front.size() * front.size();
    }
    s.sibling.assign(s.fronts.size(), -1);
    for (std::size_t k = 0; k < s.fronts.size(); ++k)
        if (const int p = s.parent[k]; p >= 0) {
            s.sibling[k] = s.fronts[p].last_child;
            s.fronts[p].last_child = static_cast<int>(k);
        }
    s.boundary_place.resize(s.boundary.size());
    for (std::size_t k = 0; k < s.fronts.size(); ++k) {
        if (s.parent[k] < 0)
            continue;
        const Front &front = s.fronts[k], &parent = s.fronts[s.parent[k]];
        for (int i = 0; i < parent.boundary; ++i)
            place[s.boundary[parent.boundary_start + i]] = parent.pivots + i;
        for (int i = 0; i < front.boundary; ++i) {
            const int x = s.boundary[front.boundary_start + i];
            s.boundary_place[front.boundary_start + i] =
                x < parent.first + parent.pivots ? x - parent.first : place[x];
        }
    }
}

/// Each entry to the front of the first of its two unknowns.
void place_entries(const CscPattern& a, const Groups& groups, const Elimination& e,
                   const std::vector<int>& number, BlockStructure& s) {
    const auto front_of = [&](int i, int j) {
        return std::min(e.front[groups.of[i]], e.front[groups.of[j]]);
    };
    const auto in_row = [&](int i, int j) { return i < a.leading && j >= a.leading; }; // of G^T
    if (a.nonzeros() > FrontEntries::most_slots)
        throw std::length_error("block elimination: a matrix of too many entries");
    const auto run = [&](int j, int p) { // entries from p on that stand together in their front too
        int count = 1;
        while (count < FrontEntries::most && p + count < a.col_start[j + 1] &&
               a.row[p + count] == a.row[p] + count && groups.of[a.row[p + count]] == groups.of[a.row[p]])
            ++count;
        return count;
    };
    std::vector<int> next(2 * s.fronts.size() + 1, 0); // per front: entries of G^T, others
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; p += run(j, p))
            ++next[2 * front_of(a.row[p], j) + (in_row(a.row[p], j) ? 1 : 2)];
    std::partial_sum(next.begin(), next.end(), next.begin());
    for (std::size_t k = 0; k < s.fronts.size(); ++k) {
        s.fronts[k].entry_start = next[2 * k];
        s.fronts[k].row_end = next[2 * k + 1];
        s.fronts[k].entry_end = next[2 * k + 2];
    }
    s.matrix_entries = a.nonzeros();
    s.entries.resize(next.back());
    s.diagonal.assign(a.cols, -1);
    const auto place = [&](const Front& front, int x) {
        if (x < front.first + front.pivots)
            return static_cast<unsigned short>(x - front.first);
        const auto begin = s.boundary.begin() + front.boundary_start;
        return static_cast<unsigned short>(front.pivots +
                                           (std::lower_bound(begin, begin + front.boundary, x) - begin));
    };
    for (int j = 0; j < a.cols; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; p += run(j, p)) {
            const int k = front_of(a.row[p], j);
            s.entries[next[2 * k + (in_row(a.row[p], j) ? 0 : 1)]++] = {
                p, static_cast<unsigned>(run(j, p) - 1), place(s.fronts[k], number[a.row[p]]),
                place(s.fronts[k], number[j])};
        }
    for (int j = 0; j < a.leading; ++j)
        for (int p = a.col_start[j]; p < a.col_start[j + 1]; ++p)
            if (a.row[p] == j)
                s.diagonal[number[j]] = p;
}

BlockStructure complete(const CscPattern& a, const Groups& groups, const Elimination& first) {
    const Elimination e = in_postorder(groups, first, first.parent);
    BlockStructure s;
    s.unknowns = a.cols;
    s.leading = a.leading;
    s.parent = e.parent;
    std::vector<int> number;
    number_unknowns(groups, e, s, number);
    place_boundaries(groups, e, number, s);
    if (s.largest > std::numeric_limits<unsigned short>::max())
        throw std::length_error("block elimination: a front of more than 65535 unknowns");
    place_entries(a, groups, e, number, s);
    cut_into_parts(s);
    return s;
}

} // namespace

BlockStructure block_structure(const CscPattern& pattern) {
    const Groups groups = find_groups(pattern);
    std::vector<int> own(groups.bodies);
    std::iota(own.begin(), own.end(), 0);
    const Elimination by_degree = eliminate(groups, minimum_degree(body_graph(groups)));
    const Elimination as_given = eliminate(groups, own);
    const double least = operations(groups, by_degree);
    if (largest_front(groups, by_degree) > large_front && least > most_work * scalar_operations(pattern))
        return {};
    // along the bodies' own order chains are eliminated from the ground outwards, which keeps the pivots
    // large
    if (operations(groups, as_given) < own_order_worth * least)
        return complete(pattern, groups, as_given);
    const Elimination from_middle = in_postorder(groups, by_degree, balanced(groups, by_degree));
    const bool serves = operations(groups, from_middle) < middle_worth * least;
    return complete(pattern, groups, serves ? from_middle : by_degree);
}

BlockStructure block_structure(const CscPattern& pattern, std::span<const int> body_order) {
    const Groups groups = find_groups(pattern);
    std::vector<int> sorted(body_order.begin(), body_order.end());
    std::sort(sorted.begin(), sorted.end());
    for (int i = 0; i < groups.bodies; ++i)
        if (std::ssize(sorted) != groups.bodies || sorted[i] != i)
            throw std::invalid_argument("block elimination: the order is not a permutation of the bodies");
    return complete(pattern, groups, eliminate(groups, body_order));
}

CscPattern pattern_of(const BlockStructure& s) {
    CscPattern out;
    out.rows = out.cols = s.unknowns;
    out.leading = s.leading;
    out.col_start.assign(s.unknowns + 1, 0);
    out.row.resize(s.matrix_entries);
    for (const Front& front : s.fronts)
        s.for_entries(front.entry_start, front.entry_end, [&](int row, int col, int slot) {
            out.row[slot] = s.order[s.unknown(front, row)];
            ++out.col_start[s.order[s.unknown(front, col)] + 1];
        });
    std::partial_sum(out.col_start.begin(), out.col_start.end(), out.col_start.begin());
    return out;
}

} // namespace gudgeon

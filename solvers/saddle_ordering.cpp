#include "solvers/saddle_ordering.hpp"

#include <algorithm>
#include <limits>
#include <new>
#include <utility>

#include <amd.h>

namespace gudgeon {

namespace {

/// Largest matching of multipliers with ordinary unknowns, by augmenting paths (no recursion: chains of
/// thousands of joints can be one path).
class Matching {
  public:
    explicit Matching(const CscPattern& a) : a_(a), partner_(a.cols, -1), multiplier_(a.cols, 1) {
        for (int j = 0; j < a.cols; ++j) {
            const auto begin = a.row.begin() + a.col_start[j], end = a.row.begin() + a.col_start[j + 1];
            if (a.leading < 0 ? std::find(begin, end, j) != end : j < a.leading)
                multiplier_[j] = 0;
        }
        order_candidates();
        visited_.assign(a.cols, -1);
        next_.assign(a.cols, 0);
        for (int i = 0; i < a.cols; ++i)
            if (multiplier_[i])
                augment(i);
    }

    const std::vector<int>& partner() const { return partner_; }
    bool is_multiplier(int i) const { return multiplier_[i] != 0; }

  private:
    /// Candidates with few multipliers first: translations, whose coefficients are constants, come
    /// before rotations, whose coefficients can vanish in some poses.
    void order_candidates() {
        const int n = a_.cols;
        std::vector<int> degree(n, 0);
        for (int i = 0; i < n; ++i)
            for (int p = a_.col_start[i]; multiplier_[i] && p < a_.col_start[i + 1]; ++p)
                ++degree[a_.row[p]];
        start_.assign(n + 1, 0);
        for (int i = 0; i < n; ++i) {
            for (int p = a_.col_start[i]; multiplier_[i] && p < a_.col_start[i + 1]; ++p)
                if (!multiplier_[a_.row[p]])
                    candidate_.push_back(a_.row[p]);
            start_[i + 1] = static_cast<int>(candidate_.size());
            std::stable_sort(candidate_.begin() + start_[i], candidate_.end(),
                             [&](int x, int y) { return degree[x] < degree[y]; });
        }
    }

    static constexpr int dead = std::numeric_limits<int>::max();

    int free_candidate(int i) const {
        for (int p = start_[i]; p < start_[i + 1]; ++p)
            if (partner_[candidate_[p]] < 0)
                return candidate_[p];
        return -1;
    }

    void augment(int root) {
        std::vector<std::pair<int, int>> path; // multiplier, unknown it takes over
        seen_.clear();
        next_[root] = start_[root];
        int i = root;
        while (true) {
            if (const int j = free_candidate(i); j >= 0) {
                marry(i, j);
                for (; !path.empty(); path.pop_back())
                    marry(path.back().first, path.back().second);
                return;
            }
            int taken = -1;
            while (taken < 0 && next_[i] < start_[i + 1]) {
                const int j = candidate_[next_[i]++];
                if (visited_[j] != root && visited_[j] != dead)
                    taken = j;
            }
            if (taken >= 0) {
                visited_[taken] = root;
                seen_.push_back(taken);
                path.emplace_back(i, taken);
                i = partner_[taken];
                next_[i] = start_[i];
            } else if (path.empty()) {
                // nothing free can be reached from here, nor later: rows that repeat others are many
                for (const int j : seen_)
                    visited_[j] = dead;
                return;
            } else {
                i = path.back().first;
                path.pop_back();
            }
        }
    }

    void marry(int i, int j) {
        partner_[i] = j;
        partner_[j] = i;
    }

    const CscPattern& a_;
    std::vector<int> partner_;
    std::vector<char> multiplier_;
    std::vector<int> start_, candidate_; // ordinary unknowns of each multiplier
    std::vector<int> visited_, next_, seen_;
};

std::vector<int> minimum_degree(int n, const std::vector<int>& start, const std::vector<int>& row) {
    std::vector<int> order(n);
    if (n > 0 && amd_order(n, start.data(), row.data(), order.data(), nullptr, nullptr) < AMD_OK)
        throw std::bad_alloc();
    return order;
}

} // namespace

std::vector<int> minimum_degree_ordering(const CscPattern& a) {
    return minimum_degree(a.cols, a.col_start, a.row);
}

std::vector<int> saddle_ordering(const CscPattern& a) {
    const int n = a.cols;
    const Matching matching(a);
    std::vector<int> node(n), first; // node of each unknown, first unknown of each node
    for (int j = 0; j < n; ++j) {
        const int other = matching.partner()[j];
        if (matching.is_multiplier(j) && other >= 0)
            continue;
        node[j] = static_cast<int>(first.size());
        if (other >= 0)
            node[other] = node[j];
        first.push_back(j);
    }
    const int nodes = static_cast<int>(first.size());
    std::vector<int> start(nodes + 1, 0), row, seen(nodes, -1);
    for (int k = 0; k < nodes; ++k) {
        const int members[2] = {first[k], matching.partner()[first[k]]};
        const int begin = static_cast<int>(row.size());
        for (const int j : members)
            for (int p = j < 0 ? 0 : a.col_start[j]; j >= 0 && p < a.col_start[j + 1]; ++p)
                if (const int r = node[a.row[p]]; seen[r] != k) {
                    seen[r] = k;
                    row.push_back(r);
                }
        std::sort(row.begin() + begin, row.end());
        start[k + 1] = static_cast<int>(row.size());
    }
    std::vector<int> perm;
    perm.reserve(n);
    for (const int k : minimum_degree(nodes, start, row)) {
        perm.push_back(first[k]);
        if (const int other = matching.partner()[first[k]]; other >= 0)
            perm.push_back(other);
    }
    return perm;
}

std::vector<std::vector<int>> ordering_candidates(const CscPattern& a) {
    constexpr int largest_trial = 4000;
    std::vector<std::vector<int>> candidates{saddle_ordering(a)};
    if (a.cols <= largest_trial)
        candidates.push_back(minimum_degree_ordering(a));
    return candidates;
}

} // namespace gudgeon

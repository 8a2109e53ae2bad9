#include "core/words.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace gudgeon {

namespace {

/// Edits (insert, remove, replace, exchange of neighbours) between two words.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> before(b.size() + 1), above(b.size() + 1), row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j)
        row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        before = std::exchange(above, row);
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            row[j] = std::min({above[j - 1] + (a[i - 1] != b[j - 1]), above[j] + 1, row[j - 1] + 1});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                row[j] = std::min(row[j], before[j - 2] + 1);
        }
    }
    return row.back();
}

} // namespace

std::string suggestion(std::string_view word, std::span<const std::string> known) {
    const std::string* best = nullptr;
    std::size_t least = word.size() > 4 ? 3 : 2;
    if (word.size() < 100)
        for (const std::string& candidate : known)
            if (const std::size_t d = edit_distance(word, candidate); d < least && d < candidate.size()) {
                least = d;
                best = &candidate;
            }
    return best ? fmt::format("did you mean '{}'? ", *best) : "";
}

std::string listed(std::span<const std::string> words) {
    if (words.empty())
        return "none";
    constexpr std::size_t most = 20;
    std::string out = fmt::format("{}", fmt::join(words.first(std::min(words.size(), most)), ", "));
    return words.size() > most ? out + ", ..." : out;
}

} // namespace gudgeon

// Tables of numbers as CSV: '#' lines that tell what they are, a line of names, then numbers.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::work_precision {

struct SolutionTable {
    std::vector<std::string> comments;       // without '#'
    std::vector<std::string> names;          // "t" first
    std::vector<std::vector<double>> values; // [column][row]

    /// Throws std::out_of_range for a name that is not there.
    const std::vector<double>& column(const std::string& name) const;
};

/// Throws std::runtime_error for a file that cannot be read or holds no such table.
SolutionTable read_table(const std::filesystem::path& file);

/// With 17 significant digits. Throws std::runtime_error.
void write_table(const std::filesystem::path& file, const SolutionTable& table);

} // namespace gudgeon::work_precision

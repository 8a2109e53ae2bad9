// A table that is written as CSV and as aligned text.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gudgeon::bench {

class Table {
  public:
    explicit Table(std::vector<std::string> columns) : columns_(std::move(columns)) {}

    /// One cell per column.
    void add(std::vector<std::string> cells);

    /// folder/name.csv and folder/name.txt (title, then columns of equal width). Throws std::runtime_error
    /// when a file cannot be written. Called after every row, so that a stopped run leaves its rows.
    void write(const std::filesystem::path& folder, const std::string& name, const std::string& title) const;

    std::string text(const std::string& title) const;

  private:
    std::vector<std::string> columns_;
    std::vector<std::vector<std::string>> rows_;
};

/// Cells: 3 significant digits; "-" for a number that is missing (NaN).
std::string cell(double value);
std::string cell(long value);

} // namespace gudgeon::bench

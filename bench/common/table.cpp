#include "bench/common/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>

namespace gudgeon::bench {

namespace {

void write_file(const std::filesystem::path& file, const std::string& text) {
    std::ofstream out(file);
    out << text;
    out.close();
    if (!out)
        throw std::runtime_error(file.string() + " cannot be written");
}

} // namespace

void Table::add(std::vector<std::string> cells) {
    if (cells.size() != columns_.size())
        throw std::logic_error("a row has another number of cells than the table has columns");
    rows_.push_back(std::move(cells));
}

std::string Table::text(const std::string& title) const {
    std::vector<std::size_t> width(columns_.size());
    for (std::size_t c = 0; c < columns_.size(); ++c) {
        width[c] = columns_[c].size();
        for (const auto& row : rows_)
            width[c] = std::max(width[c], row[c].size());
    }
    const auto line = [&](const std::vector<std::string>& cells) {
        std::string out;
        for (std::size_t c = 0; c < cells.size(); ++c)
            out += fmt::format("{:>{}}{}", cells[c], width[c], c + 1 < cells.size() ? "  " : "\n");
        return out;
    };
    std::string out = title + "\n\n" + line(columns_);
    for (const auto& row : rows_)
        out += line(row);
    return out;
}

void Table::write(const std::filesystem::path& folder, const std::string& name,
                  const std::string& title) const {
    std::string csv = fmt::format("{}\n", fmt::join(columns_, ","));
    for (const auto& row : rows_)
        csv += fmt::format("{}\n", fmt::join(row, ","));
    write_file(folder / (name + ".csv"), csv);
    write_file(folder / (name + ".txt"), text(title));
}

std::string cell(double value) { return std::isnan(value) ? "-" : fmt::format("{:.3g}", value); }
std::string cell(long value) { return fmt::format("{}", value); }

} // namespace gudgeon::bench

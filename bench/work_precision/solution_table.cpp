#include "bench/work_precision/solution_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace gudgeon::work_precision {

const std::vector<double>& SolutionTable::column(const std::string& name) const {
    const auto found = std::find(names.begin(), names.end(), name);
    if (found == names.end())
        throw std::out_of_range("no column " + name);
    return values[found - names.begin()];
}

SolutionTable read_table(const std::filesystem::path& file) {
    std::ifstream in(file);
    if (!in)
        throw std::runtime_error("no table " + file.string());
    SolutionTable table;
    for (std::string line; std::getline(in, line);) {
        if (line.empty() || line[0] == '#') {
            if (line.size() > 1)
                table.comments.push_back(line.substr(line[1] == ' ' ? 2 : 1));
            continue;
        }
        std::vector<std::string> cells;
        std::istringstream row(line);
        for (std::string value; std::getline(row, value, ',');)
            cells.push_back(value);
        if (table.names.empty()) {
            table.names = cells;
            table.values.resize(cells.size());
            continue;
        }
        if (cells.size() != table.names.size())
            throw std::runtime_error(file.string() + ": a line has another number of columns: " + line);
        for (std::size_t i = 0; i < cells.size(); ++i)
            table.values[i].push_back(std::stod(cells[i]));
    }
    if (table.names.empty() || table.values[0].empty())
        throw std::runtime_error(file.string() + " holds no numbers");
    return table;
}

void write_table(const std::filesystem::path& file, const SolutionTable& table) {
    std::ofstream out(file);
    for (const std::string& comment : table.comments)
        out << "# " << comment << '\n';
    out << fmt::format("{}\n", fmt::join(table.names, ","));
    for (std::size_t row = 0; row < table.values.at(0).size(); ++row) {
        std::vector<double> cells;
        for (const auto& column : table.values)
            cells.push_back(column[row]);
        out << fmt::format("{:.17g}\n", fmt::join(cells, ","));
    }
    out.close();
    if (!out)
        throw std::runtime_error(file.string() + " cannot be written");
}

} // namespace gudgeon::work_precision

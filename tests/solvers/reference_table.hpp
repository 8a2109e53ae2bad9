// Reads a table of tests/data/reference: lines with '#' are comments, then a header line, then numbers.
#pragma once

#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace gudgeon::testing_data {

class ReferenceTable {
  public:
    explicit ReferenceTable(const std::string& file) {
        std::ifstream in(std::string(GUDGEON_TEST_DATA) + "/reference/" + file);
        if (!in)
            throw std::runtime_error("no reference table " + file);
        std::string line;
        std::vector<std::string> names;
        while (std::getline(in, line)) {
            if (line.empty() || line[0] == '#')
                continue;
            std::vector<std::string> cells;
            std::istringstream row(line);
            for (std::string cell; std::getline(row, cell, ',');)
                cells.push_back(cell);
            if (names.empty()) {
                names = cells;
                continue;
            }
            for (std::size_t i = 0; i < names.size(); ++i)
                columns_[names[i]].push_back(std::stod(cells.at(i)));
        }
    }

    const std::vector<double>& operator[](const std::string& name) const { return columns_.at(name); }
    std::size_t rows() const { return columns_.at("t").size(); }

  private:
    std::map<std::string, std::vector<double>> columns_;
};

} // namespace gudgeon::testing_data

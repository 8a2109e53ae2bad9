// trajectory.csv: header `t,<names>`, one line per output time, 17 significant digits.
#pragma once

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <vector>

namespace gudgeon {

class CsvFile {
  public:
    /// Throws FileError, as do the others.
    CsvFile(const std::filesystem::path& file, const std::vector<std::string>& names);

    void append(double t, std::span<const double> values);
    void flush();

  private:
    std::filesystem::path file_;
    std::ofstream stream_;
    std::string buffer_;
};

} // namespace gudgeon

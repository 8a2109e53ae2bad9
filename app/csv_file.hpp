// CSV results: header `t,<names>`, one line per time, 17 significant digits.
#pragma once

#include <filesystem>
#include <fstream>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gudgeon {

class CsvFile {
  public:
    /// Throws FileError, as do the others.
    CsvFile(const std::filesystem::path& file, const std::vector<std::string>& names);

    /// word: a last column of text, where the file has one.
    void append(double t, std::span<const double> values, std::string_view word = {});
    void flush();

  private:
    std::filesystem::path file_;
    std::ofstream stream_;
    std::string buffer_;
};

} // namespace gudgeon

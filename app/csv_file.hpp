// CSV results: header `t,<names>`, one line per time, 17 significant digits.
#pragma once

#include "app/file_tools.hpp"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gudgeon {

class CsvFile {
  public:
    /// A new file. Throws FileError, as do the others.
    CsvFile(const std::filesystem::path& file, const std::vector<std::string>& names);
    /// Goes on after the first `length` bytes of a file; what follows them is dropped.
    CsvFile(const std::filesystem::path& file, std::uint64_t length);

    /// word: a last column of text, where the file has one.
    void append(double t, std::span<const double> values, std::string_view word = {});
    void flush();
    /// Everything so far outlives a loss of power.
    void sync();
    /// Bytes so far.
    std::uint64_t length() const { return written_ + buffer_.size(); }

  private:
    OutputFile file_;
    std::uint64_t written_ = 0;
    std::string buffer_;
};

/// The rows of a file that CsvFile has written: one time and its values each. Throws FileError where a row
/// has another number of columns or something that is no number.
void read_csv_rows(const std::filesystem::path& file, std::size_t columns,
                   const std::function<void(double t, std::span<const double> values)>& row);

} // namespace gudgeon

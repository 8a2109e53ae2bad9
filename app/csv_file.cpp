#include "app/csv_file.hpp"

#include "app/numbers.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <fstream>

namespace gudgeon {

CsvFile::CsvFile(const std::filesystem::path& file, const std::vector<std::string>& names) : file_(file) {
    buffer_ = "t";
    for (const std::string& name : names)
        buffer_ += "," + name;
    buffer_ += '\n';
    flush();
}

CsvFile::CsvFile(const std::filesystem::path& file, std::uint64_t length)
    : file_(file, length), written_(length) {}

void CsvFile::append(double t, std::span<const double> values, std::string_view word) {
    append_number(buffer_, t);
    for (const double value : values) {
        buffer_ += ',';
        append_number(buffer_, value);
    }
    if (!word.empty())
        (buffer_ += ',') += word;
    buffer_ += '\n';
    constexpr std::size_t enough = 1 << 18;
    if (buffer_.size() >= enough)
        flush();
}

void CsvFile::flush() {
    file_.write(buffer_);
    written_ += buffer_.size();
    buffer_.clear();
}

void CsvFile::sync() {
    flush();
    file_.sync();
}

void read_csv_rows(const std::filesystem::path& file, std::size_t columns,
                   const std::function<void(double t, std::span<const double> values)>& row) {
    std::ifstream stream(file, std::ios::binary);
    std::string line;
    std::vector<double> numbers;
    std::getline(stream, line); // header
    for (std::size_t n = 2; std::getline(stream, line); ++n) {
        numbers.clear();
        for (std::size_t at = 0; at <= line.size();) {
            const std::size_t comma = std::min(line.find(',', at), line.size());
            const std::optional<double> number = to_number(std::string_view(line).substr(at, comma - at));
            if (!number)
                throw FileError(
                    fmt::format("{}: line {} holds something that is no number", file.string(), n));
            numbers.push_back(*number);
            at = comma + 1;
        }
        if (numbers.size() != columns + 1)
            throw FileError(fmt::format("{}: line {} has {} columns; allowed: {}", file.string(), n,
                                        numbers.size(), columns + 1));
        row(numbers[0], std::span(numbers).subspan(1));
    }
}

} // namespace gudgeon

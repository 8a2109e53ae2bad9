#include "app/csv_file.hpp"

#include "app/numbers.hpp"
#include "core/reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>

namespace gudgeon {

CsvFile::CsvFile(const std::filesystem::path& file, const std::vector<std::string>& names)
    : file_(file), stream_(file, std::ios::binary) {
    if (!stream_)
        throw FileError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
    buffer_ = "t";
    for (const std::string& name : names)
        buffer_ += "," + name;
    buffer_ += '\n';
    flush();
}

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
    stream_.write(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
    buffer_.clear();
    if (!stream_.flush())
        throw FileError(fmt::format("{}: cannot be written: {}", file_.string(), std::strerror(errno)));
}

} // namespace gudgeon

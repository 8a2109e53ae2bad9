#include "app/text_files.hpp"

#include "core/reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>

namespace gudgeon {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
    std::error_code error;
    if (fs::is_directory(folder, error))
        return;
    if (fs::exists(folder, error))
        throw FileError(
            fmt::format("{}: is no folder; allowed: --out with a folder for the results", folder.string()));
    fs::create_directories(folder, error);
    if (error)
        throw FileError(fmt::format("{}: cannot be made: {}", folder.string(), error.message()));
}

void write_text(const fs::path& file, const std::string& text) {
    std::ofstream stream(file, std::ios::binary);
    stream << text;
    if (!stream.flush())
        throw FileError(fmt::format("{}: cannot be written: {}", file.string(), std::strerror(errno)));
}

} // namespace gudgeon

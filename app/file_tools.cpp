#include "app/file_tools.hpp"

#include "core/reader.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <limits>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace gudgeon {

void OutputFile::fail(const char* what) const {
    throw FileError(fmt::format("{}: {}: {}", path_.string(), what, std::strerror(errno)));
}

OutputFile::OutputFile(const std::filesystem::path& file)
    : path_(file), descriptor_(open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666)) {
    if (descriptor_ < 0)
        throw FileError(fmt::format("{}: cannot be written: {}; allowed: --out with a folder that can be "
                                    "written",
                                    file.string(), std::strerror(errno)));
}

OutputFile::OutputFile(const std::filesystem::path& file, std::uint64_t length)
    : path_(file), descriptor_(open(file.c_str(), O_WRONLY | O_CLOEXEC)) {
    if (descriptor_ < 0)
        fail("cannot be written on");
    struct stat status {};
    const auto size = static_cast<off_t>(length);
    if (fstat(descriptor_, &status) == 0 && status.st_size < size) {
        close(descriptor_);
        throw FileError(fmt::format("{}: has {} bytes, but had {} at the checkpoint", file.string(),
                                    status.st_size, length));
    }
    if (ftruncate(descriptor_, size) != 0 || lseek(descriptor_, 0, SEEK_END) != size) {
        const int reason = errno;
        close(descriptor_);
        errno = reason;
        fail("cannot be cut to its length at the checkpoint");
    }
}

OutputFile::~OutputFile() {
    if (descriptor_ >= 0)
        close(descriptor_);
}

void OutputFile::write(std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(descriptor_, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            fail("cannot be written");
        bytes.remove_prefix(static_cast<std::size_t>(n));
    }
}

void OutputFile::sync() {
    if (fsync(descriptor_) != 0 && errno != EINVAL && errno != EROFS) // those: not a file on a disk
        fail("cannot be written");
}

void write_atomically(const std::filesystem::path& file, std::string_view bytes) {
    std::filesystem::path temporary = file;
    temporary += ".new";
    try {
        OutputFile out(temporary);
        out.write(bytes);
        out.sync();
    } catch (const FileError&) {
        std::error_code ignored;
        std::filesystem::remove(temporary, ignored);
        throw;
    }
    std::error_code error;
    std::filesystem::rename(temporary, file, error);
    if (error)
        throw FileError(fmt::format("{}: cannot be replaced: {}", file.string(), error.message()));
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    if (const int directory = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); directory >= 0) {
        fsync(directory); // the new name too; some file systems refuse, which does no harm
        close(directory);
    }
}

std::uint64_t free_space(const std::filesystem::path& folder) {
    struct statvfs status {};
    if (statvfs(folder.c_str(), &status) != 0)
        return std::numeric_limits<std::uint64_t>::max();
    return static_cast<std::uint64_t>(status.f_bavail) * status.f_frsize;
}

std::string size_in_words(double bytes) {
    const char* unit = "bytes";
    for (const char* larger : {"kB", "MB", "GB", "TB"}) {
        if (bytes < 1000)
            break;
        bytes /= 1000;
        unit = larger;
    }
    return fmt::format("{:.3g} {}", bytes, unit);
}

void make_folder(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
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

} // namespace gudgeon

// Files whose errors are found when they happen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string_view>

namespace gudgeon {

/// A file being written, without a buffer of its own. Throws FileError with the system's reason.
class OutputFile {
  public:
    /// A new file, or an old one emptied.
    explicit OutputFile(const std::filesystem::path& file);
    /// An old one of at least `length` bytes, cut to them.
    OutputFile(const std::filesystem::path& file, std::uint64_t length);
    ~OutputFile();
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    void write(std::string_view bytes);
    /// Returns when the bytes lie on the disk.
    void sync();

  private:
    [[noreturn]] void fail(const char* what) const;
    std::filesystem::path path_;
    int descriptor_ = -1;
};

/// Makes the folder unless it is there. Throws FileError.
void make_folder(const std::filesystem::path& folder);

/// Replaces a file in one step: after a crash at any time it is the old one or the new one. Throws FileError.
void write_atomically(const std::filesystem::path& file, std::string_view bytes);

/// Bytes that may still be written below a folder; the greatest number where that cannot be found.
std::uint64_t free_space(const std::filesystem::path& folder);

/// "1.5 GB"
std::string size_in_words(double bytes);

} // namespace gudgeon

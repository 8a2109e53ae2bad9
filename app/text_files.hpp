// Folders and whole files of results.
#pragma once

#include <filesystem>
#include <string>

namespace gudgeon {

/// Makes the folder unless it is there. Throws FileError, as does the other.
void make_folder(const std::filesystem::path& folder);

/// Replaces the file.
void write_text(const std::filesystem::path& file, const std::string& text);

} // namespace gudgeon

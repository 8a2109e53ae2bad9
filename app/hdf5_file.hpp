// trajectory.h5, the same numbers as trajectory.csv (layout: app/README.md).
#pragma once

#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace gudgeon {

class Hdf5File {
  public:
    /// Throws FileError, as do the others.
    Hdf5File(const std::filesystem::path& file, const std::vector<std::string>& names,
             const std::vector<std::string>& units);
    ~Hdf5File();

    /// Attributes of the file; an earlier value is replaced.
    void attribute(const std::string& name, const std::string& value);
    void attribute(const std::string& name, double value);

    void append(double t, std::span<const double> values);
    void flush();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

} // namespace gudgeon

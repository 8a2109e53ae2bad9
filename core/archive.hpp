// Binary archives: one visit function per class serves saving and loading, so that nothing is forgotten in
// one of the two directions.
//
//   void visit(Archive& archive) { archive(t_, q_, names_); }   // member, or free: visit(archive, x)
//
// Numbers are kept bit for bit, in the machine's own byte order. A sealed archive is what lies in a file:
//   magic (8 bytes), format (uint32), byte order (uint32), bytes of the content (uint64), CRC-64 (uint64),
//   content.
#pragma once

#include "core/types.hpp"

#include <array>
#include <complex>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <iosfwd>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace gudgeon {

/// No archive, a truncated or damaged one, one of another version or of something else.
class ArchiveError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

class Archive {
  public:
    /// An empty one, to be written.
    Archive() = default;
    /// Content to be read.
    explicit Archive(std::string content) : bytes_(std::move(content)), reading_(true) {}

    bool reading() const { return reading_; }
    const std::string& content() const { return bytes_; }

    /// A name in the content; loading throws ArchiveError where another one stands.
    void section(std::string_view name);

    /// Saves the values, or loads them. Throws ArchiveError where the content ends too soon.
    template <class... T> void operator()(T&... values) { (item(values), ...); }

    /// A value that has to be the same when it is loaded; what: named in the ArchiveError if it is not.
    template <class T> void same(T value, std::string_view what) {
        T found = value;
        item(found);
        if (!(found == value))
            refuse(what);
    }

    /// After loading: throws ArchiveError unless everything was read.
    void finish() const;

  private:
    template <class T> void item(T& x);
    template <class T> void item(std::vector<T>& x);
    void item(std::vector<bool>&) = delete;
    template <class T> void item(std::optional<T>& x);
    template <class K, class T> void item(std::map<K, T>& x);
    void item(std::string& x);
    template <class T, std::size_t N> void item(std::array<T, N>& x) {
        for (T& value : x)
            item(value);
    }
    template <class T> void item(std::complex<T>& x) { raw(&x, sizeof x); }
    template <class T, int R, int C, int O, int MR, int MC> void item(Eigen::Matrix<T, R, C, O, MR, MC>& x);

    void raw(void* data, std::size_t bytes) {
        if (!reading_) {
            bytes_.append(static_cast<const char*>(data), bytes);
            return;
        }
        need(bytes);
        if (bytes > 0)
            std::memcpy(data, bytes_.data() + at_, bytes);
        at_ += bytes;
    }
    std::uint64_t count(std::size_t present, std::size_t bytes_each);
    void need(std::size_t bytes) const;
    [[noreturn]] static void refuse(std::string_view what);

    std::string bytes_;
    std::size_t at_ = 0;
    bool reading_ = false;
};

template <class T>
concept HasVisit = requires(T& x, Archive& archive) {
    x.visit(archive);
};

template <class T> void Archive::item(T& x) {
    if constexpr (HasVisit<T>) {
        x.visit(*this);
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
        raw(&x, sizeof x);
    } else {
        visit(*this, x);
    }
}

template <class T> void Archive::item(std::vector<T>& x) {
    constexpr bool plain = std::is_arithmetic_v<T> || std::same_as<T, std::complex<double>>;
    const std::uint64_t n = count(x.size(), plain ? sizeof(T) : 1);
    if (reading_)
        x.resize(n);
    if constexpr (plain) {
        raw(x.data(), n * sizeof(T));
    } else {
        for (T& value : x)
            item(value);
    }
}

template <class T> void Archive::item(std::optional<T>& x) {
    bool present = x.has_value();
    item(present);
    if (reading_)
        x = present ? std::optional<T>(T{}) : std::nullopt;
    if (present)
        item(*x);
}

template <class K, class T> void Archive::item(std::map<K, T>& x) {
    std::vector<K> keys;
    for (const auto& [key, value] : x)
        keys.push_back(key);
    item(keys);
    if (reading_)
        x.clear();
    for (const K& key : keys)
        item(x[key]);
}

template <class T, int R, int C, int O, int MR, int MC>
void Archive::item(Eigen::Matrix<T, R, C, O, MR, MC>& x) {
    if constexpr (R == Eigen::Dynamic || C == Eigen::Dynamic) {
        std::uint64_t rows = x.rows(), cols = x.cols();
        raw(&rows, sizeof rows);
        raw(&cols, sizeof cols);
        if (reading_) {
            need(rows > 0 && cols > bytes_.size() / rows ? bytes_.size() : rows * cols * sizeof(T));
            x.resize(static_cast<Eigen::Index>(rows), static_cast<Eigen::Index>(cols));
        }
    }
    raw(x.data(), static_cast<std::size_t>(x.size()) * sizeof(T));
}

/// CRC-64/XZ (ECMA-182, reflected).
std::uint64_t crc64(std::string_view bytes);

/// Writes the content with its seal. Errors show in the stream's state.
void write_sealed(std::ostream& stream, const Archive& archive);

/// Reads to the end of the stream and checks the seal. Throws ArchiveError.
Archive read_sealed(std::istream& stream);

} // namespace gudgeon

#include "core/archive.hpp"

#include <fmt/format.h>

#include <istream>
#include <iterator>
#include <ostream>

namespace gudgeon {

namespace {

constexpr std::string_view magic{"\x89GDGN\r\n\x1a", 8};
constexpr std::uint32_t format = 1;
constexpr std::uint32_t byte_order = 0x01020304;

struct Header {
    std::uint32_t format, byte_order;
    std::uint64_t size, checksum;
};
static_assert(sizeof(Header) == 24);

std::array<std::uint64_t, 256> make_table() {
    std::array<std::uint64_t, 256> table{};
    for (std::uint64_t i = 0; i < table.size(); ++i) {
        std::uint64_t c = i;
        for (int bit = 0; bit < 8; ++bit)
            c = (c & 1 ? 0xC96C5795D7870F42u : 0u) ^ (c >> 1);
        table[i] = c;
    }
    return table;
}

} // namespace

std::uint64_t crc64(std::string_view bytes) {
    static const std::array<std::uint64_t, 256> table = make_table();
    std::uint64_t c = ~std::uint64_t{0};
    for (const char byte : bytes)
        c = table[(c ^ static_cast<unsigned char>(byte)) & 0xff] ^ (c >> 8);
    return ~c;
}

void Archive::section(std::string_view name) {
    std::string found(name);
    item(found);
    if (found != name)
        throw ArchiveError(fmt::format("holds '{}' where '{}' belongs", found, name));
}

void Archive::item(std::string& x) {
    const std::uint64_t n = count(x.size(), 1);
    if (reading_)
        x.resize(n);
    raw(x.data(), n);
}

std::uint64_t Archive::count(std::size_t present, std::size_t bytes_each) {
    std::uint64_t n = present;
    raw(&n, sizeof n);
    if (reading_ && n > (bytes_.size() - at_) / bytes_each)
        need(bytes_.size() + 1);
    return n;
}

void Archive::need(std::size_t bytes) const {
    if (bytes > bytes_.size() - at_)
        throw ArchiveError("ends too soon");
}

void Archive::refuse(std::string_view what) { throw ArchiveError(fmt::format("belongs to {}", what)); }

void Archive::finish() const {
    if (at_ != bytes_.size())
        throw ArchiveError("holds more than belongs into it");
}

void write_sealed(std::ostream& stream, const Archive& archive) {
    const std::string& content = archive.content();
    const Header header{format, byte_order, content.size(), crc64(content)};
    stream.write(magic.data(), std::ssize(magic));
    stream.write(reinterpret_cast<const char*>(&header), sizeof header);
    stream.write(content.data(), std::ssize(content));
}

Archive read_sealed(std::istream& stream) {
    std::string start(magic.size(), '\0');
    Header header{};
    stream.read(start.data(), std::ssize(magic));
    const bool named = start.starts_with(magic.substr(0, static_cast<std::size_t>(stream.gcount())));
    if (!named)
        throw ArchiveError("is no checkpoint of this program");
    stream.read(reinterpret_cast<char*>(&header), sizeof header);
    if (!stream)
        throw ArchiveError("is truncated");
    if (header.byte_order != byte_order)
        throw ArchiveError("was written on a machine of another byte order");
    if (header.format != format)
        throw ArchiveError(fmt::format("has format {}; allowed: {}", header.format, format));
    std::string content{std::istreambuf_iterator<char>(stream), {}};
    if (content.size() < header.size)
        throw ArchiveError(
            fmt::format("is truncated: {} of {} bytes are there", content.size(), header.size));
    if (content.size() > header.size || crc64(content) != header.checksum)
        throw ArchiveError("is damaged: its checksum is another one");
    return Archive(std::move(content));
}

} // namespace gudgeon

// Words of messages: near misses and lists.
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace gudgeon {

/// "did you mean 'x'? " for a near miss, else empty.
std::string suggestion(std::string_view word, std::span<const std::string> known);

/// "a, b, c"
std::string listed(std::span<const std::string> words);

} // namespace gudgeon

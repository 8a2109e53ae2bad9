// Members compared one by one. The headers of the model can be read as C++17, for programs whose other
// headers cannot be read as C++20; these go without.
#pragma once

#ifdef __cpp_impl_three_way_comparison
#define GUDGEON_EQUALITY(Type) bool operator==(const Type&) const = default;
#else
#define GUDGEON_EQUALITY(Type)
#endif

#pragma once

// Small pieces of files that are put together in memory: bytes, floats, names.

#include "geometry/base/vec.hpp"

#include <string>
#include <type_traits>

namespace geometry {

// The bytes of a value as they are in memory: little-endian.
template <class T> void put_bytes(std::string& out, const T& value)
{
    static_assert(std::is_trivially_copyable_v<T>);
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

inline void put_floats(std::string& out, const Vec3f& v)
{
    out.append(reinterpret_cast<const char*>(v.data()), 12);
}

// A name as a line of text holds it, without control characters and spaces around it; `otherwise`
// for one that is then empty.
inline std::string one_line(const std::string& name, const char* otherwise)
{
    std::string out;
    for (const char c : name) out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
    const auto first = out.find_first_not_of(' ');
    if (first == std::string::npos) return otherwise;
    return out.substr(first, out.find_last_not_of(' ') - first + 1);
}

}  // namespace geometry

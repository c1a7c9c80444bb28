#pragma once

// How much memory a value holds: what the cache budget counts.

#include "graph/types/fields.hpp"

#include <memory>
#include <string>
#include <vector>

namespace graph {

// Memory that a value holds, itself included, in bytes: what the cache budget counts. Reads
// containers and plain structs by themselves; a class may say it with `std::size_t bytes() const`.
template <class T> std::size_t bytes_of(const T& value);

namespace detail {

template <class T> std::size_t heap_of(const T& value)
{
    if constexpr (requires {
                      {
                          value.bytes()
                          } -> std::convertible_to<std::size_t>;
                  }) {
        return value.bytes();
    } else if constexpr (std::is_same_v<T, std::string>) {
        return value.capacity();
    } else if constexpr (requires {
                             typename T::allocator_type;
                             value.capacity();
                             value.data();
                         }) {
        std::size_t sum = value.capacity() * sizeof(typename T::value_type);
        using Element = typename T::value_type;
        if constexpr (!std::is_arithmetic_v<Element> &&
                      (PlainStruct<Element> || requires { typename Element::allocator_type; })) {
            if constexpr (!std::is_trivially_copyable_v<Element>) {
                for (const auto& element : value) sum += heap_of(element);
            }
        }
        return sum;
    } else if constexpr (requires {
                             typename T::element_type;
                             value.get();
                         }) {
        return value ? bytes_of(*value) : 0;
    } else if constexpr (PlainStruct<T> && !std::is_trivially_copyable_v<T>) {
        std::size_t sum = 0;
        std::apply([&](const auto&... field) { ((sum += heap_of(field)), ...); }, fields(value));
        return sum;
    } else {
        return 0;
    }
}

}  // namespace detail

template <class T> std::size_t bytes_of(const T& value)
{
    return sizeof(T) + detail::heap_of(value);
}

}  // namespace graph

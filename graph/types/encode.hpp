#pragma once

// Any Storable value to bytes; codec.hpp says how the bytes look.

#include "graph/types/encoder.hpp"
#include "graph/types/layout.hpp"

namespace graph {

template <Storable T> void encode(const T& value, Encoder& out)
{
    using namespace detail;
    if constexpr (Scalar<T>) {
        out.raw(&value, sizeof value);
    } else if constexpr (EigenFixed<T>) {
        out.raw(value.data(), sizeof value);
    } else if constexpr (EigenTransform<T>) {
        out.raw(value.data(), sizeof(typename T::MatrixType));
    } else if constexpr (std::is_same_v<T, std::string>) {
        encode(std::uint64_t{value.size()}, out);
        out.raw(value.data(), value.size());
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
        encode(value.generic_string(), out);
    } else if constexpr (FlatVector<T>) {
        encode(std::uint64_t{value.size()}, out);
        out.pad();
        out.raw(value.data(), value.size() * sizeof(typename T::value_type));
    } else if constexpr (IsVector<T>::value || IsTree<T>::value) {
        encode(std::uint64_t{value.size()}, out);
        for (const typename T::value_type& element : value) encode(element, out);
    } else if constexpr (IsArray<T>::value) {
        for (const auto& element : value) encode(element, out);
    } else if constexpr (IsOptional<T>::value) {
        encode(value.has_value(), out);
        if (value) encode(*value, out);
    } else if constexpr (IsPair<T>::value) {
        encode(value.first, out);
        encode(value.second, out);
    } else if constexpr (IsShared<T>::value) {
        encode(value != nullptr, out);
        if (!value) return;
        using Content = std::remove_const_t<typename T::element_type>;
        std::string layout;
        layout_of<Content>(layout);
        const auto one = [](const void* content, Encoder& e) {
            encode(*static_cast<const Content*>(content), e);
        };
        encode(out.share(value, layout, one), out);
    } else if constexpr (Remade<T>) {
        encode(value.source(), out);
    } else if constexpr (!std::is_empty_v<T>) {
        std::apply([&](const auto&... field) { (encode(field, out), ...); }, fields(value));
    }
}

}  // namespace graph

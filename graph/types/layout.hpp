#pragma once

// How a type is laid out, as a text: "{vector(f8)s}" is a struct of a list of doubles and a text.
// It is stored with encoded bytes, so that bytes of another layout are never read.

#include "graph/types/storable.hpp"

namespace graph {

template <class T> void layout_of(std::string& out)
{
    using namespace detail;
    const auto inner = [&]<class... U>(const char* name, U*...) {
        out += name;
        out += '(';
        (layout_of<std::remove_const_t<U>>(out), ...);
        out += ')';
    };
    if constexpr (Scalar<T>) {
        out += std::is_floating_point_v<T> ? 'f' : std::is_signed_v<T> ? 'i' : 'u';
        out += std::to_string(sizeof(T));
    } else if constexpr (EigenFixed<T>) {
        inner("eigen", static_cast<typename T::Scalar*>(nullptr));
        out += std::to_string(T::RowsAtCompileTime) + 'x' + std::to_string(T::ColsAtCompileTime);
    } else if constexpr (EigenTransform<T>) {
        inner("transform", static_cast<typename T::MatrixType*>(nullptr));
    } else if constexpr (std::is_same_v<T, std::string>) {
        out += 's';
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
        out += 'p';
    } else if constexpr (IsArray<T>::value) {
        out += std::to_string(std::tuple_size_v<T>);
        inner("array", static_cast<typename T::value_type*>(nullptr));
    } else if constexpr (IsVector<T>::value) {
        inner("vector", static_cast<typename T::value_type*>(nullptr));
    } else if constexpr (IsOptional<T>::value) {
        inner("optional", static_cast<typename T::value_type*>(nullptr));
    } else if constexpr (IsTree<T>::value) {
        inner("tree", static_cast<typename T::value_type*>(nullptr));
    } else if constexpr (IsPair<T>::value) {
        inner("pair", static_cast<typename T::first_type*>(nullptr),
              static_cast<typename T::second_type*>(nullptr));
    } else if constexpr (IsShared<T>::value) {
        inner("shared", static_cast<typename T::element_type*>(nullptr));
    } else if constexpr (Remade<T>) {
        inner("remade", static_cast<typename T::Source*>(nullptr));
    } else if constexpr (std::is_empty_v<T>) {
        out += "()";
    } else {
        out += "{";
        [&]<class... F>(std::tuple<F&...>*) {
            (layout_of<std::remove_const_t<F>>(out), ...);
        }(static_cast<decltype(fields(std::declval<T&>()))*>(nullptr));
        out += "}";
    }
}

}  // namespace graph

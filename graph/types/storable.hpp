#pragma once

// Which types can be stored as bytes: the kinds that layout.hpp, encode.hpp and decode.hpp tell
// apart, and the concept Storable that is true of all of them.

#include "graph/types/fields.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

namespace graph {

namespace detail {

template <class T>
concept Scalar = std::is_arithmetic_v<T> || std::is_enum_v<T>;

template <class T>
concept EigenFixed = requires
{
    typename T::Scalar;
    T::RowsAtCompileTime;
    T::ColsAtCompileTime;
    requires T::RowsAtCompileTime >
    0 && T::ColsAtCompileTime > 0 && Scalar<typename T::Scalar>;
    requires sizeof(T) == sizeof(typename T::Scalar) * T::RowsAtCompileTime* T::ColsAtCompileTime;
};
template <class T>
concept EigenTransform = requires
{
    typename T::MatrixType;
    T::Mode;
    requires EigenFixed<typename T::MatrixType>;
};

template <class T> struct IsArray : std::false_type {};
template <class T, std::size_t N> struct IsArray<std::array<T, N>> : std::true_type {};
template <class T> struct IsVector : std::false_type {};
template <class T, class A> struct IsVector<std::vector<T, A>> : std::true_type {};
template <class T> struct IsOptional : std::false_type {};
template <class T> struct IsOptional<std::optional<T>> : std::true_type {};
template <class T> struct IsPair : std::false_type {};
template <class A, class B> struct IsPair<std::pair<A, B>> : std::true_type {};
template <class T> struct IsShared : std::false_type {};
template <class T> struct IsShared<std::shared_ptr<const T>> : std::true_type {};
template <class T> struct IsTree : std::false_type {};
template <class K, class V> struct IsTree<std::map<K, V>> : std::true_type {};
template <class K> struct IsTree<std::set<K>> : std::true_type {};

// A T is nothing but N scalars in a row.
template <class T> constexpr bool flat()
{
    if constexpr (std::is_same_v<T, bool>)
        return false;
    else if constexpr (Scalar<T> || EigenFixed<T>)
        return true;
    else if constexpr (IsArray<T>::value)
        return flat<typename T::value_type>();
    else
        return false;
}
template <class T>
concept FlatVector = IsVector<T>::value && flat<typename T::value_type>();

// A class that holds nothing but its Source and what was worked out from that.
template <class T>
concept Remade = requires(const T& value)
{
    typename T::Source;
    requires std::is_same_v<decltype(value.source()), const typename T::Source&>;
    T(std::declval<typename T::Source>());
};

template <class T> constexpr bool storable();

template <class Tuple> struct AllStorable;
template <class... T> struct AllStorable<std::tuple<T&...>> {
    static constexpr bool value = (storable<std::remove_const_t<T>>() && ...);
};

template <class T> constexpr bool storable()
{
    if constexpr (Scalar<T> || EigenFixed<T> || EigenTransform<T> ||
                  std::is_same_v<T, std::string> || std::is_same_v<T, std::filesystem::path>) {
        return true;
    } else if constexpr (IsArray<T>::value || IsVector<T>::value || IsOptional<T>::value) {
        return storable<typename T::value_type>();
    } else if constexpr (IsPair<T>::value) {
        return storable<std::remove_const_t<typename T::first_type>>() &&
               storable<typename T::second_type>();
    } else if constexpr (IsTree<T>::value) {
        return storable<typename T::value_type>();
    } else if constexpr (IsShared<T>::value) {
        return storable<std::remove_const_t<typename T::element_type>>();
    } else if constexpr (Remade<T>) {
        return storable<typename T::Source>();
    } else if constexpr (std::is_class_v<T> && std::is_empty_v<T>) {
        return std::is_aggregate_v<T>;
    } else if constexpr (PlainStruct<T> && std::is_default_constructible_v<T>) {
        return AllStorable<decltype(fields(std::declval<T&>()))>::value;
    } else {
        return false;
    }
}

}  // namespace detail

// Whether a value of this type can be written and read back.
template <class T>
concept Storable = detail::storable<T>();

}  // namespace graph

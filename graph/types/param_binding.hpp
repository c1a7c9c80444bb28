#pragma once

// Between ParamValues and the members of a node's Inputs struct: how a value of each kind finds its
// member, and what the default of a member is as a value.

#include "graph/types/param.hpp"

#include <Eigen/Core>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <type_traits>
#include <vector>

namespace graph {

namespace detail {

template <class T>
concept Vector3 = std::is_same_v<T, Eigen::Vector3d> || std::is_same_v<T, Eigen::Vector3f>;

template <class T> void decode(const ParamValue& value, T& out)
{
    if constexpr (std::is_same_v<T, bool>) {
        out = std::get<bool>(value.is);
    } else if constexpr (std::is_integral_v<T>) {
        out = static_cast<T>(std::get<std::int64_t>(value.is));
    } else if constexpr (std::is_floating_point_v<T>) {
        out = static_cast<T>(std::get<double>(value.is));
    } else if constexpr (Vector3<T>) {
        const auto& a = std::get<std::array<double, 3>>(value.is);
        out = Eigen::Vector3d(a[0], a[1], a[2]).cast<typename T::Scalar>();
    } else {
        out = std::get<std::string>(value.is);
    }
}

// The number with the fewest digits that is this single: 0.7, not 0.699999988.
double as_written(float in);
inline double as_written(double in)
{
    return in;
}

template <class T> ParamValue encode(const T& in)
{
    if constexpr (std::is_same_v<T, bool>) {
        return {in};
    } else if constexpr (std::is_integral_v<T>) {
        return {static_cast<std::int64_t>(in)};
    } else if constexpr (std::is_floating_point_v<T>) {
        return {as_written(in)};
    } else if constexpr (Vector3<T>) {
        return {std::array<double, 3>{as_written(in[0]), as_written(in[1]), as_written(in[2])}};
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
        return {in.generic_string()};
    } else {
        return {std::string(in)};
    }
}

// Which of the choices the value says. Throws std::invalid_argument when it says none.
std::size_t place_of(const ParamValue& value, const std::vector<std::string>& choices);

// The kind that a member of type T has unless its declaration says otherwise.
template <class T> constexpr ParamKind kind_of()
{
    if constexpr (std::is_same_v<T, bool>)
        return ParamKind::boolean;
    else if constexpr (std::is_integral_v<T>)
        return ParamKind::integer;
    else if constexpr (std::is_floating_point_v<T>)
        return ParamKind::number;
    else if constexpr (Vector3<T>)
        return ParamKind::vector;
    else {
        static_assert(std::is_same_v<T, std::string>, "no parameter kind for this member type");
        return ParamKind::text;
    }
}

}  // namespace detail

// The parameters of a struct: descriptions, and how each value finds its member. The struct's type
// is forgotten, so that all kinds of node share this code: a third less to compile.
struct ParamBinding {
    using Set = std::function<void(void* members, const ParamValue&)>;
    std::vector<Param> params;
    std::vector<Set> set;  // one a param

    void decode(const ParamValues& values, void* members) const
    {
        for (std::size_t i = 0; i < set.size(); ++i) set[i](members, values[i]);
    }

    // The parameter just added, for its caller to complete.
    Param& add(std::string& name, std::string& doc, ParamKind kind, ShownWhen& shown_when, Set how);
};

}  // namespace graph

#pragma once

// Any plain value as bytes and back, without a line of code per type: numbers, enums, texts, paths,
// containers, fixed Eigen types, optional, pair, shared_ptr<const T>, and plain structs of these
// (graph/fields.hpp finds their members).
//
//   vector<Vec3f>      count, padding to a multiple of 8 bytes, the scalars as they are in memory
//   Remade             what it was made from; it is made anew when read: a search tree of a mesh
//   shared_ptr<const T> the name of the content, which stands elsewhere: what many values share is
//                      stored once, and read back as one object again
//
// layout_of<T>() writes down how T is laid out, so that bytes of another layout are never read.

#include "graph/fields.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <tbb/parallel_for.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace graph {

// The 128-bit hash of some encoded content.
using ContentName = std::array<std::uint64_t, 2>;

struct Encoder {
    std::string bytes;
    // Takes the bytes bit by bit, where nobody needs them all at once; else they gather in `bytes`.
    std::function<void(const void* data, std::size_t size)> sink = {};
    // Stores shared content, encoded by `encode`, and returns its name.
    std::function<ContentName(const std::shared_ptr<const void>& content, const std::string& layout,
                              void (*encode)(const void*, Encoder&))>
        share = {};

    void raw(const void* data, std::size_t size)
    {
        if (sink && size > 4096) {
            drain();
            sink(data, size);
            drained_ += size;
            return;
        }
        bytes.append(static_cast<const char*>(data), size);
        if (sink && bytes.size() > 4096) drain();
    }
    // Zeros up to a multiple of 8 bytes, so that what follows is aligned in memory when read.
    void pad() { raw("\0\0\0\0\0\0\0", (8 - (drained_ + bytes.size()) % 8) % 8); }
    // Hands the sink what it has not seen yet.
    void drain()
    {
        sink(bytes.data(), bytes.size());
        drained_ += bytes.size();
        bytes.clear();
    }

private:
    std::size_t drained_ = 0;
};

class Decoder {
public:
    // Gives the content of that name, decoded by `decode` unless an equal one is at hand.
    using Shared = std::function<std::shared_ptr<const void>(
        const ContentName& name, const std::string& layout,
        std::shared_ptr<const void> (*decode)(Decoder&))>;

    explicit Decoder(std::string_view bytes) : Decoder(bytes, {}) {}
    Decoder(std::string_view bytes, Shared find)
        : shared(std::move(find)), bytes_(bytes), size_(bytes.size())
    {}

    Shared shared;

    const char* take(std::size_t size)
    {
        if (size > bytes_.size()) throw std::runtime_error("encoded value ends too early");
        const char* const data = bytes_.data();
        bytes_.remove_prefix(size);
        return data;
    }
    std::size_t left() const { return bytes_.size(); }
    void skip_padding() { take((8 - (size_ - bytes_.size()) % 8) % 8); }
    void raw(void* data, std::size_t size) { std::memcpy(data, take(size), size); }
    // A count of things of at least `each` bytes.
    std::size_t count(std::size_t each)
    {
        std::uint64_t n = 0;
        raw(&n, sizeof n);
        if (n > bytes_.size() / std::max<std::size_t>(each, 1)) {
            throw std::runtime_error("encoded value claims more than there is");
        }
        return n;
    }

private:
    std::string_view bytes_;
    std::size_t size_;  // of all of it
};

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

// Copies of this many bytes and more are shared between the cores.
constexpr std::size_t large_copy = std::size_t{4} << 20;

inline void copy_bytes(char* to, const char* from, std::size_t size)
{
    if (size < large_copy) {
        if (size > 0) std::memcpy(to, from, size);
        return;
    }
    constexpr std::size_t piece = std::size_t{1} << 20;
    tbb::parallel_for(std::size_t{0}, (size + piece - 1) / piece, [&](std::size_t k) {
        std::memcpy(to + k * piece, from + k * piece, std::min(piece, size - k * piece));
    });
}

}  // namespace detail

// Whether a value of this type can be written and read back.
template <class T>
concept Storable = detail::storable<T>();

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

template <Storable T> void decode(Decoder& in, T& value)
{
    using namespace detail;
    if constexpr (std::is_same_v<T, bool>) {
        value = *in.take(1) != 0;
    } else if constexpr (Scalar<T>) {
        in.raw(&value, sizeof value);
    } else if constexpr (EigenFixed<T>) {
        in.raw(value.data(), sizeof value);
    } else if constexpr (EigenTransform<T>) {
        in.raw(value.data(), sizeof(typename T::MatrixType));
    } else if constexpr (std::is_same_v<T, std::string>) {
        const std::size_t size = in.count(1);
        value.assign(in.take(size), size);
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
        std::string text;
        decode(in, text);
        value = text;
    } else if constexpr (FlatVector<T>) {
        using Element = typename T::value_type;
        const std::size_t n = in.count(sizeof(Element));
        in.skip_padding();
        const char* const from = in.take(n * sizeof(Element));
        if constexpr (Scalar<Element>) {
            // Copied as it is made: resize() would write zeros first.
            if (reinterpret_cast<std::uintptr_t>(from) % alignof(Element) == 0) {
                const auto* const first = reinterpret_cast<const Element*>(from);
                value.assign(first, first + n);
                return;
            }
        }
        value.resize(n);
        copy_bytes(reinterpret_cast<char*>(value.data()), from, n * sizeof(Element));
    } else if constexpr (IsVector<T>::value) {
        const std::size_t size = in.count(1);
        value.clear();
        value.reserve(std::min<std::size_t>(size, 4096));
        for (std::size_t i = 0; i < size; ++i) {
            typename T::value_type element{};
            decode(in, element);
            value.push_back(std::move(element));
        }
    } else if constexpr (IsTree<T>::value) {
        const std::size_t size = in.count(1);
        value.clear();
        for (std::size_t i = 0; i < size; ++i) {
            if constexpr (requires { typename T::mapped_type; }) {
                std::pair<typename T::key_type, typename T::mapped_type> element{};
                decode(in, element.first);
                decode(in, element.second);
                value.insert(std::move(element));
            } else {
                typename T::value_type element{};
                decode(in, element);
                value.insert(std::move(element));
            }
        }
    } else if constexpr (IsArray<T>::value) {
        for (auto& element : value) decode(in, element);
    } else if constexpr (IsOptional<T>::value) {
        bool there = false;
        decode(in, there);
        value.reset();
        if (there) decode(in, value.emplace());
    } else if constexpr (IsPair<T>::value) {
        decode(in, value.first);
        decode(in, value.second);
    } else if constexpr (IsShared<T>::value) {
        bool there = false;
        decode(in, there);
        value = nullptr;
        if (!there) return;
        using Content = std::remove_const_t<typename T::element_type>;
        ContentName name{};
        decode(in, name);
        std::string layout;
        layout_of<Content>(layout);
        value = std::static_pointer_cast<const Content>(
            in.shared(name, layout, [](Decoder& d) -> std::shared_ptr<const void> {
                auto content = std::make_shared<Content>();
                decode(d, *content);
                return content;
            }));
    } else if constexpr (Remade<T>) {
        typename T::Source source{};
        decode(in, source);
        value = T(std::move(source));
    } else if constexpr (!std::is_empty_v<T>) {
        std::apply([&](auto&... field) { (decode(in, field), ...); }, fields(value));
    }
}

}  // namespace graph

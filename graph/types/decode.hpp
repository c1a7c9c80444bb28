#pragma once

// Bytes back to a Storable value; codec.hpp says how the bytes look.

#include "graph/types/decoder.hpp"
#include "graph/types/layout.hpp"

namespace graph {

template <Storable T> void decode(Decoder& in, T& value);

namespace detail {

// memcpy, shared between the cores when it is large.
void copy_bytes(char* to, const char* from, std::size_t size);

template <FlatVector T> void decode_flat(Decoder& in, T& value)
{
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
}

template <class T> void decode_vector(Decoder& in, T& value)
{
    const std::size_t size = in.count(1);
    value.clear();
    value.reserve(std::min<std::size_t>(size, 4096));
    for (std::size_t i = 0; i < size; ++i) {
        typename T::value_type element{};
        graph::decode(in, element);
        value.push_back(std::move(element));
    }
}

// A map or a set.
template <class T> void decode_tree(Decoder& in, T& value)
{
    const std::size_t size = in.count(1);
    value.clear();
    for (std::size_t i = 0; i < size; ++i) {
        if constexpr (requires { typename T::mapped_type; }) {
            std::pair<typename T::key_type, typename T::mapped_type> element{};
            graph::decode(in, element.first);
            graph::decode(in, element.second);
            value.insert(std::move(element));
        } else {
            typename T::value_type element{};
            graph::decode(in, element);
            value.insert(std::move(element));
        }
    }
}

template <class Content> void decode_shared(Decoder& in, std::shared_ptr<const Content>& value)
{
    bool there = false;
    graph::decode(in, there);
    value = nullptr;
    if (!there) return;
    ContentName name{};
    graph::decode(in, name);
    std::string layout;
    layout_of<Content>(layout);
    value = std::static_pointer_cast<const Content>(
        in.shared(name, layout, [](Decoder& d) -> std::shared_ptr<const void> {
            auto content = std::make_shared<Content>();
            graph::decode(d, *content);
            return content;
        }));
}

}  // namespace detail

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
        decode_flat(in, value);
    } else if constexpr (IsVector<T>::value) {
        decode_vector(in, value);
    } else if constexpr (IsTree<T>::value) {
        decode_tree(in, value);
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
        decode_shared(in, value);
    } else if constexpr (Remade<T>) {
        typename T::Source source{};
        decode(in, source);
        value = T(std::move(source));
    } else if constexpr (!std::is_empty_v<T>) {
        std::apply([&](auto&... field) { (decode(in, field), ...); }, fields(value));
    }
}

}  // namespace graph

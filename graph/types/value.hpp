#pragma once

// Values on wires. A Value hides the type of what it holds: the runtime counts its bytes, stores it
// and hands it on through WireType, without knowing meshes or images.

#include "graph/types/content_name.hpp"

#include <memory>
#include <stdexcept>
#include <string>
#include <typeinfo>
#include <utility>

namespace graph {

struct Encoder;
class Decoder;

// The name of a wire type; null for everything that may not travel along a wire. One line each:
//   template <> inline constexpr const char* graph::wire_name<geometry::TriMesh> = "mesh";
template <class T> inline constexpr const char* wire_name = nullptr;

template <class T>
concept Wireable = (wire_name<T> != nullptr);

// A shared, read-only view of something on a wire. Null only for inputs declared optional.
template <class T> using Wire = std::shared_ptr<const T>;

// What the runtime can do with a wire type without knowing it.
struct WireType {
    const char* name;
    const std::type_info* type;
    std::size_t (*bytes)(const void*);
    // To and from bytes (codec.hpp). Null for a type that can't be stored.
    void (*encode)(const void*, Encoder&) = nullptr;
    std::shared_ptr<const void> (*decode)(Decoder&) = nullptr;
    std::string layout = {};  // what those bytes are, see layout_of()
};

// The one description of wire type T. Its definition, wire_type.hpp, takes a second to compile for
// a type of many members: only one source per type instantiates it.
template <Wireable T> const WireType& wire_type();

// Any wire value: immutable, cheap to copy, knows its own type.
class Value {
public:
    Value() = default;

    template <Wireable T> static Value of(T content)
    {
        return of(std::make_shared<const T>(std::move(content)));
    }
    template <Wireable T> static Value of(std::shared_ptr<const T> content)
    {
        return {std::move(content), wire_type<T>()};
    }

    // What `type` decoded.
    static Value restored(std::shared_ptr<const void> content, const WireType& type)
    {
        return {std::move(content), type};
    }

    // Null when this value is empty. Throws std::invalid_argument on another type.
    template <Wireable T> Wire<T> as() const
    {
        if (!content_) return nullptr;
        if (*type_->type != typeid(T)) {
            throw std::invalid_argument(std::string("expected ") + wire_name<T> + ", got " +
                                        type_name());
        }
        return std::static_pointer_cast<const T>(content_);
    }

    explicit operator bool() const { return content_ != nullptr; }
    const char* type_name() const { return type_ ? type_->name : "nothing"; }
    const WireType* type() const { return type_; }
    const void* content() const { return content_.get(); }
    std::size_t bytes() const { return content_ ? type_->bytes(content_.get()) : 0; }

private:
    Value(std::shared_ptr<const void> content, const WireType& type)
        : content_(std::move(content)), type_(&type)
    {}

    std::shared_ptr<const void> content_;
    const WireType* type_ = nullptr;
};

}  // namespace graph

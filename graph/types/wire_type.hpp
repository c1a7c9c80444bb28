#pragma once

// The definition of wire_type<T>(): what the runtime can do with values of type T. Include it in
// the one source that instantiates a wire type explicitly,
//   template const WireType& wire_type<geometry::TriMesh>();
// and declare that `extern template` beside the type's wire_name.

#include "graph/types/bytes.hpp"
#include "graph/types/codec.hpp"
#include "graph/types/value.hpp"

namespace graph {

template <Wireable T> const WireType& wire_type()
{
    static const WireType type = [] {
        WireType t{wire_name<T>, &typeid(T),
                   [](const void* p) { return bytes_of(*static_cast<const T*>(p)); }};
        if constexpr (Storable<T>) {
            t.encode = [](const void* p, Encoder& e) { encode(*static_cast<const T*>(p), e); };
            t.decode = [](Decoder& d) -> std::shared_ptr<const void> {
                auto content = std::make_shared<T>();
                decode(d, *content);
                return content;
            };
            layout_of<T>(t.layout);
        }
        return t;
    }();
    return type;
}

}  // namespace graph

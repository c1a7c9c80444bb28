#pragma once

// What nodes say of faces that are there twice (geometry/mesh/doubled_faces.hpp) and that they
// leave out.

#include "graph/types/context.hpp"

#include <fmt/format.h>

#include <cstddef>

namespace nodes {

// `doubled` of `triangles` of a mesh are left out.
inline void warn_of_doubled_faces(std::size_t doubled, std::size_t triangles,
                                  const graph::Context& context)
{
    if (doubled == 0) return;
    context.warn(fmt::format("{} of {} triangles {} on {}, as the back of a two-sided face or a "
                             "copy of it does: {} left "
                             "out, so that each face counts once",
                             doubled, triangles, doubled == 1 ? "lies" : "lie",
                             doubled == 1 ? "another one" : "others",
                             doubled == 1 ? "it is" : "they are"));
}

}  // namespace nodes

#pragma once

// Faces of a mesh that are there twice: named again, or with a back of their own, as in models for
// renderers that draw one side of a face.

#include "geometry/mesh/split.hpp"

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace geometry {

// What a triangle is to an earlier one with corners in the same three places, and of its kind.
enum class Doubled : std::uint8_t {
    no,          // there is none
    again,       // wound the same way
    solid_back,  // wound against it, and so is every triangle of their piece: it is one surface
                 // with two sides, which closes
    sheet_back,  // the same of a surface with a border
    against,     // wound against it, as between two boxes side by side
    unsound      // names a vertex that is not there, or one that is not finite
};

// Triangles that bound a solid. Both sides of a sheet do: they enclose nothing, where one alone
// might be filled up to its border.
inline bool adds_to_solid(Doubled is)
{
    return is == Doubled::no || is == Doubled::sheet_back || is == Doubled::against;
}

// Triangles whose areas are those of a surface.
inline bool adds_to_surface(Doubled is)
{
    return is == Doubled::no || is == Doubled::against;
}

struct DoubledFaces {
    // F, of the first vertex in each place; those of polygons on one border cut alike
    // (cut_alike.hpp).
    std::vector<Triangle> triangles;
    std::vector<Doubled> is;  // F
};

// `kind`: F, or empty where all are alike. A piece is what hangs together by edges.
DoubledFaces doubled_faces(const TriMesh& mesh, std::span<const std::uint16_t> kind = {});

// How many triangles are backs in a sheet.
std::size_t count_sheet_backs(const TriMesh& mesh, std::span<const std::uint16_t> kind = {});

// The mesh without faces that add nothing to its surface; null where there are no doubled ones.
struct WithoutDoubled : SplitMesh {
    std::size_t doubled = 0;  // triangles left out, as they are there twice
};
std::optional<WithoutDoubled> without_doubled(const TriMesh& mesh,
                                              std::span<const std::uint16_t> kind = {});

}  // namespace geometry

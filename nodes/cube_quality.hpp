#pragma once

// The size of cubes that Voxelize chooses by itself, and what it says of its choice.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "graph/types/context.hpp"

#include <functional>

namespace graph {
struct Json;
}

namespace nodes {

enum class Quality { by_size, draft, good, exact, by_error };

constexpr const char* no_quality =
    "quality needs a mesh with faces and method = solid or surface, found samples or a point "
    "cloud, which have no more detail than points: use quality = by_size";
constexpr const char* surface_needs_thickness =
    "quality needs to know how thick the faces are, found method = surface with thickness = 0, "
    "where the cubes themselves are the thickness: give a thickness, or use method = solid or "
    "quality = by_size";

struct WantedQuality {
    Quality quality = Quality::good;
    double error = 0.05;  // of by_error
    std::size_t max_cubes = 0;
};

// The edge of the cubes, m. Warns of what was chosen and why. `cubes_of` throws
// std::invalid_argument where cubes of a size are too many.
double size_of_quality(const geometry::TriMesh& mesh, bool solid, const WantedQuality& wanted,
                       const std::function<geometry::Cubes(double)>& cubes_of,
                       const graph::Context& context);

// Other forms of `size` in documents, as a JSON schema.
constexpr const char* size_forms = R"({ "anyOf": [
    { "enum": ["draft", "good", "exact"] },
    { "type": "object", "required": ["auto"], "additionalProperties": false, "properties": {
        "auto": { "type": "object", "required": ["error"], "additionalProperties": false,
            "properties": { "error": { "type": "number", "minimum": 0.001, "maximum": 1 } } } } }
] })";

// Writes them out: "size": "good" is "quality": "good", and "size": {"auto": {"error": 0.05}} is
// "quality": "by_error" with that error.
void write_out_size(graph::Json& node);

}  // namespace nodes

#pragma once

// Which face of a mesh is made of which matter, by rules.

#include "geometry/cubes/matter.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <span>

namespace geometry {

// Which faces are made of what.
struct MatterRule {
    enum class Match { all, material, group, colour };
    Match match = Match::all;
    std::string name;  // material, group: a pattern, where * is any text and ? any letter
    Vec3f colour = Vec3f::Zero();  // colour: linear RGB
    float tolerance = 0.1f;        // colour: the largest difference of a component
    Matter matter;
};

// What each face of a mesh is made of.
struct FaceMatter {
    std::vector<std::uint16_t> face;  // F, into matters; empty when all is matters[0]
    std::vector<Matter> matters;      // those in use, at least one
    std::vector<std::size_t> idle;    // rules that match no face

    std::uint16_t of(std::size_t triangle) const { return face.empty() ? 0 : face[triangle]; }
};

// The last rule that matches a face gives its matter; `fallback` where none does. A face's colour
// is the mean of its vertices' colours where the mesh has them, else its material's.
// Throws std::invalid_argument for more than 65,000 rules or a matter that cannot be (density or
// stiffness not positive, Poisson ratio outside 0 <= nu < 0.5, negative damping).
FaceMatter assign_matter(const TriMesh& mesh, std::span<const MatterRule> rules,
                         const Matter& fallback);

// That of some faces.
FaceMatter matter_of_some(const FaceMatter& all, std::span<const std::uint32_t> faces);

// Throws std::invalid_argument for a matter that cannot be.
void check(const Matter& matter);

// Whether `text` matches `pattern`, where * is any text and ? any one character.
bool matches(const std::string& text, const std::string& pattern);

}  // namespace geometry

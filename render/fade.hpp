#pragma once

// Meshes of other times, paler than the one of now.

#include "render/scene.hpp"

#include <span>
#include <string>
#include <vector>

namespace render {

// `mesh` with its materials' and its vertices' colours mixed with `share` (0 to 1) of `colour`
// (linear RGB), as the eye sees mixtures, and its materials' opacity times `opacity`. Textures that
// only colour would hide the mixture: where `share` is above 0 they are left out.
TriMesh faded(const TriMesh& mesh, const Vec3f& colour, float share, float opacity);

// How the first of several meshes looks, in order of time; those between are evenly less so, the
// last is as it was.
struct Fade {
    Vec3f colour{0.75f, 0.8f, 0.85f};  // linear RGB
    double share = 0.8;                // of that colour
    double opacity = 1;
};

// All of them as one mesh, the last one first: where two lie in one place, the later one is seen.
TriMesh onion_skin(std::span<const std::shared_ptr<const TriMesh>> meshes, const Fade& fade);

// The whole numbers of a text, parted by blanks or commas: "1, 12 24". Throws
// std::invalid_argument where it holds something else, or nothing.
std::vector<int> numbers_in(const std::string& text);

}  // namespace render

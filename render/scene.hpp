#pragma once

// What a picture shows, in world coordinates (metres, y up): everything else that can be drawn
// (cubes, arrows, colliders) is made into these few shapes first.

#include "geometry/fields/iso_cells.hpp"
#include "geometry/mesh/mesh.hpp"
#include "render/colour.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace render {

using geometry::Box;
using geometry::TriMesh;
using geometry::Vec3;

struct SurfaceLayout;

// Where the colour of a surface comes from. A face's opacity, roughness and metallic always come
// from its material.
struct Paint {
    // checker: as material, of what checkered() made.
    enum class By { material, constant, vertex_colour, attribute, checker };
    By by = By::material;
    Vec3f colour{0.7f, 0.7f, 0.7f};  // constant: linear RGB
    std::string attribute;           // attribute: the name of one of the mesh's
    ColourScale scale;               // attribute: its values' colours
};

// Triangles, seen from both sides.
struct Surface {
    std::shared_ptr<const TriMesh> mesh;
    // How its vertices go to the renderer, made once for all meshes that share a topology; null, or
    // of another topology: made on the way.
    std::shared_ptr<const SurfaceLayout> layout;
    Paint paint;
    float opacity = 1;     // times that of the materials
    bool shadow = true;    // casts one; receives them always
    bool receives = true;  // false: shown in its own colour, unlit
    // A clear ghost is not laid over the pixels of opaque bodies: these keep their colours.
    enum class Kind : std::uint8_t { thing, body, ghost } kind = Kind::thing;
    // A frame ago, for motion blur; null, or with other faces than `mesh`: it stands still.
    std::shared_ptr<const TriMesh> before = nullptr;
};

// The surface of a field, without triangles: found along the ray of each pixel.
struct FieldSurface {
    geometry::IsoField field;
    geometry::IsoCells cells;  // of that field
    Box extent;                // m, of the surface; empty: there is none
    geometry::Material material;
    Paint paint;            // vertex colours: it has none, and shows its material
    std::string attribute;  // the one that it has; empty: none
    std::function<double(const Vec3&)> value;  // of the attribute, at a point of the surface
    bool shadow = true;                        // casts one; receives them always
};

struct Lines {
    std::vector<Vec3f> ends;         // 2L, both ends of each line
    Vec3f colour{0, 0, 0};           // linear RGB
    float width = 1;                 // pixels
    std::vector<Vec3f> before = {};  // 2L, the ends a frame ago, or 0: they stand still
};

struct Balls {
    std::vector<Vec3f> centres;  // N
    std::vector<Vec3f> colours;  // N, or 1 for all; linear RGB
    float radius = 0.01f;        // m
    float smallest = 1.5f;       // pixels: however far away, a ball is not drawn smaller
    bool shadow = true;
    std::vector<Vec3f> before = {};  // N, the centres a frame ago, or 0: they stand still
};

// A scale of colours with its numbers.
struct Legend {
    std::string title, unit;
    ColourScale scale;
    std::string note = {};  // below it; empty: nothing
};

// A few words beside the tip of an arrow, over whatever lies before it.
struct Note {
    Vec3 from, tip;    // m, of the arrow
    double clear = 0;  // m, half its width
    std::string text;
};

struct Scene {
    std::vector<Surface> surfaces;
    std::vector<FieldSurface> fields;
    std::vector<Lines> lines;
    std::vector<Balls> balls;
    // Where the action is: the shadow and the floor's extent are laid out for this box, so keep it
    // the same for all frames of a shot. Empty: the bounds of what is drawn.
    Box stage;
    std::optional<double> ground;  // m, height of the floor
    std::optional<Legend> legend;
    std::vector<Note> notes;
    std::string label;  // in a corner of the picture; '\n' parts lines
};

// The box that holds every finite point of the surfaces, lines, balls and fields.
Box bounds(const Scene& scene);

}  // namespace render

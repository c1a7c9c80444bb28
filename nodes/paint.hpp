#pragma once

// What nodes that set numbers from place to place share: the names that their expressions know, and
// ramps that values go through.

#include "geometry/base/picture_file.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "graph/document/expression.hpp"
#include "graph/types/param_builder.hpp"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace nodes {

// A value, and what becomes of it.
struct RampPoint {
    double at = 0, value = 0;
};
enum class RampShape { linear, smooth };
struct Ramp {
    std::vector<RampPoint> points;  // none: values stay as they are
    RampShape shape = RampShape::linear;

    double operator()(double x) const;
};

// Throws std::invalid_argument where points of a ramp are not in order.
void check(const Ramp& ramp);

void describe_ramp(graph::ParamsOf<Ramp>& p);

inline constexpr const char* about_ramp = "Curve that the value of the expression goes through.";
inline constexpr const char* about_paint =
    "Its value as an expression, without a leading =. It knows x, y and z in m; r, g and b of "
    "vertex colours, from 0 to 1 and linear; attributes by their names; and texture_r, texture_g, "
    "texture_b and texture_a, from 0 to 1 as the picture has them.";
inline constexpr const char* about_texture =
    "Picture (PNG, JPEG, BMP or TGA) that texture_r, texture_g, texture_b and texture_a are read "
    "from, at the texture coordinates of the mesh, repeated beyond it. Empty: the base-colour "
    "texture of each material, and 1 where it has none.";

// Whether an expression uses a name.
bool mentions(std::string_view expression, std::string_view name);

// Throws std::invalid_argument with a whole sentence for an expression that is none of `names`.
graph::FunctionOf compiled(const std::string& expression, const std::vector<std::string>& names);

// Throws std::invalid_argument for a name that expressions could not use: empty, of other
// characters than letters, digits and _, or one that means something else there.
void check_name(const std::string& name);

// Names as expressions can use them, none twice and none of `taken`: each stays as it is if it can,
// others get _ for what a name cannot hold, before a digit and behind a name that there is.
std::vector<std::string> usable_names(const std::vector<std::string>& names,
                                      std::vector<std::string> taken);

// The picture that expressions read a texture from; null where `path` is empty or none of them uses
// one. Throws std::invalid_argument where it cannot be read.
std::shared_ptr<const geometry::Picture> picture_of(const std::filesystem::path& path,
                                                    std::span<const std::string> expressions);

// What a mesh is painted with, by the names that expressions know it by: x, y and z of a place, in
// m; r, g and b of its vertex colours; its attributes, with _ for what a name cannot hold; and
// texture_r, texture_g, texture_b and texture_a of a picture at its texture coordinates, 0..1 as
// the file has them: the one that is given, or that of each face's material, 1 where it has none.
class Paint {
public:
    // What will be asked for: values at vertices; values at places; or values at places, and which
    // face is nearest to each.
    enum class At { vertices, places, faces };

    // Looks up only what `expressions` use. Throws std::invalid_argument where they use a texture
    // and there is none, or no texture coordinates. `mesh` may be null, and must outlive this; a
    // null `picture` stands for those of the materials.
    Paint(const geometry::TriMesh* mesh, std::shared_ptr<const geometry::Picture> picture,
          std::span<const std::string> expressions, At at);

    const std::vector<std::string>& names() const { return names_; }

    // Values by the names, where the surface is nearest to a place; the face there, or no_index.
    std::uint32_t look(const geometry::Vec3& place, std::vector<double>& values) const;

    // The same at a vertex. A vertex on a seam of the texture has the mean of its sides.
    void at_vertex(std::size_t vertex, std::vector<double>& values) const;

    // Whether the mesh has faces of a group or material whose name `pattern` matches.
    bool has_part(const std::string& pattern) const;
    // Whether a face is of one.
    bool in_part(std::uint32_t face, const std::string& pattern) const;

private:
    void add_names();
    void need_texture();
    void add_corners();
    std::array<double, 4> texture_at(std::size_t face, const geometry::Vec2f& uv) const;
    std::array<double, 4> texture_at_vertex(std::size_t vertex) const;

    const geometry::TriMesh* mesh_ = nullptr;
    bool coloured_ = false, has_uvs_ = false, textured_ = false, surface_ = false;
    std::vector<std::string> names_{"x", "y", "z"};
    std::vector<const geometry::Attribute*> attributes_;
    std::shared_ptr<const geometry::Picture> picture_;  // null: those of the materials
    geometry::TriangleBvh tree_;
    std::vector<std::uint32_t> first_, corner_;  // of each vertex and one more; 3 face + corner
};

}  // namespace nodes

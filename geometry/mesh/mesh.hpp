#pragma once

// Triangle meshes as they come from the world: any number of pieces, open or closed, broken or not.

#include "geometry/base/vec.hpp"
#include "geometry/mesh/attribute.hpp"
#include "geometry/mesh/texture_use.hpp"

#include <memory>
#include <string>
#include <vector>

namespace geometry {

class Texture;  // geometry/mesh/texture.hpp

// How a face looks. Linear RGB in 0..1.
struct Material {
    std::string name;
    Vec3f colour{0.7f, 0.7f, 0.7f};
    float opacity = 1;
    float roughness = 0.6f;  // 0 mirror .. 1 chalk
    float metallic = 0;
    // A picture at the texture coordinates, which colour and opacity are multiplied with; null:
    // none. All frames share it.
    std::shared_ptr<const Texture> texture = nullptr;
    TextureUse use = {};
    // Normals at the same coordinates, in the frame of the surface: x along u, y along v, z out of
    // it, as OpenGL and glTF have them; null: none.
    std::shared_ptr<const Texture> normal_map = nullptr;
    float bump = 1;  // their x and y are multiplied with it

    // Textures are equal where their files are.
    bool operator==(const Material& other) const;
};

// What stays the same while a mesh moves; shared by all frames of it.
struct MeshTopology {
    std::vector<Triangle> triangles;  // F, into TriMesh::positions, counter-clockwise outside
    std::vector<Triangle> normal_triangles;  // F or 0, into TriMesh::normals
    std::vector<Vec2f> uvs;                  // U or 0
    std::vector<Triangle> uv_triangles;      // F or 0, into uvs
    std::vector<Material> materials;         // at least those that `material` names
    std::vector<std::uint16_t> material;     // F or 0 (then all faces are materials[0] or default)
    std::vector<std::string> groups;         // names of nodes, objects or groups in the file
    std::vector<std::uint16_t> group;        // F or 0
    // F, or 0 where all are triangles: which polygon of the file each is part of (polygons.hpp).
    std::vector<std::uint32_t> polygon;
};

// A triangle mesh, or a point cloud when there are no triangles. Vertices are welded by position:
// two faces that meet share the vertex. Every entry of `normals` belongs to one vertex only, a
// vertex on a hard edge has several.
struct TriMesh {
    std::shared_ptr<const MeshTopology> topology = std::make_shared<const MeshTopology>();
    std::vector<Vec3f> positions;       // V, m
    std::vector<Vec3f> normals;         // N or 0, unit
    std::vector<Vec3f> colours;         // V or 0, linear RGB 0..1
    std::vector<Attribute> attributes;  // any number

    const std::vector<Triangle>& triangles() const { return topology->triangles; }
};

// The smallest box that holds every vertex; empty for an empty mesh.
Box bounds(const TriMesh& mesh);

}  // namespace geometry

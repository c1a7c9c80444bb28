#pragma once

// Meshes as files that other programs read, one a frame: OBJ, PLY, STL, GLB. One for a whole shot
// is in geometry/io/point_cache.hpp; other formats are assimp's (geometry/io/export_mesh.hpp), and
// these too where it is asked for. By itself it is not: assimp 5.2's exporters of OBJ and glTF weld
// vertices that happen to coincide, so that frames of one moving mesh would differ in their
// vertices and no program could go from one to the next; that of PLY drops attributes with names of
// their own. They also take long for every frame: 327,000 faces as OBJ 1.3 s, as PLY 0.55, as GLB
// 0.19, against 0.06, 0.01 and 0.03 s. What is written is read back, by assimp, in tests.

#include "geometry/io/own_header.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <filesystem>

namespace geometry {

// Wavefront OBJ: positions (with vertex colours after them, as display values), normals, texture
// coordinates, groups and materials. Numbers are the shortest that read back to the same floats.
// `library` is the file name of the material library, empty for none. `frame`, here and below: what
// the positions are in.
std::string obj_text(const TriMesh& mesh, const std::string& library, const FileFrame& frame = {});

// The material library of an OBJ: colours as display values, and roughness and metallic by their
// physically based names. Empty when the mesh has no materials.
std::string mtl_text(const TriMesh& mesh);

// Binary PLY: positions, normals where every vertex has one only, vertex colours, attributes as
// numbers of their own names, and faces, coloured by their materials where vertices have no
// colours. Texture coordinates where every vertex has one only, else those of corners, and the
// texture's name where there is one only, as MeshLab has them.
std::string ply_bytes(const TriMesh& mesh, const FileFrame& frame = {});

// Binary STL: faces alone.
std::string stl_bytes(const TriMesh& mesh, const FileFrame& frame = {});

// Binary glTF 2.0: a node a group, a primitive a material; or points. Textures lie in it.
std::string glb_bytes(const TriMesh& mesh);

// What that can't hold, for export_mesh(): the polygons of each primitive in its order. Numbers of
// four bytes: the number of faces; of each, the number of its corners and these, of which 3 f + k
// is corner k of the primitive's triangle f. Empty where all faces are triangles.
std::string glb_polygons(const TriMesh& mesh);

enum class MeshFormat { obj, ply, stl, glb, gltf, dae, fbx, x3d };

// Whether write_mesh() writes it; the others are for export_mesh().
bool is_written_here(MeshFormat format);

// The format that a file name's ending stands for. Throws std::invalid_argument for others.
MeshFormat mesh_format(const std::filesystem::path& path);

// Writes `mesh` to `path`, and beside an OBJ with materials their library, which is returned: of
// "a.0001.obj" it is "a.0001.mtl", since materials may change from frame to frame; then textures
// that OBJ or PLY name (texture_files.hpp). Files appear
// whole or not at all; missing folders are made. Throws std::runtime_error saying what could not be
// written, and std::invalid_argument when the format cannot hold the mesh or is not written here.
std::vector<std::filesystem::path> write_mesh(const std::filesystem::path& path, MeshFormat format,
                                              const TriMesh& mesh, const FileFrame& frame = {});

}  // namespace geometry

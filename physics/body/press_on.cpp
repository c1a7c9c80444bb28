#include "physics/body/press_on.hpp"

#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/embed/embed.hpp"
#include "geometry/mesh/cut_sides.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/nested_pieces.hpp"
#include "geometry/mesh/split.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "geometry/mesh/wound_out.hpp"
#include "physics/state/choose_corners.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

using geometry::Triangle;
using geometry::TriMesh;
using geometry::Vec3f;

constexpr std::size_t most_faces = 20'000'000;

// Whether cubes hold less than half of what a closed piece of a mesh would, by their middles.
bool leave_hollow(const geometry::Cubes& cubes, const TriMesh& piece, double volume)
{
    const geometry::TriangleBvh tree(piece);
    const geometry::Box box = geometry::bounds(piece);
    double held = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const geometry::Vec3 middle =
            cubes.origin + cubes.size * (cubes.cell[c].cast<double>().array() + 0.5).matrix();
        if ((middle.array() < box.lo.array()).any() || (middle.array() > box.hi.array()).any()) {
            continue;
        }
        if (tree.inside(middle)) held += cubes.fill[c];
    }
    return held * std::pow(cubes.size, 3) < 0.5 * std::abs(volume);
}

// Turns over closed pieces that are wound as the ones that they lie in, where cubes made by parity
// leave them hollow.
void turn_hollows(const geometry::Cubes& cubes, TriMesh mesh, std::vector<Triangle>& triangles)
{
    if (cubes.is_sheet()) return;
    auto topology = std::make_shared<geometry::MeshTopology>();
    topology->triangles = triangles;
    mesh.topology = std::move(topology);
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    std::vector<geometry::SplitMesh> parts;
    for (const geometry::NestedPiece& nested : geometry::nested_pieces(mesh, pieces)) {
        if (!geometry::is_wound_as_around(pieces, nested)) continue;
        if (parts.empty()) parts = geometry::split(mesh, pieces.of, pieces.count());
        const geometry::SplitMesh& part = parts[nested.piece];
        if (!leave_hollow(cubes, part.mesh, pieces.volume[nested.piece])) continue;
        for (const auto t : part.faces) std::swap(triangles[t][1], triangles[t][2]);
    }
}

// The faces of the mesh, or of that name, wound outwards.
std::vector<Triangle> chosen_faces(const geometry::Cubes& cubes, const TriMesh& mesh,
                                   const std::string& name, PressOn& out)
{
    geometry::WoundOut wound = geometry::wound_out(mesh);
    turn_hollows(cubes, mesh, wound.triangles);
    out.turned = wound.turned, out.one_way = wound.one_way;
    std::vector<Triangle> faces;
    const auto take = [&](std::size_t t) {
        const Triangle& v = wound.triangles[t];
        if (std::max({v[0], v[1], v[2]}) >= mesh.positions.size()) return;
        for (const auto k : v) {
            if (!mesh.positions[k].allFinite()) return;
        }
        faces.push_back(v);
    };
    if (name.empty()) {
        for (std::size_t t = 0; t < wound.triangles.size(); ++t) take(t);
    } else {
        for (const auto t : faces_called(mesh, name)) take(t);
    }
    if (faces.empty()) {
        throw std::invalid_argument("the mesh has no faces that a pressure could act on: link the "
                                    "closed mesh that the cubes were made of");
    }
    return faces;
}

// The corners of faces and the middles of their sides, as faces of six nodes.
std::vector<std::array<std::uint32_t, 6>> with_middles(const std::vector<Triangle>& faces,
                                                       std::vector<Vec3f>& positions)
{
    geometry::SideMiddles middles(positions);
    std::vector<std::array<std::uint32_t, 6>> out;
    out.reserve(faces.size());
    for (const auto& [a, b, c] : faces) {
        out.push_back({a, b, c, middles.of(a, b), middles.of(b, c), middles.of(c, a)});
    }
    return out;
}

// Leaves out nodes that no face has.
void number_nodes_in_use(std::vector<Vec3f>& positions,
                         std::vector<std::array<std::uint32_t, 6>>& faces)
{
    std::vector<std::uint32_t> number(positions.size(), geometry::no_index);
    std::vector<Vec3f> used;
    for (auto& face : faces) {
        for (auto& node : face) {
            auto& n = number[node];
            if (n == geometry::no_index) {
                n = static_cast<std::uint32_t>(used.size());
                used.push_back(positions[node]);
            }
            node = n;
        }
    }
    positions = std::move(used);
}

// Each face as the four triangles between its nodes: what hangs together is bound together.
std::shared_ptr<const geometry::MeshTopology>
topology_of(const std::vector<std::array<std::uint32_t, 6>>& faces)
{
    auto out = std::make_shared<geometry::MeshTopology>();
    for (const auto& f : faces) {
        out->triangles.insert(out->triangles.end(),
                              {Triangle{f[0], f[3], f[5]}, Triangle{f[3], f[1], f[4]},
                               Triangle{f[4], f[2], f[5]}, Triangle{f[3], f[4], f[5]}});
    }
    return out;
}

// Length of the sides to which faces are cut, m. On a sheet it is that of its own longest side, so
// that the mesh that it was made of is cut into the cells that it has; the share more is for the
// rounding of mesh vertices.
double longest_pressed(const geometry::Cubes& cubes)
{
    if (!cubes.is_sheet()) return 0.5 * cubes.size;
    double longest = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto [i, j, k] = geometry::sheet_triangle(cubes, c);
        const Vec3 &a = cubes.place[i], &b = cubes.place[j], &d = cubes.place[k];
        longest = std::max({longest, (b - a).norm(), (d - b).norm(), (a - d).norm()});
    }
    return (1 + 1e-6) * longest;
}

}  // namespace

PressOn press_on(const geometry::Cubes& cubes, const TriMesh& mesh, const std::string& name)
{
    if (geometry::flat_axis(cubes) >= 0 && !cubes.is_sheet()) {
        throw std::invalid_argument("pressure needs a body of cubes or a sheet, and these are a "
                                    "plane: use Voxelize or Sheet, or Force with kind = wind");
    }
    PressOn out;
    std::vector<Triangle> faces = chosen_faces(cubes, mesh, name, out);
    TriMesh nodes;
    nodes.positions = mesh.positions;
    const double longest = longest_pressed(cubes);
    while (geometry::cut_sides(longest, nodes.positions, faces)) {
        if (faces.size() <= most_faces) continue;
        throw std::invalid_argument(fmt::format(
            "the surface is more than {} cubes large: expected faces of the size of cubes of {:g} "
            "m. Use larger cubes, or press on a part of the mesh",
            most_faces / 8, cubes.size));
    }
    out.surface.faces = with_middles(faces, nodes.positions);
    number_nodes_in_use(nodes.positions, out.surface.faces);
    nodes.topology = topology_of(out.surface.faces);
    const geometry::Binding binding = geometry::bind(nodes, cubes);
    out.farthest = binding.farthest;
    out.surface.cubes = mark_of(cubes);
    for (std::uint32_t i = 0; i < nodes.positions.size(); ++i) {
        out.surface.corners.push_back(cubes.corners[binding.used[binding.cube[i]]]);
        out.surface.weight.push_back(geometry::weights(binding, i));
    }
    return out;
}

}  // namespace physics

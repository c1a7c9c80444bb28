#pragma once

// What Voxelize tells of a body: how far its cubes are from the mesh that they stand for.

#include "geometry/mesh/mass_properties.hpp"
#include "geometry/mesh/measure.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "geometry/mesh/nested_pieces.hpp"
#include "geometry/mesh/solid_faces.hpp"
#include "geometry/mesh/triangle_bvh.hpp"
#include "graph/types/figure.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/measure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>

namespace nodes {

inline double count_cubes(const graph::Value& cubes)
{
    return static_cast<double>(cubes.as<geometry::Cubes>()->count());
}

// kg/m^3, of the material; not a number where the cubes are not all of one density. The mass of a
// cube is less than density * fill where min_fill counts cubes as fuller than they are.
inline double one_density(const geometry::Cubes& cubes)
{
    const double per_fill = std::pow(cubes.size, 3);
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double density = cubes.mass[c] / (cubes.fill[c] * per_fill);
        least = std::min(least, density), most = std::max(most, density);
    }
    if (!(most - least <= 1e-4 * most)) return graph::Figure::unknown;
    const auto& all = cubes.matters;
    const bool one = !all.empty() && std::all_of(all.begin(), all.end(), [&](const auto& m) {
        return m.density == all[0].density;
    });
    return one ? all[0].density : most;
}

// The mass moments of cubes at rest, with the mass of bricks.
inline physics::MassMoments moments_at_rest(const geometry::Cubes& cubes)
{
    physics::State at_rest;
    at_rest.x = geometry::corner_positions(cubes);
    at_rest.v.assign(at_rest.x.size(), geometry::Vec3::Zero());
    at_rest.brick_mass = true;
    return physics::mass_moments(at_rest, cubes);
}

inline double volume_held(const geometry::Cubes& cubes)
{
    double sum = 0;
    for (const double fill : cubes.fill) sum += fill * std::pow(cubes.size, 3);
    return sum;
}

// Whether parts of a closed mesh, which has that volume, overlap: then its volume counts twice what
// the cubes hold once. By places in cubes, where these hold less than the mesh.
inline bool parts_overlap(const geometry::TriMesh& mesh, double volume,
                          const geometry::Cubes& cubes)
{
    constexpr std::size_t most = 512;  // cubes
    constexpr int n = 3;            // places along an edge: parts may overlap by less than a cube
    constexpr double least = 1e-3;  // of the volume
    if (cubes.count() == 0 || volume_held(cubes) > (1 - least) * std::abs(volume)) return false;
    const geometry::TriangleBvh inside(mesh);
    const std::size_t step = (cubes.count() + most - 1) / most;
    for (std::size_t c = 0; c < cubes.count(); c += step) {
        for (int i = 0; i < n * n * n; ++i) {
            const geometry::Vec3i place(i % n, i / n % n, i / (n * n));
            const geometry::Vec3 in_cube = (place.cast<double>().array() + 0.5) / n;
            const geometry::Vec3 at = cubes.cell[c].cast<double>() + in_cube;
            if (std::abs(inside.winding_number(cubes.origin + cubes.size * at)) > 1.5) return true;
        }
    }
    return false;
}

// Whether the mesh is closed and holds more than rounding leaves.
inline bool encloses(const geometry::TriMesh& mesh)
{
    constexpr double nothing = 1e-9;  // of area^1.5
    if (mesh.triangles().empty()) return false;
    return geometry::is_closed(mesh.triangles(), mesh.positions.size()) &&
           std::abs(geometry::mass_properties(mesh).mass) >
               nothing * std::pow(geometry::surface_area(mesh), 1.5);
}

// Of a mesh and the cubes that Voxelize made of it, `solid` or of its surface. Their mass is that
// of bricks (physics/state/cube_mass.hpp); lattices and springs have it on the corners of the
// cubes, which adds m h^2 / 3 to each moment of inertia, where bricks add 0.013 m h^2. `bending`:
// the stiffness in bending of the part that is most wrong, times the true one; not a number where
// it is not known. Of open meshes, of surfaces and without a mesh nothing is known to compare with;
// of cubes of several densities volume and stiffness alone are. `once`: cubes hold once what is in
// several parts of the mesh. `total`: the mass that is asked for, kg; 0: none. `by_parity`: parts
// of the mesh that lie in others are hollows, whichever way they are wound.
inline graph::Figures body_figures(const geometry::TriMesh* mesh, const geometry::Cubes& cubes,
                                   bool solid, double bending, bool once = false, double total = 0,
                                   bool by_parity = false)
{
    constexpr double unknown = graph::Figure::unknown;
    geometry::TriMesh faces;  // as the cubes are made of them
    if (mesh && solid) faces = mesh_of(*mesh, geometry::solid_faces(*mesh));
    if (mesh && solid && by_parity) geometry::wind_by_parity(faces);
    const bool closed = mesh && solid && encloses(faces);
    geometry::MassProperties body;
    if (closed) body = geometry::mass_properties(faces);
    const bool overlap = closed && once && parts_overlap(faces, body.mass, cubes);
    const bool known = closed && !overlap;
    const physics::MassMoments model = moments_at_rest(cubes);
    const double density = one_density(cubes);
    const auto exact = [&](double x) { return known && body.mass > 0 ? x : unknown; };
    const auto of_mass = [&](double x) { return std::isnan(density) ? unknown : exact(x); };
    graph::Figures out{
        "body",
        {{"cubes", static_cast<double>(cubes.count())},
         {"size of a cube, m", cubes.size},
         {"volume, m^3", volume_held(cubes), exact(body.mass)},
         {"mass, kg", model.mass, of_mass(total > 0 ? total : density * body.mass)}}};
    for (int k = 0; k < 3; ++k) {
        out.all.push_back(
            {fmt::format("centre {}, m", "xyz"[k]), model.centre[k], of_mass(body.centre[k])});
    }
    for (int k = 0; k < 3; ++k) {
        out.all.push_back({fmt::format("inertia about {} per mass, m^2", "xyz"[k]),
                           model.inertia(k, k) / model.mass,
                           of_mass(body.inertia(k, k) / body.mass)});
    }
    out.all.push_back({"stiffness in bending, of the true one", exact(bending), exact(1)});
    if (overlap) out.all.push_back({graph::overlapping_parts, 1});
    return out;
}

}  // namespace nodes

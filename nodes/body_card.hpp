#pragma once

// What `aspic card` says of a body: how far its cubes are from the mesh that they stand for.

#include "geometry/mesh/mass_properties.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "nodes/wire_types.hpp"
#include "physics/bricks/bending_error.hpp"
#include "physics/state/measure.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

namespace nodes {

// A quantity, with what it is of the mesh and of the cubes; not a number where that is not known.
using CardLine = std::pair<std::string, std::array<double, 2>>;

inline double count_cubes(const graph::Value& cubes)
{
    return static_cast<double>(cubes.as<geometry::Cubes>()->count());
}

// kg/m^3; not a number where the cubes are not all of one density.
inline double one_density(const geometry::Cubes& cubes)
{
    const double per_fill = std::pow(cubes.size, 3);
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double density = cubes.mass[c] / (cubes.fill[c] * per_fill);
        least = std::min(least, density), most = std::max(most, density);
    }
    return most - least <= 1e-4 * most ? most : std::numeric_limits<double>::quiet_NaN();
}

// Of a mesh and the cubes that Voxelize made of it. Their mass is that of bricks
// (physics/state/cube_mass.hpp); lattices and springs have it on the corners of the cubes, which
// adds m h^2 / 3 to each moment of inertia, where bricks add 0.013 m h^2. Of an open mesh nothing
// is known.
inline std::vector<CardLine> body_card(const graph::Value& mesh_value,
                                       const graph::Value& cubes_value)
{
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const geometry::Cubes& cubes = *cubes_value.as<geometry::Cubes>();
    const geometry::TriMesh& mesh = *mesh_value.as<geometry::TriMesh>();
    const bool closed = geometry::is_closed(mesh.triangles(), mesh.positions.size());
    const geometry::MassProperties body = geometry::mass_properties(mesh);
    physics::State at_rest;
    at_rest.x = geometry::corner_positions(cubes);
    at_rest.v.assign(at_rest.x.size(), geometry::Vec3::Zero());
    at_rest.brick_mass = true;
    const physics::MassMoments model = physics::mass_moments(at_rest, cubes);
    const auto exact = [&](double x) { return closed && body.mass > 0 ? x : unknown; };
    double volume = 0;
    for (const double fill : cubes.fill) volume += fill * std::pow(cubes.size, 3);
    std::vector<CardLine> lines{
        {"cubes", {unknown, static_cast<double>(cubes.count())}},
        {"size of a cube, m", {unknown, cubes.size}},
        {"volume, m^3", {exact(body.mass), volume}},
        {"mass, kg", {exact(one_density(cubes) * body.mass), model.mass}},
    };
    for (int k = 0; k < 3; ++k) {
        lines.push_back(
            {fmt::format("centre {}, m", "xyz"[k]), {exact(body.centre[k]), model.centre[k]}});
    }
    for (int k = 0; k < 3; ++k) {
        lines.push_back(
            {fmt::format("inertia about {} per mass, m^2", "xyz"[k]),
             {exact(body.inertia(k, k) / body.mass), model.inertia(k, k) / model.mass}});
    }
    // Of shells the estimate knows nothing.
    const bool solid = closed && std::abs(volume - body.mass) < 0.1 * body.mass;
    const auto parts = physics::thin_parts(mesh, cubes, {solid, 0});
    const bool known = solid && cubes.elements.empty();  // nor of what is calibrated
    const double factor = !known ? unknown : parts.empty() ? 1 : parts.front().factor;
    lines.push_back({"stiffness in bending, of the true one", {exact(1), exact(factor)}});
    return lines;
}

}  // namespace nodes

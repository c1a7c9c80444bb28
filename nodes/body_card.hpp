#pragma once

// What `aspic card` says of a body: how far its cubes are from the mesh that they stand for.

#include "geometry/mesh/mass_properties.hpp"
#include "geometry/mesh/mesh_edges.hpp"
#include "nodes/wire_types.hpp"
#include "physics/bricks/bending_error.hpp"

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

// Of a mesh and the cubes that Voxelize made of it. The mass of the cubes lies on their corners, as
// the solvers have it. Of an open mesh nothing is known.
inline std::vector<CardLine> body_card(const graph::Value& mesh_value,
                                       const graph::Value& cubes_value)
{
    constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
    const geometry::Cubes& cubes = *cubes_value.as<geometry::Cubes>();
    const geometry::TriMesh& mesh = *mesh_value.as<geometry::TriMesh>();
    const bool closed = geometry::is_closed(mesh.triangles(), mesh.positions.size());
    const geometry::MassProperties body = geometry::mass_properties(mesh),
                                   model =
                                       geometry::mass_properties(geometry::corner_positions(cubes),
                                                                 geometry::corner_masses(cubes));
    const auto exact = [&](double x) { return closed && body.mass > 0 ? x : unknown; };
    double volume = 0;
    for (const double fill : cubes.fill) volume += fill * std::pow(cubes.size, 3);
    std::vector<CardLine> lines{
        {"cubes", {unknown, static_cast<double>(cubes.count())}},
        {"size of a cube, m", {unknown, cubes.size}},
        {"volume, m^3", {exact(body.mass), volume}},
        {"mass, kg", {unknown, model.mass}},
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

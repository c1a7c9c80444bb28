#pragma once

// The body that Simulate makes of its cubes: one kind for each method, and one of both for sheets
// beside solids.

#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "nodes/simulate_faults.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/mixed/mixed.hpp"
#include "physics/shell/shell.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <variant>
#include <vector>

namespace nodes::simulate {

enum class Method { bricks, springs, lattice, shell };

struct Body {
    std::variant<physics::BricksBody, physics::SpringsBody, physics::LatticeBody,
                 physics::ShellBody, physics::MixedBody>
        is;
    std::vector<physics::StateModel> models;  // of several

    std::size_t bytes() const
    {
        return std::visit([](const auto& body) { return body.bytes(); }, is);
    }
    // Whether cubes have the mass of bricks.
    bool has_brick_mass() const
    {
        if (const auto* const own = std::get_if<physics::BricksBody>(&is)) {
            return own->has_brick_mass();
        }
        const auto* const mixed = std::get_if<physics::MixedBody>(&is);
        return mixed && mixed->has_brick_mass();
    }
};

// Throws std::invalid_argument where the mesh of link `i` is nowhere near its cubes.
inline void check_surface(const geometry::Cubes& cubes, const geometry::TriMesh& mesh,
                          std::size_t i)
{
    geometry::Box box, surface = geometry::bounds(mesh);
    for (const geometry::Vec3& p : geometry::corner_positions(cubes)) box.add(p);
    if (surface.empty() || box.empty()) return;
    const bool apart = ((surface.lo - box.hi).array() > cubes.size).any() ||
                       ((box.lo - surface.hi).array() > cubes.size).any();
    if (!apart) return;
    throw std::invalid_argument(
        fmt::format("surface[{}] lies apart from cubes[{}], whose mesh it should be at rest: link "
                    "the meshes in the order of the cubes, as they were voxelized",
                    i, i));
}

struct MethodOptions {
    physics::BrickOptions bricks;
    physics::SpringOptions springs;
    physics::LatticeOptions lattice;
    physics::ShellOptions shell;
};

inline Body make_body(const std::vector<physics::BodyModel>& models, Method method,
                      const MethodOptions& options, std::vector<physics::StateModel> numbered)
{
    const auto is_flat = [](const physics::BodyModel& model) {
        return geometry::flat_axis(*model.cubes) >= 0;
    };
    const auto flat = std::count_if(models.begin(), models.end(), is_flat);
    if (method == Method::bricks && flat > 0 && std::size_t(flat) < models.size()) {
        return {physics::make_mixed(models, options.bricks, options.shell), std::move(numbered)};
    }
    const bool planes = method == Method::shell;
    const physics::BodyModels all(models,
                                  planes ? physics::ModelKind::plane : physics::ModelKind::solid);
    switch (method) {
    case Method::bricks:
        return {physics::make_bricks(all, options.bricks), std::move(numbered)};
    case Method::springs:
        return {physics::make_springs(all, options.springs), std::move(numbered)};
    case Method::lattice:
        if (models.size() > 1) throw std::invalid_argument(lattice_of_several);
        return {physics::make_lattice(all.all(), options.lattice, models[0].surface),
                std::move(numbered)};
    case Method::shell:
        return {physics::make_shell(all, options.shell), std::move(numbered)};
    }
    throw std::logic_error("Simulate: a method without a body");
}

}  // namespace nodes::simulate

#pragma once

// Solids of bricks and sheets of thin shell that move together and push each other: a ball in a
// net, plates on a cloth. Each keeps its own elasticity (bricks_body.hpp, shell_body.hpp); steps,
// contacts and friction are those of all (bricks/time_step.hpp, body/posed_solids.hpp).

#include "physics/bricks/bricks_body.hpp"
#include "physics/shell/shell_body.hpp"

#include <memory>
#include <vector>

namespace physics {

struct MixedBody {
    CornerBody base;  // slots of the solids, then those of the sheets (body/join_bodies.hpp)
    BricksBody bricks;
    ShellBody shell;
    std::vector<std::uint32_t> solid_corner, sheet_corner;  // of all, of each of their own
    std::vector<std::uint32_t> solid_cube;                  // likewise
    std::size_t cubes = 0;                                  // of all
    std::shared_ptr<DissectionCache> dissections;

    bool has_brick_mass() const { return bricks.has_brick_mass(); }
    std::size_t bytes() const;
};

// Of models of which some are planes or sheets and others are not. Surfaces may be null, and count
// for solids alone. Contact of both is that of `bricks`. Throws std::invalid_argument where the
// models are of one kind, are no bodies, or sheets are to yield.
MixedBody make_mixed(std::span<const BodyModel> models, const BrickOptions& bricks,
                     const ShellOptions& shell);

State rest_state(const MixedBody& body);

}  // namespace physics

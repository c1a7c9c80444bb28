#pragma once

// A body of cubes as lattice shape matching steps it: particles on the corners, their regions, and
// of a plane its membrane. Plain data, made once by make_lattice() (lattice.hpp).

#include "physics/body/corner_body.hpp"
#include "physics/lattice/lattice_options.hpp"
#include "physics/lattice/matched_regions.hpp"
#include "physics/lattice/membrane.hpp"
#include "physics/lattice/near_along.hpp"
#include "physics/lattice/pinned_shapes.hpp"
#include "physics/regions/links.hpp"
#include "physics/state/state.hpp"

#include <array>
#include <memory>
#include <vector>

namespace physics {

// Regions of lattices with broken links: the last few that were asked for.
class TornRegions;

// All that depends on the cubes and the options that shape a body, not a step.
struct LatticeBody {
    CornerBody base;         // slots are the corners themselves
    LatticeOptions options;  // as it was made
    MatchedRegions whole;
    double damping = 0;       // tau, s, the mean of the cubes' stiffness damping
    int slender = 0;          // cubes along the shortest slender piece; 0: none is
    int compact = 0;          // cubes along the shortest of the others; 0: none is
    double soft_stretch = 1;  // times that a piece stretches too far, as it bends rightly
    double poisson = 0;       // the largest of a solid's cubes, of what is kept of it
    int flat_axis = -1;       // of a plane
    Membrane membrane;        // of a plane in space
    std::vector<std::array<std::uint32_t, 8>> cubes;  // C, their corners; where rest shapes flow
    std::vector<std::uint32_t> side;       // particles that lack a neighbour: bodies meet there
    NearAlong along;                       // of a body that touches itself
    LinkedPieces pieces;                   // that no breaks part
    std::shared_ptr<TornRegions> torn;     // where links can break
    std::shared_ptr<PinnedShapes> pinned;  // where volume is kept, or rest shapes flow

    std::size_t bytes() const;
};

// The corners of cubes and their links.
Lattice corner_lattice(const geometry::Cubes& cubes);

State rest_state(const LatticeBody& body);

}  // namespace physics

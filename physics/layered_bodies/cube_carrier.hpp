#pragma once

// Cubes inside a step's linear system: frames that they carry are no unknowns, they follow corners.
//
//   velocities   take_along():       corners --J--> carried frames
//   forces       hand_to_corners():  corners <-J^T- carried frames        J: FrameHold::by
//
// `x`, `y` have one entry a frame and corner, as LayeredSystem numbers them.

#include "physics/layered_bodies/cube_base.hpp"

#include <memory>
#include <span>
#include <vector>

namespace physics {

// The cubes of one body, which carry the frames from first_frame on.
struct CubeCarrier {
    const CubeBase* base = nullptr;
    std::size_t first_frame = 0, first_corner = 0;
    std::vector<FrameHold> holds;  // one a frame
    std::unique_ptr<Elasticity> elasticity;
    Aligned<double> diagonal;  // by slot, about, of its terms
    Aligned<double> in, out;   // by slot, for add_elastic()

    const CornerBody& corner_body() const { return base->bricks().base; }
};

// Every carried frame's part of x from its corners'.
void take_along(std::span<const CubeCarrier> carriers, std::vector<Vec6>& x);

// What y has for carried frames goes to their corners.
void hand_to_corners(std::span<const CubeCarrier> carriers, std::vector<Vec6>& y);

// The same of the diagonal's blocks, as far as it stays on the diagonal, and the cubes' own.
void add_to_corner_blocks(std::span<const CubeCarrier> carriers, std::vector<Mat6>& blocks);

// y += (dt C + dt^2 K) x of cubes. Uses their memory.
void add_elastic(std::span<CubeCarrier> carriers, const std::vector<Vec6>& x, std::vector<Vec6>& y);

}  // namespace physics

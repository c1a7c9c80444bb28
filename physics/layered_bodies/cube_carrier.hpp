#pragma once

// Frames inside a step's linear system that others carry: corners of cubes, or masses of a net.
// They are no unknowns, they follow.
//
//   velocities   take_along():  what carries --J--> carried frames
//   forces       hand_on():     what carries <-J^T- carried frames        J: FrameHold::by
//
// `x`, `y` have one entry a frame and corner, as LayeredSystem numbers them.

#include "physics/layered_bodies/cube_base.hpp"

#include <memory>
#include <span>
#include <vector>

namespace physics {

// A frame, what carries it, and how.
struct CarriedFrame {
    std::size_t frame = 0;
    std::vector<std::size_t> on = {};
    std::vector<Eigen::Matrix<double, 6, 3>> by = {};  // one for each that carries it
};

// The cubes of one body.
struct CubeCarrier {
    const CubeBase* base = nullptr;
    std::size_t first_frame = 0, first_corner = 0;
    std::unique_ptr<Elasticity> elasticity;
    Aligned<double> diagonal;  // by slot, about, of its terms
    Aligned<double> in, out;   // by slot, for add_elastic()

    const CornerBody& corner_body() const { return base->bricks().base; }
};

// Every carried frame's part of x from that of what carries it.
void take_along(std::span<const CarriedFrame> carried, std::vector<Vec6>& x);

// What y has for carried frames goes to what carries them.
void hand_on(std::span<const CarriedFrame> carried, std::vector<Vec6>& y);

// The same of the diagonal's blocks, as far as it stays on the diagonal.
void hand_on_blocks(std::span<const CarriedFrame> carried, std::vector<Mat6>& blocks);

// The diagonal of cubes.
void add_to_corner_blocks(std::span<const CubeCarrier> carriers, std::vector<Mat6>& blocks);

// y += (dt C + dt^2 K) x of cubes. Uses their memory.
void add_elastic(std::span<CubeCarrier> carriers, const std::vector<Vec6>& x, std::vector<Vec6>& y);

}  // namespace physics

#pragma once

// The coarsest cubes whose stiffness is within an error.
//
// What is compared is the stiffness k = omega^2 of the lowest vibrations of the free body, which
// need no loads and no pins: deflections under loads are wrong by as much. Sizes are halved. Of k1,
// k2, k3 at sizes h, 2h, 4h,
//   p = log2((k3 - k2) / (k2 - k1)),   k* = k1 - (k2 - k1) / (2^p - 1)
// are the observed order and the stiffness at size 0 (Richardson, Gaunt. The deferred approach to
// the limit. Phil. Trans. A 226, 1927; Roache. Quantification of uncertainty in computational fluid
// dynamics. Annu. Rev. Fluid Mech. 29, 1997). Two sizes would not show whether the values have
// begun to converge. A tilted wall of thickness t is 1 + 1.5 (h / t)^2 times too stiff, from cubes
// as thick as the wall on: of order 2 in k, and of much less in 1 / k.

#include "geometry/cubes/cubes.hpp"

#include <functional>
#include <limits>
#include <optional>

namespace physics {

// Cubes of a size that was tried.
struct TriedSize {
    double size = 0;  // m
    std::size_t cubes = 0;
    std::vector<double> omega_sq;  // 1/s^2, of the lowest vibrations; empty: not all were found
    double error = 0;              // estimated, relative; infinity: not known
};

struct SizeForError {
    double size = 0;   // m, the coarsest that is within the error, else the one nearest to it
    double error = 0;  // estimated, relative; infinity: not known
    double order = 0;  // of the vibration that is most wrong; 0: values do not converge yet
    std::size_t vibration = 0;  // that is most wrong
    bool reached = false;
    bool foretold = false;         // by the order, 1 where none is known: this size was not tried
    double would_do = 0;           // m, not reached: cubes that the order promises; 0: not known
    std::vector<TriedSize> tried;  // the coarsest first; the last three tell order and error
};

struct SizeSearch {
    double start = 0;  // m, the coarsest size to try
    double error = 0.05;
    // m, no answer before cubes as small as this were tried: what they blur cannot be judged.
    double finest_needed = std::numeric_limits<double>::infinity();
    std::size_t most_tried = 30'000;     // cubes
    std::size_t most_at_last = 100'000;  // cubes, of one more size before the order foretells more
    std::size_t most = std::numeric_limits<std::size_t>::max();  // cubes that `cubes_of` makes
};

// `cubes_of` makes cubes of a size, nothing where they would be too many. Cubes that would be more
// than `most_tried` are not tried: the order foretells the size. Where that would be less than half
// of the finest size that was tried, one more is, of up to `most_at_last` cubes: an order that is
// wrong is wrong by more the farther it is carried. Where the cubes would be too many, the answer
// is about the finest that is not. Throws what lowest_modes() throws for the coarsest cubes. The
// same for any number of threads.
SizeForError size_for_error(const std::function<std::optional<geometry::Cubes>(double)>& cubes_of,
                            const SizeSearch& search);

}  // namespace physics

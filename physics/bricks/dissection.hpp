#pragma once

// In which order to eliminate the corners of cubes from a linear system so that little fills in.
// George. Nested dissection of a regular finite element mesh. SIAM J. Numer. Anal. 10(2), 1973.
// Cubes join only corners whose lattice coordinates differ by at most one, so the corners on any
// lattice plane part those on its two sides:
//
//     below | on | above        eliminated in this order: below, above, on;
//     o o o | o  | o o          below and above are cut again until they are small
//     o o o | o  | o o
//
// A factorisation that works front by front takes dissect(): the cut is the plane that holds fewest
// corners, not too far from the middle, and each cut is a front of its own (Duff, Reid. The
// multifrontal solution of indefinite sparse symmetric linear equations. ACM TOMS 9(3), 1983). One
// that works column by column takes order_for_elimination(): the plane through the middle corner,
// and planes are cut again in themselves.

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/cubes.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

namespace physics {

// A set of corners eliminated together.
struct Front {
    std::vector<std::uint32_t> pivots;  // corners eliminated here
    std::vector<std::uint32_t> border;  // corners eliminated later that they meet
    std::vector<std::uint32_t> cubes;   // that are added in here
    // Where their corners are: among pivots then border; no_index where left out.
    std::vector<std::array<std::uint32_t, 8>> corner_at;
    std::vector<std::uint32_t> children;  // fronts, all before this one
    std::uint32_t parent = geometry::no_index;
    // Where each border corner is in the parent: among pivots then border.
    std::vector<std::uint32_t> in_parent;
    double entries = 0;  // of the factor's columns here and below, in 3 x 3 blocks
};

// The corner at a place among pivots then border.
inline std::uint32_t corner_of(const Front& front, std::uint32_t at)
{
    return at < front.pivots.size() ? front.pivots[at] : front.border[at - front.pivots.size()];
}

struct Dissection {
    std::vector<Front> fronts;         // children before parents
    std::vector<std::uint32_t> roots;  // fronts without a parent
    double entries = 0;                // of all, in 3 x 3 blocks
    double products = 0;               // of 3 x 3 blocks that a factorisation takes
};

// The fronts of a dissection as they come, children first, and which front each corner is in.
struct FrontList {
    FrontList(std::size_t corners, const std::vector<char>& left_out)
        : front_of(corners, geometry::no_index)
    {
        for (std::uint32_t k = 0; k < corners; ++k) {
            if (left_out.empty() || !left_out[k]) taken.push_back(k);
        }
    }

    // Returns its number. Pivots are put in order, as corners of a border are.
    std::uint32_t add(std::span<const std::uint32_t> pivots, std::vector<std::uint32_t> children)
    {
        const auto index = static_cast<std::uint32_t>(fronts.size());
        Front& front = fronts.emplace_back();
        front.pivots.assign(pivots.begin(), pivots.end());
        std::sort(front.pivots.begin(), front.pivots.end());
        front.children = std::move(children);
        for (const auto k : front.pivots) front_of[k] = index;
        return index;
    }

    std::vector<std::uint32_t> taken;  // corners that take part, ascending
    std::vector<Front> fronts;
    std::vector<std::uint32_t> front_of;  // K; no_index: none
};

// Parts of at most so many corners are not cut further.
inline constexpr std::size_t uncut_corners = 24;

// Corners marked in `left_out` (K, or empty: none) take no part. Stops, with no fronts, as soon as
// the entries would be more than `most`.
Dissection dissect(const geometry::Cubes& cubes, const std::vector<char>& left_out, double most,
                   std::size_t uncut = uncut_corners);

// The same for elements that lie anywhere, each with up to eight corners (the others name one of
// them again), by where the corners are (K, m): parts are halved along their longest side, and the
// corners of one half that meet the other part them.
using ElementCorners = std::vector<std::array<std::uint32_t, 8>>;
Dissection dissect(const ElementCorners& elements, std::span<const geometry::Vec3> places,
                   const std::vector<char>& left_out, double most,
                   std::size_t uncut = uncut_corners);

// Adds to fronts of which pivots, children and their order are known what they meet. `front_of`
// says where each corner is eliminated (K; no_index: nowhere).
Dissection with_borders(std::vector<Front> fronts, const std::vector<std::uint32_t>& front_of,
                        const ElementCorners& elements, double most);

// Puts corners in the order in which to eliminate them.
void order_for_elimination(const geometry::Cubes& cubes, std::span<std::uint32_t> corners);

}  // namespace physics

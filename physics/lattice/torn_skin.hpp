#pragma once

// What a tear changes of a skin: corners within come to lie open, and points of cubes that are no
// longer joined go with the corners of their part, as the mesh does (geometry/embed/cut_torn.hpp).
//
//     +-----+-----+        A cube whose links are all broken between left and right: its skin's
//     |  1  :  2  |        points on the left of the middle go with the left corners (part 1),
//     |     :     |        the others with the right ones (part 2).
//     +-----+-----+

#include "geometry/embed/corner_frames.hpp"
#include "physics/body/contact_surface.hpp"
#include "physics/regions/links.hpp"

#include <algorithm>
#include <span>

namespace physics {

class TornSkin {
public:
    using Parts = std::array<std::uint8_t, 8>;  // of the corners of a cube

    // `h`: m, a link at rest; `broken` as in State.
    TornSkin(const ContactSurface& skin, const Lattice& lattice,
             std::span<const std::uint32_t> broken, double h);

    bool is_open(std::size_t cube) const { return row_[cube] != none; }
    // Null: its corners are joined.
    const Parts* parts_of(std::size_t cube) const
    {
        return row_[cube] < parts_.size() ? &parts_[row_[cube]] : nullptr;
    }
    // Corners by a broken link that no point of the skin goes with: they are touched themselves.
    std::span<const std::uint32_t> bare() const { return bare_; }
    const geometry::CornerFrames& frames() const { return frames_; }

private:
    void find_bare(const ContactSurface& skin, std::vector<std::uint8_t> open);

    geometry::CornerFrames frames_;
    std::vector<std::uint32_t> row_;  // S, into parts_; beyond: open, and joined; none: whole
    std::vector<Parts> parts_;
    std::vector<std::uint32_t> bare_;
};

// That whose octant of the cube holds a point with these weights.
inline std::uint8_t part_of(const std::array<float, 8>& weight, const TornSkin::Parts& parts)
{
    return parts[std::size_t(std::ranges::max_element(weight) - weight.begin())];
}

}  // namespace physics

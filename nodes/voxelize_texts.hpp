#pragma once

// What Voxelize says of parameters and inputs that do not go together.

namespace nodes::voxelize {

inline constexpr const char* needs_points =
    "method = samples needs the input 'points': link a Sample node, or use method = surface or "
    "solid for a mesh";
inline constexpr const char* needs_mesh =
    "method = surface or solid needs the input 'mesh': link a mesh, or use method = samples for "
    "points";

inline constexpr const char* calibrated_solids =
    "stiffness = calibrated needs closed solids, found faces with a thickness: set thickness = 0, "
    "or stiffness = filled";
inline constexpr const char* calibrated_by_size =
    "quality chooses the size of cubes by their stiffness as filled, which stiffness = calibrated "
    "replaces: set quality = by_size and a size, or stiffness = filled";

}  // namespace nodes::voxelize

#pragma once

// What the reference says of parameters that all obstacles have.

namespace nodes {

inline constexpr const char* friction_text =
    "Coulomb coefficient of friction: 0 for ice, 0.5 for wood on wood, 1 for rubber.";
inline constexpr const char* bounce_text =
    "Share of the speed of an impact that bricks, springs and sheets leave it with (coefficient of "
    "restitution): 0 for clay, 0.5 for wood, 0.9 for a rubber ball. Slow impacts do not bounce. "
    "What is so soft that it takes longer than a step to spring back leaves faster, and with a "
    "stated number of steps faster or slower. "
    "Method lattice, Vibrate and Layered ignore it.";

}  // namespace nodes

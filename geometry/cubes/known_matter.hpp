#pragma once

// Materials by name: rounded values of materials as they are usually sold, each from the source
// that is named. Woods are those along the grain, in all directions; rubber and tissue are linear.
//
//   EN 1993-1-1, 3.2.6 (steel); EN 1999-1-1, 3.2.5 (aluminium); EN 1992-1-1, table 3.1, C30/37
//   (concrete); EN 572-1 (glass). Ross (ed.). Wood handbook, FPL-GTR-190. 2010, table 5-3, at 12 %
//   moisture (white oak, eastern white pine). Ashby. Materials selection in mechanical design.
//   2011, appendix A (rubber, nylon, leather, cork, foam: middles of ranges). Currey. Bones. 2002
//   (bone, along it). Schulson, Duval. Creep and fracture of ice. 2009 (ice). Fung. Biomechanics.
//   1993 (flesh: muscle at rest, small strains). Jelly is a table jelly of gelatine and water;
//   values differ by a factor of three with its strength.
//
// Damping is that with the stiffness, beta = loss / (2 pi 10 Hz): the loss factor, twice the
// damping ratio, at 10 Hz. Loss factors: Cremer, Heckl, Petersson. Structure-borne sound. 2005, and
// estimates where it has none (jelly, flesh, leather, bone, ice).

#include "geometry/cubes/matter.hpp"

#include <array>
#include <numbers>

namespace geometry {

struct KnownMatter {
    const char* name;
    double density;  // kg/m^3
    double young;    // Pa
    double poisson;
    double loss;  // factor, at 10 Hz

    Matter matter() const
    {
        return {name, density, young, poisson, 0, loss / (2 * std::numbers::pi * 10)};
    }
};

inline constexpr std::array known_matters{
    KnownMatter{"steel", 7850, 210e9, 0.3, 0.0005},
    KnownMatter{"aluminium", 2700, 70e9, 0.3, 0.0005},
    KnownMatter{"glass", 2500, 70e9, 0.2, 0.002},
    KnownMatter{"concrete", 2400, 33e9, 0.2, 0.008},
    KnownMatter{"ice", 917, 9.3e9, 0.33, 0.01},
    KnownMatter{"bone", 1900, 18e9, 0.3, 0.02},
    KnownMatter{"oak", 760, 12.3e9, 0.37, 0.01},
    KnownMatter{"pine", 390, 8.5e9, 0.34, 0.01},
    KnownMatter{"nylon", 1130, 3e9, 0.4, 0.03},
    KnownMatter{"leather", 900, 0.2e9, 0.4, 0.1},
    KnownMatter{"cork", 180, 20e6, 0.05, 0.15},
    KnownMatter{"rubber", 925, 2e6, 0.49, 0.1},
    KnownMatter{"foam", 40, 0.1e6, 0.3, 0.2},
    KnownMatter{"flesh", 1060, 20e3, 0.49, 0.3},
    KnownMatter{"jelly", 1030, 10e3, 0.49, 0.1},
};

}  // namespace geometry

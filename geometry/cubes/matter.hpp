#pragma once

// What a model is made of.

#include <string>

namespace geometry {

// What a piece of a model is made of.
struct Matter {
    std::string name = "default";
    double density = 1000;         // kg/m^3, of the solid material
    double young = 1e6;            // Pa
    double poisson = 0.3;          // 0 <= nu < 0.5
    double mass_damping = 0;       // 1/s, Rayleigh alpha
    double stiffness_damping = 0;  // s, Rayleigh beta

    bool operator==(const Matter&) const = default;
};

}  // namespace geometry

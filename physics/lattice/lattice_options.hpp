#pragma once

// What shapes a lattice body and its steps: width of regions, stiffness, flow, tearing, contact.

#include "physics/body/stiffness.hpp"
#include "physics/state/plastic.hpp"

namespace physics {

enum class Precision { single, full };
enum class Stiffness { material, rate };
enum class PlaneMotion { space, in_plane };
// What the rate from the material is right for: long waves of stretch, or a bend of the whole body.
// (Regions resist bending on their own, so thin bodies that stretch rightly bend too stiffly.) Or
// both, where bends within regions have a rate of their own (bend_ratio.hpp).
enum class Calibration { bending, stretch, both };

// Contact of bodies that are not linked with each other, and of one with itself: particles as
// balls.
struct BodyContactOptions {
    bool on = false;
    bool self = false;    // a body with itself too, where it folds
    double distance = 0;  // m, between particles; 0: the cubes' edge
    double friction = 0.3;

    // m, in a body of cubes of that size (m).
    double distance_in(double size) const { return distance > 0 ? distance : size; }
};

struct LatticeOptions {
    int half_width = 2;  // w, of regions, in cubes
    Weighting weighting = Weighting::filled;
    Stiffness stiffness = Stiffness::material;  // s from the material, or `rate` everywhere
    Calibration calibrate = Calibration::both;
    double rate = 100;   // s, 1/s; infinite: as stiff as the regions allow
    double bend = 1;     // of a plane: b^2 over what its thickness gives, or over rate^2
    double damping = 0;  // tau, s, on top of the material's own stiffness damping
    PlaneMotion plane = PlaneMotion::space;
    PlasticOptions plastic = {};
    double tear = 0;  // strain at which a link breaks; 0: never
    BodyContactOptions contact = {};
    int substeps = 4;                         // a frame
    Precision precision = Precision::single;  // of the sums over regions; motion is kept in double
};

}  // namespace physics

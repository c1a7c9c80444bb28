#pragma once

// Rest shapes that give way for good, of whatever has a rest shape of its own: a region of a
// lattice, a brick, a triangle of a shell.
//
// With S the stretch that the rest shape has come to and U that of now, both symmetric, the strain
// of a region or a triangle is e = U S^-1 - I (that of a brick stands in brick_flow.hpp). Where its
// norm is above the yield strain, S grows towards U by
//   S' = (I + (1 - exp(-flow dt)) (1 - yield / |e|) e) S
// made symmetric, where a method asks for it with the volume that it had, and no further from I
// than the limit. Mueller, Heidelberger, Teschner, Gross. Meshless deformations based on shape
// matching. SIGGRAPH 2005.

#include "geometry/base/vec.hpp"

namespace physics {

struct PlasticOptions {
    double yield = 0;    // strain beyond which a rest shape gives way; 0: never
    double flow = 10;    // 1/s, how fast
    double limit = 0.5;  // strain of the rest shape, at most
};

// What bricks and triangles would flow by less in a step does not flow: without end, strains come
// closer to the yield strain.
inline constexpr double least_flow = 1e-12;

// Throws std::invalid_argument where one is out of its range.
void check_plastic(const PlasticOptions& options);

// Which share of a strain of this size becomes the rest shape's in dt seconds; 0: none. It is no
// more than a strain of a fifth in one step.
double share_that_flows(const PlasticOptions& options, double size, double dt);

// e, made symmetric.
geometry::Mat3 strain_beyond(const geometry::Mat3& stretch, const geometry::Mat3& rest);
// A stretch made smaller or larger until its volume is 1; as it is where it has none.
geometry::Mat3 with_volume_1(const geometry::Mat3& stretch);
// S' less I, before the limit, of a share of a strain; the volume of S' is 1 where it is kept.
geometry::Mat3 grown_rest(const geometry::Mat3& rest, double share, const geometry::Mat3& strain,
                          bool keeps_volume);

}  // namespace physics

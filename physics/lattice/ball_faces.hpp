#pragma once

// Where a ball touches the faces of a skin. Between its points small balls would fall through, and
// larger ones sink in and force them apart: of a radius of up to twice the cubes' edge, through a
// block of soft cubes. Balls smaller than the cubes touch faces alone: a push at a point beside
// them would lead them astray.

#include "physics/lattice/contact_scene.hpp"

#include <array>
#include <vector>

namespace physics {

inline bool touches_faces(const ContactScene& scene, const Ball& ball)
{
    return ball.radius < 4 * scene.body.h;  // from there on it sinks in by h / 16 at most
}
inline bool touches_points(const ContactScene& scene, const Ball& ball)
{
    return ball.radius >= scene.body.h;
}

// At the end of the step, if nothing stopped the ball.
struct FaceTouch {
    std::size_t cube;  // of the skin
    CornerRuns::Corners corners;
    std::array<double, 8> weight;  // of the place that is touched
    Vec3 normal;                   // to the ball
    double gap;                    // m
};

// The nearest place of each cube that no tear parts, where ball b touches it; of those that push
// much the same way, the deepest. Or, alone, the first face that the ball's centre passes through
// in the step: however fast it is, it stays on its side.
std::vector<FaceTouch> find_face_touches(const ContactScene& scene, std::uint32_t b);

}  // namespace physics

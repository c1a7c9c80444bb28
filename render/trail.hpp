#pragma once

// The paths of points over the last frames, as thin tubes that any picture or file can hold.
//
//   places --remember--> a cloud: the places of each frame, oldest first --trail_tubes--> tubes
//
// Tubes are rings about the points of a path, each turned as little as may be against the one
// before (parallel transport: Hanson, Ma. Parallel transport approach to curve framing. Indiana
// University TR 425, 1995).

#include "render/scene.hpp"

#include <span>
#include <string>
#include <vector>

namespace render {

// Whose paths: the mean of the mesh's vertices, those of its separate pieces, or vertices.
enum class TrailOf { centre, pieces, vertices };

// Where they are now, m. Of vertices, every `every`-th, of those of the material or group `part`
// unless that is empty. Throws std::invalid_argument where the mesh has no such part.
std::vector<Vec3f> trail_places(const TriMesh& mesh, TrailOf of, int every,
                                const std::string& part);

// The cloud `before` (null: none) with `places` as its latest, and no more than `frames` frames
// older than these. Its attributes are age (s) and diameter (m), which it keeps from its first
// frame on. With another number of places than before, it starts anew.
TriMesh remember(const TriMesh* before, std::span<const Vec3f> places, int frames,
                 double frame_seconds, float diameter);

// How the oldest end of a trail differs from the newest; those between are evenly in between.
struct TrailLook {
    Vec3f colour{0.85f, 0.25f, 0.05f}, pale{0.75f, 0.8f, 0.85f};  // linear RGB
    double fade = 0.8;                                            // share of `pale`
    double opacity = 1;                                           // of the oldest
    double taper = 0.8;  // share of the diameter that it has lost
    double longest = 1;  // s: the age that all of this is for
};

// A tube along the path of each place of remember(), with the attributes age (s) and speed (m/s). A
// place that has not moved has none.
TriMesh trail_tubes(const TriMesh& points, const TrailLook& look);

}  // namespace render

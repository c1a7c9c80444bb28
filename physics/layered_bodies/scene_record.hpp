#pragma once

// Layered scenes as files, from which they are drawn and meshed again without simulating.
//
//   scene.0012.layers          a frame: where each body stands, and the names of their files
//   scene.bodies/d41d8c.body   what a body is made of, named by the hash of its content
//
// All frames of a motion name the same files of bodies, each written once. A body that changes has
// another one, and frames that were written before stay whole.
//
// A surface is known by skeletons, contributions and blends, which are the body's; by where its
// frames are and how far its contributions have moved; and by how far each two bodies press each
// other, which says how high they bulge. So a frame holds 56 bytes for each frame of a body, 8 for
// each skeleton that keeps a volume, 16 for each two bodies that touch, and of soft substances what
// has fused. Numbers are those of the scene bit for bit, and so are pictures and meshes.
//
// Left out are velocities, samples and cubes: Layered does not continue a recorded scene, and
// Polygonize previews it by samples that it makes anew.

#include "physics/layered_bodies/layered.hpp"

#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace physics {

struct SceneRecord {
    std::string frame;  // the file of a frame
    std::map<std::string, std::string>
        bodies;  // files that it names, by their path from its folder
};

// `stem` begins the name of the bodies' folder.
SceneRecord record(const LayeredScene& scene, std::string_view stem);

// The paths of the files that a frame's file names, from its folder. Throws std::runtime_error for
// what is no frame's file, or a damaged one.
std::vector<std::string> bodies_of_record(std::string_view frame);

// The scene of a frame's file and of those that it names, in their order. Throws std::runtime_error
// saying what was expected and found.
LayeredScene read_record(std::string_view frame, std::span<const std::string> bodies);

// A recorded scene with samples made anew, where they stand as if they came from nowhere.
LayeredScene with_samples(LayeredScene scene);

}  // namespace physics

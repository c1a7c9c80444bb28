#pragma once

// A layered scene at a moment, laid out for contact and for drawing: frames in the world, fields,
// samples walked, contacts found.

#include "physics/layered_bodies/layered.hpp"
#include "physics/layers/layer_contact.hpp"

#include <utility>

namespace physics {

// Whose samples go to the surface that is drawn: volumes are told by it, or kept.
enum class Drawn { all, controlled };

// Holds what its own members point to, so it is not copied. Of a recorded scene: no samples, and
// of the contacts what bulges_of() asks for.
struct LayeredMoment {
    // `mesh_seconds`: how long meshes that change their shape took from where they were.
    explicit LayeredMoment(const LayeredScene& scene, double mesh_seconds = 0,
                           Drawn drawn = Drawn::all);
    LayeredMoment(const LayeredMoment&) = delete;
    LayeredMoment& operator=(const LayeredMoment&) = delete;

    std::vector<std::vector<Transform>> frames;
    std::vector<std::vector<Twist>> twists;
    std::vector<Field> fields;
    std::vector<SurfaceSamples> stretched;  // of nets; else empty
    std::vector<SampleWalk> walks;
    std::vector<MovingMesh> meshes;
    std::vector<ContactBody> bodies;
    Contacts contacts;
};

// 1/m: the slopes of both sides' fields at a contact.
std::pair<double, double> slopes_at(const LayeredMoment& moment, const LayerContact& contact);

}  // namespace physics

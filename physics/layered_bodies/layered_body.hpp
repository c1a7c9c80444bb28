#pragma once

// Makes layered bodies: from a layer and a base, from a collider, on cubes.

#include "physics/layered_bodies/layered.hpp"

namespace physics {

// A body from a layer drawn in the world: one frame for each number that layer.frame names. Rigid
// frames get mass, centre and inertia from what their territories hold at `density` kg/m^3,
// particles their mass; each skeleton is moved into its frame. `frames` gives orientation, and
// where particles and still frames are. Throws std::invalid_argument as make_field() and
// make_surface_samples() do, and for a frame that holds no volume.
LayeredBody make_layered_body(ImplicitLayer layer, BaseKind kind, double density,
                              double sample_spacing);

// A net (net_base.hpp) of point, segment and triangle skeletons, drawn in the world: points at one
// place are one mass, and layer.frame is made anew. Masses weigh what the skeletons' territories
// hold at `density` kg/m^3: a sample's share comes to them by its place on its skeleton. It has no
// springs. Throws std::invalid_argument for other kinds of skeletons, for one of no length or area,
// for a mass that no territory reaches, and as make_layered_body() does.
LayeredBody make_net_body(ImplicitLayer layer, double density, double sample_spacing);

// A rigid thing as a still part: the collider's shape, at its pose at the end of the frame, with
// its friction; a mesh as it changes.
LayeredPart rigid_part(const Collider& collider);

// Lets cubes carry the frames of a body as drawn, which was made `still`, and feel what they do.
// Throws std::invalid_argument where it was not, or the cubes are no solid body.
void set_on_cubes(LayeredBody& body, geometry::Cubes cubes, const BrickOptions& options = {});

// Makes pieces of a soft substance that come apart collide from then on: parts of a layer collide,
// and one whose skeletons all blend becomes one part.
void let_separate(ImplicitLayer& layer, LayerMatter& matter);

}  // namespace physics

#pragma once

// All types that can travel along a wire. A new type needs two lines here and one in
// wire_types.cpp: its name in documents and messages, and its WireType, through which the runtime
// measures, hashes, stores and restores values of it. The WireTypes are instantiated in
// wire_types.cpp only, to keep compile times low.

#include "geometry/cubes/cubes.hpp"
#include "geometry/cubes/samples.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/polylines.hpp"
#include "geometry/mesh/texture.hpp"
#include "graph/types/standard_wires.hpp"
#include "physics/layered_bodies/layered.hpp"
#include "physics/modal/vibrate.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/pressed_surface.hpp"
#include "physics/state/state.hpp"
#include "render/camera.hpp"
#include "render/image.hpp"

namespace graph {

template <> inline constexpr const char* wire_name<geometry::TriMesh> = "mesh";
template <> inline constexpr const char* wire_name<geometry::Polylines> = "lines";
template <> inline constexpr const char* wire_name<geometry::Samples> = "points";
template <> inline constexpr const char* wire_name<geometry::Cubes> = "cubes";
template <> inline constexpr const char* wire_name<physics::Pins> = "pins";
template <> inline constexpr const char* wire_name<physics::Force> = "force";
template <> inline constexpr const char* wire_name<physics::Collider> = "collider";
template <> inline constexpr const char* wire_name<physics::Ball> = "ball";
template <> inline constexpr const char* wire_name<physics::PartJoint> = "joint";
template <> inline constexpr const char* wire_name<physics::State> = "state";
template <> inline constexpr const char* wire_name<geometry::ImplicitLayer> = "implicit_layer";
template <> inline constexpr const char* wire_name<physics::LayeredPart> = "layered_part";
template <> inline constexpr const char* wire_name<physics::LayeredScene> = "layered_scene";
template <> inline constexpr const char* wire_name<physics::ModalModel> = "modal_model";
template <> inline constexpr const char* wire_name<physics::ModalState> = "modal_state";
template <> inline constexpr const char* wire_name<render::Image> = "image";
template <> inline constexpr const char* wire_name<render::Camera> = "camera";

extern template const WireType& wire_type<geometry::TriMesh>();
extern template const WireType& wire_type<geometry::Polylines>();
extern template const WireType& wire_type<geometry::Samples>();
extern template const WireType& wire_type<geometry::Cubes>();
extern template const WireType& wire_type<physics::Pins>();
extern template const WireType& wire_type<physics::Force>();
extern template const WireType& wire_type<physics::Collider>();
extern template const WireType& wire_type<physics::Ball>();
extern template const WireType& wire_type<physics::PartJoint>();
extern template const WireType& wire_type<physics::State>();
extern template const WireType& wire_type<geometry::ImplicitLayer>();
extern template const WireType& wire_type<physics::LayeredPart>();
extern template const WireType& wire_type<physics::LayeredScene>();
extern template const WireType& wire_type<physics::ModalModel>();
extern template const WireType& wire_type<physics::ModalState>();
extern template const WireType& wire_type<render::Image>();
extern template const WireType& wire_type<render::Camera>();

}  // namespace graph

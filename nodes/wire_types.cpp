#include "nodes/wire_types.hpp"

#include "geometry/fields/skeleton_mesh.hpp"
#include "graph/types/wire_type.hpp"

namespace graph {

template const WireType& wire_type<geometry::TriMesh>();
template const WireType& wire_type<geometry::Polylines>();
template const WireType& wire_type<geometry::Samples>();
template const WireType& wire_type<geometry::Cubes>();
template const WireType& wire_type<physics::Pins>();
template const WireType& wire_type<physics::Force>();
template const WireType& wire_type<physics::Collider>();
template const WireType& wire_type<physics::Ball>();
template const WireType& wire_type<physics::PartJoint>();
template const WireType& wire_type<physics::State>();
template const WireType& wire_type<geometry::ImplicitLayer>();
template const WireType& wire_type<physics::LayeredPart>();
template const WireType& wire_type<physics::LayeredScene>();
template const WireType& wire_type<physics::ModalModel>();
template const WireType& wire_type<physics::ModalState>();
template const WireType& wire_type<render::Image>();
template const WireType& wire_type<render::Camera>();

}  // namespace graph

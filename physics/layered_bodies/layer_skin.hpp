#pragma once

// A mesh that follows an implicit layer: a character's skin.
//
// Each vertex rides on the frames whose contributions reach it, in proportion to them,
//   w_b = sum of f_i over b's skeletons / sum of all,
// by the rigid motion that is the normalized sum of w_b times theirs as dual quaternions.
//   Kavan, Collins, Zara, O'Sullivan. Geometric skinning with approximate dual quaternion blending.
//   ACM Transactions on Graphics 27(4), 2008.
// It then goes along the gradient of the deformed field to where D has the value that the
// undeformed field had at the vertex at rest. So joints keep their roundness, and contacts,
// controlled volume and breathing, which the frames know nothing of, reach the skin. On the inner
// side of a joint that bends far it may start from within the other limb: until it is out it keeps
// to where its own frame's field is the largest. Where all this leaves the mesh crowded or
// stretched, each vertex slides along the surface towards where its neighbours have it at rest, by
// mean value coordinates.
//   Vaillant, Barthe, Guennebaud, Cani, Rohmer, Wyvill, Gourmel, Paulin. Implicit skinning:
//   real-time skin deformation with contact modeling. ACM Transactions on Graphics 32(4), 2013.
//   Floater. Mean value coordinates. Computer Aided Geometric Design 20(1), 2003.
// (There the mesh tells the field; here the layer is given, and the mesh is bound to it.)

#include "physics/layered_bodies/layered.hpp"

namespace physics {

struct LayerSkin {
    static constexpr std::size_t most = 4;               // frames a vertex
    std::vector<std::array<std::uint32_t, most>> frame;  // V
    std::vector<std::array<double, most>> weight;        // V, of each; their sum is 1
    std::vector<double> value;                           // V, of the field at rest; 0: out of reach
    std::vector<std::uint32_t> normal_vertex;            // N, whose each normal is
    // Neighbours of vertex v: ring[ring_at[v] .. ring_at[v + 1]), none on a rim; the weights, which
    // sum to 1, give its place among them in its tangent plane at rest, from which it is off by
    // -offset[v].
    std::vector<std::uint32_t> ring_at;  // V + 1
    std::vector<std::uint32_t> ring;
    std::vector<float> ring_weight;
    std::vector<geometry::Vec3f> offset;  // V, m
    int rounds = 0;                       // of sliding
    double thickness = 0;                 // m, of the thinnest contribution
    std::size_t out_of_reach = 0;         // vertices that the layer does not reach

    std::size_t bytes() const
    {
        return value.size() *
                   (sizeof(frame[0]) + sizeof(weight[0]) + sizeof(double) + sizeof(offset[0])) +
               (normal_vertex.size() + ring_at.size()) * sizeof(std::uint32_t) +
               ring.size() * (sizeof(ring[0]) + sizeof(ring_weight[0]));
    }
};

// Binds a mesh, drawn where the body is drawn. Vertices out of the layer's reach ride on the frame
// of the nearest skeleton, as they are; those on a rim, or where sheets meet, do not slide. Throws
// std::invalid_argument for a body without skeletons.
LayerSkin bind(const geometry::TriMesh& mesh, const LayeredBody& body);

// The mesh as body number `body` of the scene carries it. Throws std::invalid_argument where mesh,
// skin and scene do not fit each other.
geometry::TriMesh follow(const LayerSkin& skin, const geometry::TriMesh& mesh,
                         const LayeredScene& scene, std::size_t body);

}  // namespace physics

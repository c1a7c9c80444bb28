#pragma once

// Numbers at the vertices of a mesh that cubes carry, to colour by and to export: how far each is
// from its rest, how fast it moves, the stress in the cubes around it and the strain of their rest
// shape, the component it goes with.

#include "geometry/embed/embed.hpp"

namespace geometry {

// How far each vertex is from its place in `rest`. V, m. Throws std::invalid_argument when the two
// have different numbers of vertices.
std::vector<float> displacements(const TriMesh& mesh, const TriMesh& rest);

// How far each corner at x (K, m) is from its rest. K, m.
std::vector<double> displacements(const Cubes& cubes, std::span<const Vec3> x);

// The length of each velocity. K, m/s.
std::vector<double> speeds(std::span<const Vec3> v);

// What is known of the cubes as they are now; what is empty is not known.
struct CubeMotion {
    std::span<const Vec3> v;                // K, m/s
    std::span<const float> stress;          // C, Pa
    std::span<const float> plastic_strain;  // C
};

// Which numbers to leave at vertices.
struct CarriedNumbers {
    bool displacement = true;    // "displacement", m
    bool speed = true;           // "speed", m/s
    bool stress = true;          // "stress", Pa
    bool plastic_strain = true;  // "plastic_strain"
    bool component = true;       // "component"; only after components were sought
    std::string cubes = {};      // names of cube_values(), apart by commas or spaces
};

// Gives `mesh`, which is `rest` as the cubes carry it, those numbers that are known as attributes,
// in place of others of their names. Throws std::invalid_argument for a name that the cubes don't
// know.
void add_carried_numbers(TriMesh& mesh, const CarriedNumbers& which, const TriMesh& rest,
                         const Binding& binding, const Cubes& cubes, const CubeMotion& motion);

}  // namespace geometry

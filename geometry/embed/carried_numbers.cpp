#include "geometry/embed/carried_numbers.hpp"

#include "geometry/cubes/mean_attributes.hpp"
#include "geometry/mesh/mesh.hpp"

#include <stdexcept>
#include <string>

namespace geometry {
namespace {

void put_attribute(TriMesh& mesh, const std::string& name, const std::string& unit,
                   std::vector<float> values)
{
    std::erase_if(mesh.attributes, [&](const Attribute& a) { return a.name == name; });
    mesh.attributes.push_back({name, unit, std::move(values)});
}

std::vector<float> lengths(std::span<const Vec3f> vectors)
{
    std::vector<float> out(vectors.size());
    for (std::size_t v = 0; v < out.size(); ++v) out[v] = vectors[v].norm();
    return out;
}

// The component that carries each vertex.
std::vector<float> components(const Binding& binding, const Cubes& cubes)
{
    std::vector<float> out(binding.cube.size());
    for (std::size_t v = 0; v < out.size(); ++v) {
        out[v] = static_cast<float>(cubes.component[binding.used[binding.cube[v]]]);
    }
    return out;
}

}  // namespace

std::vector<float> displacements(const TriMesh& mesh, const TriMesh& rest)
{
    if (mesh.positions.size() != rest.positions.size()) {
        throw std::invalid_argument("expected the mesh at rest to have " +
                                    std::to_string(mesh.positions.size()) + " vertices, found " +
                                    std::to_string(rest.positions.size()));
    }
    std::vector<float> out(mesh.positions.size());
    for (std::size_t v = 0; v < out.size(); ++v) {
        out[v] = (mesh.positions[v] - rest.positions[v]).norm();
    }
    return out;
}

std::vector<double> displacements(const Cubes& cubes, std::span<const Vec3> x)
{
    std::vector<double> out(x.size());
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = (x[k] - cubes.corner_position(k)).norm();
    return out;
}

std::vector<double> speeds(std::span<const Vec3> v)
{
    std::vector<double> out(v.size());
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = v[k].norm();
    return out;
}

void add_carried_numbers(TriMesh& mesh, const CarriedNumbers& which, const TriMesh& rest,
                         const Binding& binding, const Cubes& cubes, const CubeMotion& motion)
{
    if (which.displacement) put_attribute(mesh, "displacement", "m", displacements(mesh, rest));
    if (which.speed && motion.v.size() == cubes.corner_count()) {
        put_attribute(mesh, "speed", "m/s", lengths(carried_vectors(binding, cubes, motion.v)));
    }
    if (which.stress && motion.stress.size() == cubes.count()) {
        put_attribute(mesh, "stress", "Pa",
                      interpolate(binding, cubes, at_corners(cubes, motion.stress)));
    }
    if (which.plastic_strain && motion.plastic_strain.size() == cubes.count()) {
        put_attribute(mesh, "plastic_strain", "",
                      interpolate(binding, cubes, at_corners(cubes, motion.plastic_strain)));
    }
    if (which.component && cubes.component.size() == cubes.count()) {
        put_attribute(mesh, "component", "", components(binding, cubes));
    }
    for (const CubeAttribute& a : chosen_values(which.cubes, cubes)) {
        const std::vector<float> values(a.values.begin(), a.values.end());
        put_attribute(mesh, a.name, a.unit, interpolate(binding, cubes, at_corners(cubes, values)));
    }
}

}  // namespace geometry

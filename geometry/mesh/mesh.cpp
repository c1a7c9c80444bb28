#include "geometry/mesh/mesh.hpp"

#include "geometry/mesh/texture.hpp"

#include <tuple>

namespace geometry {
namespace {

bool same(const Texture* a, const Texture* b)
{
    if (a == b) return true;
    return a && b && a->source().name == b->source().name && a->source().file == b->source().file;
}

}  // namespace

bool Material::operator==(const Material& other) const
{
    const auto numbers = [](const Material& m) {
        return std::tie(m.name, m.colour, m.opacity, m.roughness, m.metallic, m.use, m.bump);
    };
    return numbers(*this) == numbers(other) && same(texture.get(), other.texture.get()) &&
           same(normal_map.get(), other.normal_map.get());
}

Box bounds(const TriMesh& mesh)
{
    Box box;
    for (const Vec3f& p : mesh.positions) box.add(p.cast<double>());
    return box;
}

}  // namespace geometry

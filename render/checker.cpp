#include "render/checker.hpp"

#include "geometry/mesh/texture.hpp"
#include "render/png.hpp"

#include <algorithm>
#include <array>

namespace render {
namespace {

using geometry::Triangle;
using geometry::Vec2f;

// Two by two squares, pale and dark.
std::shared_ptr<const geometry::Texture> checker_texture()
{
    static const std::shared_ptr<const geometry::Texture> texture = [] {
        constexpr int side = 128;  // pixels: edges are as sharp as a close view needs
        Image image{side, side, {}};
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                const bool dark = (x < side / 2) != (y < side / 2);
                const std::uint8_t grey = dark ? 96 : 232;
                image.rgba.insert(image.rgba.end(), {grey, grey, grey, 255});
            }
        }
        const std::vector<std::uint8_t> file = encode_png(image);
        return std::make_shared<const geometry::Texture>(
            geometry::Texture::Source{"checker.png", {file.begin(), file.end()}});
    }();
    return texture;
}

bool has_uvs(const geometry::MeshTopology& t)
{
    return !t.triangles.empty() && t.uv_triangles.size() == t.triangles.size() && !t.uvs.empty();
}

void lay_by_axes(geometry::MeshTopology& t, const TriMesh& rest, double square)
{
    t.uvs.clear();
    t.uv_triangles.clear();
    const auto per_metre = static_cast<float>(0.5 / square);
    for (const Triangle& f : t.triangles) {
        const bool there = std::all_of(f.begin(), f.end(),
                                       [&](std::uint32_t v) { return v < rest.positions.size(); });
        std::array<Vec3f, 3> p{Vec3f::Zero(), Vec3f::Zero(), Vec3f::Zero()};
        for (std::size_t k = 0; there && k < 3; ++k) p[k] = rest.positions[f[k]];
        const Vec3f normal = (p[1] - p[0]).cross(p[2] - p[0]).cwiseAbs();
        Eigen::Index most = 0;
        normal.maxCoeff(&most);
        const auto first = static_cast<std::uint32_t>(t.uvs.size());
        for (const Vec3f& at : p) {
            t.uvs.push_back(per_metre * Vec2f(at[(most + 1) % 3], at[(most + 2) % 3]));
        }
        t.uv_triangles.push_back({first, first + 1, first + 2});
    }
}

}  // namespace

std::shared_ptr<const geometry::MeshTopology> checkered(const TriMesh& mesh, const TriMesh& rest,
                                                        double per_unit, double square)
{
    auto t = std::make_shared<geometry::MeshTopology>(*mesh.topology);
    if (has_uvs(*t)) {
        for (Vec2f& uv : t->uvs) uv *= static_cast<float>(0.5 * per_unit);
    } else {
        lay_by_axes(*t, rest, square);
    }
    if (t->materials.empty()) t->materials.emplace_back();
    for (geometry::Material& m : t->materials) {
        m.colour = Vec3f::Ones();
        m.texture = checker_texture();
        m.use = {};
        m.normal_map = nullptr;
    }
    return t;
}

}  // namespace render

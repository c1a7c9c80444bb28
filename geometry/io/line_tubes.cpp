#include "geometry/io/line_tubes.hpp"

#include <cmath>
#include <numbers>

namespace geometry {
namespace {

constexpr std::uint32_t sides = 8;

Transform transform_of(const ImportedNode& node)
{
    Transform T = Transform::Identity();
    T.matrix().topRows<3>() =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(node.to_world.data());
    return T;
}

// A closed tube from a to b: two rings, and the middles of its caps.
void add_tube(ImportedMesh& mesh, const Vec3& a, const Vec3& b, double radius)
{
    const Vec3 along = (b - a).normalized();
    int least = 0;
    along.cwiseAbs().minCoeff(&least);
    const Vec3 u = along.cross(Vec3::Unit(least)).normalized(), v = along.cross(u);
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    for (const Vec3& end : {a, b}) {
        for (std::uint32_t i = 0; i < sides; ++i) {
            const double angle = 2 * std::numbers::pi * i / sides;
            const Vec3 p = end + radius * (std::cos(angle) * u + std::sin(angle) * v);
            mesh.positions.push_back(p.cast<float>());
        }
    }
    mesh.positions.push_back(a.cast<float>());
    mesh.positions.push_back(b.cast<float>());
    const std::uint32_t low = first + 2 * sides, high = low + 1;
    for (std::uint32_t i = 0; i < sides; ++i) {
        const std::uint32_t p = first + i, q = first + (i + 1) % sides;
        mesh.triangles.push_back({p, q, q + sides});
        mesh.triangles.push_back({p, q + sides, p + sides});
        mesh.triangles.push_back({low, q, p});
        mesh.triangles.push_back({high, p + sides, q + sides});
    }
}

}  // namespace

void add_line_tubes(ImportedScene& scene, double diameter)
{
    // The octagon of the circle's area.
    const double circle = std::numbers::pi * diameter * diameter / 4;
    const double radius =
        std::sqrt(circle / (0.5 * sides * std::sin(2 * std::numbers::pi / sides)));
    const std::size_t nodes = scene.nodes.size(), meshes = scene.meshes.size();
    std::vector<ImportedMesh> tubes;
    for (std::size_t n = 0; n < nodes; ++n) {
        const ImportedNode node = scene.nodes[n];
        if (node.mesh >= meshes || scene.meshes[node.mesh].segments.empty()) continue;
        const ImportedMesh& lines = scene.meshes[node.mesh];
        const Transform T = transform_of(node);
        ImportedMesh made;
        made.name = lines.name;
        made.material = lines.material;
        for (const auto& [i, j] : lines.segments) {
            if (i >= lines.positions.size() || j >= lines.positions.size()) continue;
            const Vec3 a = T * lines.positions[i].cast<double>(),
                       b = T * lines.positions[j].cast<double>();
            if (a.allFinite() && b.allFinite() && (b - a).norm() > 0) add_tube(made, a, b, radius);
        }
        const auto mesh = static_cast<std::uint32_t>(meshes + tubes.size());
        scene.nodes.push_back({node.name, mesh, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, node.node});
        tubes.push_back(std::move(made));
    }
    for (ImportedMesh& m : scene.meshes) {
        m.lines -= std::min<std::uint64_t>(m.lines, m.segments.size());
    }
    for (ImportedMesh& m : tubes) scene.meshes.push_back(std::move(m));
}

}  // namespace geometry

#include "geometry/mesh/wall_thickness.hpp"

#include "geometry/base/box_tree.hpp"
#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <cmath>

namespace geometry {
namespace {

struct Corners {
    Vec3 a, ab, ac;
    Vec3 normal() const { return ab.cross(ac); }
};

Corners corners_of(const TriMesh& mesh, std::uint32_t triangle)
{
    const Triangle& t = mesh.triangles()[triangle];
    const Vec3 a = mesh.positions[t[0]].cast<double>();
    return {a, mesh.positions[t[1]].cast<double>() - a, mesh.positions[t[2]].cast<double>() - a};
}

// Whether the ray from `start` reaches the box before `far`.
bool meets(const Box3f& box, const Vec3& start, const Vec3& inverse, double far)
{
    const Eigen::Array3d lo = (box.lo.cast<double>() - start).array() * inverse.array(),
                         hi = (box.hi.cast<double>() - start).array() * inverse.array();
    return std::max(lo.min(hi).maxCoeff(), 0.0) <= std::min(lo.max(hi).minCoeff(), far);
}

// The walls of one mesh, whose triangles `kept` are in the tree.
struct Walls {
    const TriMesh& mesh;
    const Pieces& pieces;
    double least = 0, reach = 0;  // m
    std::vector<std::uint32_t> kept;
    BoxTree tree;

    double sign(std::uint32_t triangle) const
    {
        const std::uint32_t p = pieces.of[triangle];
        return pieces.encloses[p] != 0 && pieces.volume[p] < 0 ? -1 : 1;
    }
    double exit(const WallSample& sample) const;
    void leaf(const BoxTree::Node& node, const WallSample& sample, double& nearest) const;
};

// Where the ray leaves through a triangle of a leaf, if nearer.
void Walls::leaf(const BoxTree::Node& node, const WallSample& sample, double& nearest) const
{
    for (std::uint32_t i = 0; i < node.count; ++i) {
        const std::uint32_t triangle = kept[tree.items[node.first + i]];
        if (triangle == sample.triangle) continue;
        const Corners c = corners_of(mesh, triangle);
        const double along = sign(triangle) * c.normal().dot(sample.inward);
        if (!(along > 0)) continue;  // goes in there, or runs along it
        // Moeller, Trumbore. Fast, minimum storage ray/triangle intersection. JGT 2(1), 1997.
        const Vec3 p = sample.inward.cross(c.ac), start = sample.point - c.a, q = start.cross(c.ab);
        const double scale = 1 / c.ab.dot(p), u = scale * start.dot(p),
                     v = scale * q.dot(sample.inward), t = scale * q.dot(c.ac);
        constexpr double rim = 1e-9;  // a ray through an edge misses neither triangle
        if (u < -rim || v < -rim || u + v > 1 + rim || !(t > least)) continue;
        nearest = std::min(nearest, t);
    }
}

// The way inward to the opposite wall; infinite beyond the reach.
double Walls::exit(const WallSample& sample) const
{
    double nearest = std::numeric_limits<double>::infinity();
    if (tree.nodes.empty()) return nearest;
    const Vec3 inverse = sample.inward.cwiseInverse();
    std::array<std::uint32_t, BoxTree::max_depth + 1> stack;
    std::size_t waiting = 1;
    stack[0] = 0;
    while (waiting > 0) {
        const BoxTree::Node& node = tree.nodes[stack[--waiting]];
        if (!meets(node.box, sample.point, inverse, std::min(nearest, reach))) continue;
        if (node.count > 0) {
            leaf(node, sample, nearest);
            continue;
        }
        stack[waiting++] = node.first + 1;
        stack[waiting++] = node.first;
    }
    return nearest <= reach ? nearest : std::numeric_limits<double>::infinity();
}

}  // namespace

std::vector<WallSample> wall_points(const TriMesh& mesh, std::size_t count)
{
    const std::size_t faces = mesh.triangles().size();
    std::vector<double> passed(faces, 0.0);  // m^2, the area of all triangles up to each
    double area = 0;
    for (std::uint32_t t = 0; t < faces; ++t) {
        if (is_finite(mesh, mesh.triangles()[t])) area += 0.5 * corners_of(mesh, t).normal().norm();
        passed[t] = area;
    }
    std::vector<WallSample> samples;
    if (!(area > 0) || !std::isfinite(area)) return samples;
    samples.reserve(count);
    const Random random(0x7a11);
    auto at = passed.begin();
    for (std::uint64_t n = 0; n < count; ++n) {
        const double due =
            area * (static_cast<double>(n) + random.unit(3 * n)) / static_cast<double>(count);
        at = std::upper_bound(at, passed.end(), due);
        if (at == passed.end()) break;
        WallSample sample;
        sample.triangle = static_cast<std::uint32_t>(at - passed.begin());
        const Corners c = corners_of(mesh, sample.triangle);
        double u = random.unit(3 * n + 1), v = random.unit(3 * n + 2);
        if (u + v > 1) u = 1 - u, v = 1 - v;
        sample.point = c.a + u * c.ab + v * c.ac;
        sample.inward = -c.normal().normalized();
        samples.push_back(sample);
    }
    return samples;
}

void find_thickness(const TriMesh& mesh, const Pieces& pieces, double least, double reach,
                    std::vector<WallSample>& samples)
{
    Walls walls{mesh, pieces, least, reach, {}, {}};
    std::vector<Box3f> boxes;
    boxes.reserve(mesh.triangles().size());
    for (std::uint32_t t = 0; t < mesh.triangles().size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        Box3f box;
        for (const std::uint32_t v : mesh.triangles()[t]) box.add(mesh.positions[v]);
        boxes.push_back(box);
        walls.kept.push_back(t);
    }
    walls.tree = build_box_tree(boxes, 16);
    parallel_for(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            samples[i].inward *= walls.sign(samples[i].triangle);
            samples[i].thickness = walls.exit(samples[i]);
        }
    });
}

}  // namespace geometry

#include "physics/layered_bodies/own_core.hpp"

#include "geometry/fields/round_skeleton.hpp"
#include "geometry/fields/skeleton_mesh.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>

namespace physics {
namespace {

using geometry::Box;

double contribution_at(const Field& field, std::uint32_t s, const Vec3& p)
{
    return geometry::profile_at(field.profile[s], geometry::distance(field, s, p)).f;
}

Box box_of_core(const Field& field, std::uint32_t s)
{
    if (field.mesh[s]) return geometry::bounds(field.mesh[s]->mesh);
    const Vec3 half = geometry::half_extent(field.kind[s], field.half_size[s]);
    Box box;
    box.add(-half);
    box.add(half);
    return box;
}

}  // namespace

OwnCore own_core(const Field& field, std::uint32_t s)
{
    OwnCore out;
    if (!geometry::is_solid(field.kind[s]) || field.kind[s] == geometry::SkeletonKind::plane)
        return out;
    const Box core = box_of_core(field, s);
    Box around;
    for (int corner = 0; corner < 8; ++corner) {
        const auto side = [&](int axis) {
            return (corner >> axis & 1) != 0 ? core.hi[axis] : core.lo[axis];
        };
        around.add(field.place[s] * Vec3(side(0), side(1), side(2)));
    }
    std::vector<std::uint32_t> others;
    geometry::candidates(field, around, others);
    std::erase_if(others, [&](std::uint32_t j) {
        return j == s || field.kind[j] == geometry::SkeletonKind::plane;
    });
    if (others.empty()) return out;
    constexpr int n = 24;  // grid points along each side of the core's box
    const Vec3 cell = core.size() / n;
    for (int i = 0; i < n * n * n; ++i) {
        const Vec3 number(i % n, i / n % n, i / (n * n));
        const Vec3 p =
            field.place[s] * Vec3(core.lo + cell.cwiseProduct(number + Vec3::Constant(0.5)));
        if (!(geometry::distance(field, s, p) < 0)) continue;
        ++out.count;
        const double own = contribution_at(field, s, p);
        const bool taken = std::any_of(others.begin(), others.end(), [&](std::uint32_t j) {
            const double theirs = contribution_at(field, j, p);
            return theirs > own || (theirs == own && j < s);
        });
        if (!taken) out.points.push_back(p);
    }
    return out;
}

}  // namespace physics

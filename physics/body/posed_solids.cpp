#include "physics/body/posed_solids.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/trilinear.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/solids_beside_sheets.hpp"

namespace physics {
namespace {

using geometry::Box;
using geometry::TriMesh;

Vec3 place_of(const CarriedPlace& carried, const double* x)
{
    Vec3 out = Vec3::Zero();
    for (std::size_t a = 0; a < 8; ++a) {
        out += carried.weight[a] * Eigen::Map<const Vec3>(x + 4 * std::size_t{carried.corners[a]});
    }
    return out;
}

void move(const SolidsBesideSheets& solids, const SolidShape& shape, const double* x, TriMesh& out)
{
    out.topology = shape.mesh.topology;
    out.positions.resize(shape.mesh.positions.size());
    geometry::parallel_for(out.positions.size(), 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const CarriedPlace carried{solids.corners[shape.cube[v]],
                                       geometry::trilinear_weights(shape.local[v])};
            out.positions[v] = place_of(carried, x).cast<float>();
        }
    });
}

// Around all corners of sheets.
void add_sheets(const CornerBody& body, const double* x, Box& out)
{
    for (std::size_t k = body.solids->first_sheet; k < body.corners; ++k) {
        out.add(Eigen::Map<const Vec3>(x + 4 * k));
    }
}

bool are_near(const Box& a, const Box& b, double reach)
{
    return ((a.lo.array() - reach) <= b.hi.array()).all() &&
           ((b.lo.array() - reach) <= a.hi.array()).all();
}

}  // namespace

void pose_solids(const CornerBody& body, const double* before, const double* x, double dt,
                 PosedSolids& room, std::vector<PosedCollider>& colliders)
{
    const SolidsBesideSheets& solids = *body.solids;
    for (auto* const meshes : {&room.before, &room.now}) {
        while (meshes->size() < solids.solid.size()) {
            meshes->push_back(std::make_shared<TriMesh>());
        }
    }
    Box sheets;
    add_sheets(body, x, sheets);
    if (before) add_sheets(body, before, sheets);
    for (std::size_t i = 0; i < solids.solid.size(); ++i) {
        TriMesh &was = *room.before[i], &is = *room.now[i];
        PosedCollider& out = colliders.emplace_back();
        out.kind = Collider::Kind::mesh;
        out.thickness = body.skin.thickest;
        out.friction = solids.friction, out.bounce = solids.bounce;
        out.frame = dt;
        out.pose = out.inverse = geometry::Transform::Identity();
        out.reach = 2 * body.greatest_edge;
        move(solids, solids.solid[i], x, is);
        Box around = geometry::bounds(is);
        if (before) {
            move(solids, solids.solid[i], before, was);
            around.add(geometry::bounds(was));
        }
        if (!are_near(around, sheets, out.reach + out.thickness)) continue;
        out.mesh_bounds = around;
        out.mesh = &is;
        out.tree = std::make_shared<const geometry::TriangleBvh>(is);
        if (!before) continue;
        out.mesh_before = &was;
        for (std::size_t v = 0; v < is.positions.size(); ++v) {
            const auto way = is.positions[v] - was.positions[v];
            out.longest = std::max(out.longest, double(way.norm()));
        }
    }
}

void join_solids(const CornerBody& body, const double* x,
                 const std::vector<PosedCollider>& colliders, std::vector<PlaneTouch>& touches)
{
    const SolidsBesideSheets& solids = *body.solids;
    const std::size_t first = colliders.size() - solids.solid.size();
    const auto join = [&](PlaneTouch& touch) {
        const std::size_t solid = touch.other - first;
        const double gap = touch.gap(x);
        Vec3 p = Vec3::Zero();
        for (std::size_t a = 0; a < 8; ++a) {
            p += double(touch.weight[a]) *
                 Eigen::Map<const Vec3>(x + 4 * std::size_t{touch.corners[a]});
        }
        const auto hit = colliders[touch.other].tree->closest(p - gap * touch.normal);
        if (!hit) return;
        const TriMesh& rest = solids.solid[solid].mesh;
        Vec3 at_rest = Vec3::Zero();
        for (std::size_t i = 0; i < 3; ++i) {
            const auto v = rest.triangles()[hit.triangle][i];
            at_rest +=
                hit.barycentric[static_cast<Eigen::Index>(i)] * rest.positions[v].cast<double>();
        }
        const CarriedPlace carried = carried_place(solids, solid, at_rest);
        touch.count = 16;
        for (std::size_t a = 0; a < 8; ++a) {
            touch.corners[8 + a] = carried.corners[a];
            touch.weight[8 + a] = -static_cast<float>(carried.weight[a]);
        }
        touch.drift = Vec3::Zero();
        touch.offset += gap - touch.gap(x);
    };
    geometry::parallel_for(touches.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (touches[i].other >= first && touches[i].count == 8) join(touches[i]);
        }
    });
}

void forget_tangles(const CornerBody& body, std::size_t colliders, std::vector<Grip>& grips)
{
    const SolidsBesideSheets& solids = *body.solids;
    const auto& first_point = body.skin.first_point;
    const std::size_t first = colliders - solids.solid.size();
    const auto solid_of = [&](const Grip& grip) -> std::size_t {
        if (grip.other < colliders) return grip.other - first;
        const auto next = std::upper_bound(first_point.begin(), first_point.end(), grip.point);
        const auto cube = static_cast<std::size_t>(next - first_point.begin()) - 1;
        return body.part_of(body.skin.corners[cube][0]);
    };
    std::erase_if(grips, [&](const Grip& grip) {
        if (grip.other < first) return false;
        return double(grip.depth) > 0.25 * solids.solid[solid_of(grip)].thinnest;
    });
}

}  // namespace physics

#include "physics/layers/layer_stops.hpp"

#include "geometry/fields/evaluate_block.hpp"
#include "physics/layers/velocity_at.hpp"

namespace physics {

using geometry::BlockValues;
using geometry::FieldBlock;
using geometry::FieldScratch;

void add_stop(const LayerStop& stop, std::vector<LayerStop>& stops)
{
    for (auto known = stops.rbegin(); known != stops.rend(); ++known) {
        if (known->body != stop.body || known->skeleton != stop.skeleton) break;
        if (known->other != stop.other) continue;
        if (stop.gap < known->gap) *known = stop;
        return;
    }
    stops.push_back(stop);
}

LayerStop stop_at_rigid(const Field& field, const Party& other, const Vec3& p)
{
    LayerStop stop;
    for (const std::uint32_t s : other.skeletons) {
        const geometry::Foot foot = geometry::foot(field, s, p);
        const double gap = geometry::surface_gap(field, s, foot);
        if (gap < stop.gap && foot.n.squaredNorm() > 0) {
            stop.other_skeleton = s;
            stop.normal = geometry::stretch_of(field, s) ? foot.n.normalized() : foot.n;
            stop.gap = gap;
        }
    }
    return stop;
}

void tell_parties(const Meeting& meeting, std::uint32_t skeleton, const Party& other, const Vec3& p,
                  LayerStop& stop)
{
    stop.body = meeting.own.body;
    stop.skeleton = skeleton;
    stop.other = other.body;
    stop.position = p;
    if (const MovingMesh* mesh = meeting.bodies[other.body].moving) {
        stop.closing = velocity_at(*mesh, p).dot(stop.normal);
    }
}

void find_stops(const Meeting& meeting, std::uint32_t skeleton, const std::vector<Vec3>& origins,
                std::vector<LayerStop>& stops)
{
    thread_local FieldScratch scratch;
    thread_local FieldBlock block;
    thread_local BlockValues own, theirs;
    block.count = 0;
    for (const Vec3& origin : origins) {
        if (block.count == 0 || origin != block.point(block.count - 1)) block.add(origin);
    }
    block.pad();
    geometry::evaluate(meeting.field(meeting.own), meeting.own.skeletons, block, scratch, own);
    for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
        const Party& other = meeting.others[o];
        const Field& field = meeting.field(other);
        const bool rigid = meeting.bodies[other.body].matter.rigid;
        geometry::evaluate(field, other.skeletons, block, scratch, theirs);
        for (std::size_t k = 0; k < block.count; ++k) {
            const Vec3 p = block.point(k), gradient = theirs.gradient(k);
            const double slope = gradient.norm(), c = field.isovalue;
            LayerStop stop;
            if (rigid) {
                stop = stop_at_rigid(field, other, p);
                // Several skeletons that blend hold more than each alone.
                if (theirs.f[k] > c && slope > 0 && (c - theirs.f[k]) / slope < stop.gap) {
                    stop.gap = (c - theirs.f[k]) / slope;
                    stop.normal = -gradient / slope;
                }
                const double thickness =
                    geometry::thickness_along(meeting.field(meeting.own), skeleton, stop.normal);
                if (!(stop.gap < thickness)) continue;
            } else {
                if (!(theirs.f[k] > c && slope > 0)) continue;
                stop.other_skeleton = largest_at(field, other.skeletons, p);
                stop.normal = -gradient / slope;
                stop.gap = (own.f[k] - theirs.f[k]) / slope;
            }
            tell_parties(meeting, skeleton, other, p, stop);
            add_stop(stop, stops);
        }
    }
}

}  // namespace physics

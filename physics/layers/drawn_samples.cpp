#include "physics/layers/drawn_samples.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/layers/deformed_layer.hpp"
#include "physics/layers/ray_search.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::FieldBlock;

// Up to a block of samples of one skeleton.
struct DrawnBatch {
    std::uint32_t body, skeleton, begin, end;
    const Bulges* bulges;
};

// The valid samples of a batch. Returns a box around all that their rays may reach.
Box start_rays(const ContactBody& own, const DrawnBatch& batch, std::vector<SearchRay>& rays)
{
    const SurfaceSamples& samples = *own.samples;
    const Transform& frame = own.frames[samples.frame[batch.skeleton]];
    const double reach = own.field->profile[batch.skeleton].R;
    rays.clear();
    Box box;
    for (std::uint32_t i = batch.begin; i < batch.end; ++i) {
        if (!own.walk->valid[i]) continue;
        const double d = own.walk->distance[i];
        const Vec3 direction = frame.linear() * samples.direction[i];
        const double width = geometry::width_along(*own.field, batch.skeleton, direction);
        rays.push_back({i, frame * samples.origin[i], direction, d, 0, std::max(d, reach * width)});
        box.add(rays.back().origin);
        box.add(rays.back().origin + rays.back().outside * rays.back().direction);
    }
    return box;
}

// Back to the border of the skeleton's territory, where the ray has gone beyond it.
void keep_at_home(const Meeting& meeting, const DrawnBatch& batch, SearchRay& ray)
{
    const Field& field = meeting.field(meeting.own);
    const auto at_home = [&](double t) {
        return largest_at(field, meeting.own.skeletons, ray.origin + t * ray.direction) ==
               batch.skeleton;
    };
    if (at_home(ray.t)) return;
    double home = meeting.bodies[batch.body].walk->distance[ray.sample], abroad = ray.t;
    for (int i = 0; i < 50; ++i) {
        const double middle = 0.5 * (home + abroad);
        (at_home(middle) ? home : abroad) = middle;
    }
    ray.t = home;
}

void add_drawn(const Meeting& meeting, const DrawnBatch& batch, SearchRay ray, const Vec3& gradient,
               std::vector<DrawnSample>& found)
{
    const double slope = gradient.norm();
    const double cosine = slope > 0 ? -ray.direction.dot(gradient) / slope : 0;
    if (!(cosine > 1e-6)) return;
    keep_at_home(meeting, batch, ray);
    found.push_back({batch.body, ray.sample, batch.skeleton, ray.point(), -gradient / slope,
                     meeting.bodies[batch.body].samples->crossed(ray.sample, ray.t) / cosine,
                     ray.t});
}

// Whether skeletons are near that this one does not blend with.
bool near_parts(const Field& field, std::uint32_t skeleton, std::span<const std::uint32_t> near)
{
    return field.rule != geometry::BlendRule::sum &&
           std::any_of(near.begin(), near.end(),
                       [&](std::uint32_t k) { return !(field.weights(skeleton, k) > 0); });
}

bool near_bulges(const Meeting& meeting, const Bulges& bulges)
{
    return std::any_of(meeting.others.begin(),
                       meeting.others.begin() + static_cast<std::ptrdiff_t>(meeting.other_count),
                       [&](const Party& other) { return bulges.against(other.body) > 0; });
}

void go_to_surface(std::span<const ContactBody> bodies, const DrawnBatch& batch,
                   std::vector<DrawnSample>& found)
{
    thread_local Meeting meeting;
    thread_local FieldBlock block;
    thread_local DeformedValues at;
    thread_local std::vector<SearchRay> rays;
    const ContactBody& own = bodies[batch.body];
    const double c = own.field->isovalue;
    const double tolerance = 1e-13 * own.field->profile[batch.skeleton].R;
    const Box box = start_rays(own, batch, rays);
    if (rays.empty()) return;
    const double reach = batch.bulges->highest() > 0 ? batch.bulges->width : 0;
    gather(bodies, batch.body, geometry::no_skeleton, box, meeting, reach);
    add_own_parts(meeting, batch.skeleton, box, reach);
    if (!near_parts(*own.field, batch.skeleton, meeting.own.skeletons) &&
        !near_bulges(meeting, *batch.bulges)) {
        return;
    }
    for (int round = 0; round < 100 && !rays.empty(); ++round) {
        block.count = 0;
        for (const SearchRay& ray : rays) block.add(ray.point());
        block.pad();
        evaluate(meeting, *batch.bulges, block, at);
        std::size_t left = 0;
        for (std::size_t k = 0; k < rays.size(); ++k) {
            SearchRay ray = rays[k];
            if (round == 0 &&
                (std::max(at.m[k], at.q[k]) > c || std::abs(at.D.f[k] - c) < 1e-9 * c)) {
                continue;
            }
            if (step(ray, at.D.f[k] - c, ray.direction.dot(at.D.gradient(k)), tolerance)) {
                rays[left++] = ray;
            } else {
                add_drawn(meeting, batch, ray, at.D.gradient(k), found);
            }
        }
        rays.resize(left);
    }
}

}  // namespace

void find_drawn(std::span<const ContactBody> bodies, Contacts& contacts)
{
    std::vector<Bulges> bulges;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        bulges.push_back(bodies[b].drawn ? bulges_of(bodies, b, contacts.contacts) : Bulges{});
    }
    std::vector<DrawnBatch> batches;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        if (!bodies[b].drawn || !bodies[b].samples || bodies[b].matter.rigid) continue;
        if (!(bulges[b].highest() > 0) && bodies[b].field->rule == geometry::BlendRule::sum)
            continue;
        const SurfaceSamples& samples = *bodies[b].samples;
        constexpr auto most = static_cast<std::uint32_t>(FieldBlock::capacity);
        for (std::uint32_t s = 0; s < samples.skeletons(); ++s) {
            for (std::uint32_t i = samples.first[s]; i < samples.first[s + 1]; i += most) {
                batches.push_back({b, s, i, std::min(i + most, samples.first[s + 1]), &bulges[b]});
            }
        }
    }
    std::vector<std::vector<DrawnSample>> found(batches.size());
    geometry::parallel_for(batches.size(), 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t b = begin; b < end; ++b) go_to_surface(bodies, batches[b], found[b]);
    });
    for (std::vector<DrawnSample>& some : found) {
        // Rays stop in the order they converge.
        std::sort(some.begin(), some.end(),
                  [](const DrawnSample& a, const DrawnSample& b) { return a.sample < b.sample; });
        contacts.drawn.insert(contacts.drawn.end(), some.begin(), some.end());
    }
}

}  // namespace physics

#include "physics/layers/rigid_stops.hpp"

#include "physics/layers/layer_stops.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

constexpr std::size_t most_stops = 8;

// Samples of one skeleton near another body, and what is left of them to choose from.
using Candidates = std::vector<LayerStop>;

// The nearest, then the one farthest from all that are taken, and so on; what is left of the gap
// counts against a sample.
void choose(const Candidates& near, double margin, std::vector<LayerStop>& stops)
{
    const auto nearest =
        std::min_element(near.begin(), near.end(),
                         [](const LayerStop& a, const LayerStop& b) { return a.gap < b.gap; });
    std::vector<double> apart_sq(near.size(), std::numeric_limits<double>::infinity());
    auto next = static_cast<std::size_t>(nearest - near.begin());
    for (std::size_t taken = 0; taken < most_stops && apart_sq[next] > 0; ++taken) {
        stops.push_back(near[next]);
        double best = -1;
        std::size_t chosen = next;
        for (std::size_t i = 0; i < near.size(); ++i) {
            apart_sq[i] =
                std::min(apart_sq[i], (near[i].position - stops.back().position).squaredNorm());
            const double left = (near[i].gap - nearest->gap) / (margin - nearest->gap);
            const double worth = apart_sq[i] * std::pow(1 - left, 8);
            if (worth > best) {
                best = worth;
                chosen = i;
            }
        }
        next = chosen;
    }
}

// The samples of a skeleton against one other body.
void touch(const Meeting& meeting, std::uint32_t skeleton, const Party& other,
           std::vector<LayerStop>& stops, double& penetration)
{
    thread_local Candidates near;
    const ContactBody& own = meeting.bodies[meeting.own.body];
    const double margin = 0.5 * own.field->profile[skeleton].e;
    near.clear();
    double area = 0;
    for (std::uint32_t i = own.samples->first[skeleton]; i < own.samples->first[skeleton + 1];
         ++i) {
        if (!own.walk->valid[i]) continue;
        const Vec3& p = own.walk->position[i];
        LayerStop stop = stop_at_rigid(meeting.field(other), other, p);
        if (!(stop.gap < margin)) continue;
        tell_parties(meeting, skeleton, other, p, stop);
        if (stop.gap < 0.04 * margin) area += own.walk->area[i];
        penetration = std::max(penetration, -stop.gap);
        near.push_back(stop);
    }
    if (near.empty()) return;
    const std::size_t first = stops.size();
    choose(near, margin, stops);
    const auto touching = static_cast<double>(
        std::count_if(stops.begin() + static_cast<std::ptrdiff_t>(first), stops.end(),
                      [&](const LayerStop& stop) { return stop.gap < 0.04 * margin; }));
    for (std::size_t s = first; s < stops.size(); ++s) {
        if (stops[s].gap < 0.04 * margin) stops[s].area = area / touching;
    }
}

}  // namespace

void find_rigid_stops(std::span<const ContactBody> bodies, std::vector<LayerStop>& stops,
                      std::vector<double>& penetration)
{
    Meeting meeting;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        const ContactBody& own = bodies[b];
        if (!own.matter.rigid || !own.samples) continue;
        for (std::uint32_t s = 0; s < own.samples->skeletons(); ++s) {
            Box box;
            for (std::uint32_t i = own.samples->first[s]; i < own.samples->first[s + 1]; ++i) {
                box.add(own.walk->position[i]);
            }
            if (box.empty()) continue;
            gather(bodies, b, geometry::no_skeleton, box, meeting, own.field->profile[s].e);
            for (std::uint32_t o = 0; o < meeting.other_count; ++o) {
                const Party& other = meeting.others[o];
                if (!bodies[other.body].matter.rigid) continue;
                touch(meeting, s, other, stops, penetration[b]);
            }
        }
    }
}

}  // namespace physics

#include "physics/layered_bodies/substance_parts.hpp"

#include "geometry/base/union_find.hpp"

#include <algorithm>
#include <set>

namespace physics {

using geometry::BlendLink;

std::size_t particle_count(const LayeredScene& scene)
{
    std::size_t count = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        if (scene.parts[b].body->base.kind != BaseKind::particles) continue;
        for (const Vec3& p : scene.states[b].position) count += p.allFinite();
    }
    return count;
}

// What chains of skeletons that are in reach of each other hold together.
static geometry::Sets chains(std::uint32_t count, const auto& in_reach)
{
    geometry::Sets sets(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        for (std::uint32_t j = i + 1; j < count; ++j) {
            if (in_reach(i, j)) sets.join(i, j);
        }
    }
    return sets;
}

// Whether the influences of i and j meet whose centres are `way` apart; reach(i, direction): of i.
static bool overlap(std::uint32_t i, std::uint32_t j, const Vec3& way, const auto& reach)
{
    const double apart = way.norm();
    return !(apart > 0) || apart < reach(i, way / apart) + reach(j, way / apart);
}

// To which piece of a soft substance each skeleton belongs.
static std::vector<std::uint32_t> pieces_of(const LayeredBody& body, const LayeredState& state)
{
    if (!state.part.empty()) return state.part;
    const ImplicitLayer& layer = body.layer;  // all blend that are in reach
    const auto reach = [&](std::uint32_t i, const Vec3& along) {
        const geometry::Skeleton& skeleton = layer.skeletons[i];
        if (!skeleton.stretches()) return layer.contributions[i].radius;
        const Eigen::Quaterniond turn(state.rotation[layer.frame[i]]);
        return layer.contributions[i].radius *
               geometry::stretch_of(skeleton, turn.toRotationMatrix()).along(along);
    };
    return chains(static_cast<std::uint32_t>(layer.skeletons.size()),
                  [&](std::uint32_t i, std::uint32_t j) {
                      return overlap(
                          i, j, state.position[layer.frame[i]] - state.position[layer.frame[j]],
                          reach);
                  })
        .roots();
}

std::size_t piece_count(const LayeredScene& scene)
{
    std::size_t count = 0;
    for (std::size_t b = 0; b < scene.parts.size(); ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        if (body.base.kind != BaseKind::particles) continue;
        const std::vector<std::uint32_t> piece = pieces_of(body, scene.states[b]);
        count += std::set(piece.begin(), piece.end()).size();
    }
    return count;
}

namespace {

bool in_reach(const Field& field, std::uint32_t i, std::uint32_t j)
{
    const auto centre = [&](std::uint32_t s) { return field.points[field.first[s]]; };
    return overlap(i, j, centre(i) - centre(j), [&](std::uint32_t s, const Vec3& along) {
        return field.profile[s].R * geometry::width_along(field, s, along);
    });
}

// What holds the skeletons of a substance together at a moment.
struct Bonds {
    const Field& field;
    const Substance& substance;
    const std::vector<BlendLink>& drawn;  // links of the body's design
    geometry::Sets sets;                  // parts
    std::vector<BlendLink> links;         // a < b, between parts, as far as those blend

    // Whether nothing has made a link of the design grow: it stays as it is.
    bool as_drawn(const BlendLink& link) const
    {
        return std::any_of(drawn.begin(), drawn.end(), [&](const BlendLink& d) {
            return std::minmax(d.a, d.b) == std::minmax(link.a, link.b) && d.weight == link.weight;
        });
    }
};

BlendLink grown(BlendLink link, double by, const Substance& substance)
{
    link.weight = substance.fusion_time > 0 ? std::min(1.0, link.weight + by) : 1;
    return link;
}

// Fusion begins.
void add_link(std::uint32_t i, std::uint32_t j, Bonds& bonds)
{
    if (i > j) std::swap(i, j);
    if (bonds.sets.root(i) == bonds.sets.root(j)) return;
    constexpr double little = 1e-3;
    for (BlendLink& link : bonds.links) {
        if (link.a != i || link.b != j) continue;
        if (bonds.as_drawn(link)) link = grown(link, little, bonds.substance);
        return;
    }
    bonds.links.push_back(grown({i, j, 0}, little, bonds.substance));
}

// Around a pair that blends fully the others in reach follow; parts of which all do become one.
void spread_link(const BlendLink& full, Bonds& bonds)
{
    const auto n = static_cast<std::uint32_t>(bonds.field.count());
    const std::uint32_t A = bonds.sets.root(full.a), B = bonds.sets.root(full.b);
    if (A == B) return;
    bool whole = true;
    for (std::uint32_t i = 0; i < n; ++i) {
        if (bonds.sets.root(i) != A) continue;
        for (std::uint32_t j = 0; j < n; ++j) {
            if (bonds.sets.root(j) != B || !in_reach(bonds.field, i, j)) continue;
            add_link(i, j, bonds);
            const auto linked =
                std::find_if(bonds.links.begin(), bonds.links.end(), [&](const BlendLink& l) {
                    return l.a == std::min(i, j) && l.b == std::max(i, j);
                });
            whole &= linked != bonds.links.end() && linked->weight >= 1;
        }
    }
    if (whole) bonds.sets.join(A, B);
}

}  // namespace

void update_parts(const LayeredBody& body, std::uint32_t number, const LayeredMoment& moment,
                  double dt, LayeredState& state)
{
    const Field& field = moment.fields[number];
    const Substance& substance = body.base.substance;
    const auto n = static_cast<std::uint32_t>(field.count());

    // Separation. Springs hold together what they join.
    Bonds bonds{field,
                substance,
                body.layer.blend.links,
                chains(n,
                       [&](std::uint32_t i, std::uint32_t j) {
                           return state.part[i] == state.part[j] && in_reach(field, i, j);
                       }),
                {}};

    if (substance.separates && !body.base.springs.empty()) {
        const auto on_frame = skeletons_on_frames(body);
        for (const LayerSpring& spring : body.base.springs) {
            for (const std::uint32_t i : on_frame[spring.a]) {
                for (const std::uint32_t j : on_frame[spring.b]) {
                    if (state.part[i] == state.part[j]) bonds.sets.join(i, j);
                }
            }
        }
    }

    // Fusion: links that still matter, grown; new ones where it presses hard enough.
    for (BlendLink link : state.links) {
        if (!in_reach(field, link.a, link.b)) continue;
        if (link.a > link.b) std::swap(link.a, link.b);
        bonds.links.push_back(
            bonds.as_drawn(link) ? link : grown(link, dt / substance.fusion_time, substance));
    }
    for (const LayerContact& contact : moment.contacts.contacts) {
        if (contact.body == number && contact.other == number &&
            body.matter.stiffness * contact.compression > substance.fusion_threshold) {
            add_link(contact.skeleton, contact.other_skeleton, bonds);
        }
    }
    const std::vector<BlendLink> begun = bonds.links;
    std::set<std::pair<std::uint32_t, std::uint32_t>> spread;  // parts: a join makes others of them
    for (const BlendLink& link : begun) {
        const auto parts = std::minmax({bonds.sets.root(link.a), bonds.sets.root(link.b)});
        if (link.weight >= 1 && !bonds.as_drawn(link) && spread.insert(parts).second)
            spread_link(link, bonds);
    }
    for (std::uint32_t i = 0; i < n; ++i) state.part[i] = bonds.sets.root(i);
    std::erase_if(bonds.links,
                  [&](const BlendLink& l) { return state.part[l.a] == state.part[l.b]; });
    state.links = std::move(bonds.links);
}

}  // namespace physics

#include "physics/contact_rim.hpp"

#include "geometry/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

constexpr std::uint32_t nobody = 0xffffffff;

// One body's seeds, and which of them are in contact.
struct Rims {
    std::span<const ContactBody> bodies;
    const ContactBody& body;
    std::span<const LayerContact> contacts;  // of all bodies
    std::vector<std::uint32_t> contact;      // N, into contacts, or nobody
};

// A seed seen from a face at the rim.
struct Corner {
    bool known = false, in = false;
    double w = 0, v = 0;
};

// What a seed's share of each face would be, tripled.
double share(const Rims& rims, std::uint32_t seed, double area)
{
    return 3 * area / rims.body.seeds->valence[seed];
}

// Outside: f_i and f_j go on along the ray as they are at the seed, until the common surface.
Corner beyond(const Rims& rims, std::uint32_t seed, std::uint32_t skeleton, std::uint32_t other)
{
    const SeedWalk& walk = *rims.body.walk;
    const Seeds& seeds = *rims.body.seeds;
    if (!walk.valid[seed]) return {};
    const ContactBody& them = rims.bodies[other];
    const Transform& frame = rims.body.frames[seeds.frame[skeleton]];
    const Vec3 ray = frame.linear() * seeds.direction[seed];
    const geometry::FieldValue there = geometry::value_at(*them.field, walk.position[seed]);
    const bool rigid = them.matter.rigid;
    const Vec3 leaves = rigid ? Vec3(-there.gradient) : Vec3(walk.gradient[seed] - there.gradient);
    const double slope = -ray.dot(leaves), steepest = leaves.norm();
    if (!(slope > 1e-3 * steepest)) return {};  // the ray runs along the surface
    const double way = (rims.body.field->isovalue - there.f) / slope;
    const double d = walk.distance[seed] + way;
    const double across = seeds.a0[seed] + d * (seeds.a1[seed] + d * seeds.a2[seed]);
    Corner corner{.known = true, .in = false};
    corner.w = share(rims, seed, across * steepest / slope);
    corner.v = corner.w * std::min(0.0, ray.dot(walk.gradient[seed]) * way);
    return corner;
}

Corner corner_at(const Rims& rims, std::uint32_t seed, std::uint32_t skeleton, std::uint32_t other)
{
    if (seed == no_seed) return {};
    const std::uint32_t c = rims.contact[seed];
    if (c == nobody) return beyond(rims, seed, skeleton, other);
    const LayerContact& contact = rims.contacts[c];
    if (contact.other != other) return {};
    const double w = share(rims, seed, contact.area);
    return {true, true, w, w * contact.compression};
}

// What a contact gets or loses.
struct Change {
    std::uint32_t contact;
    double load, area;
};

void weigh_face(const Rims& rims, std::size_t f, std::vector<Change>& changes)
{
    const geometry::Triangle& face = rims.body.seeds->faces[f];
    const LayerContact* first = nullptr;
    int inside = 0;
    for (const std::uint32_t seed : face) {
        if (rims.contact[seed] == nobody) continue;
        ++inside;
        if (!first) first = &rims.contacts[rims.contact[seed]];
    }
    if (inside == 0 || inside == 3) return;
    std::array<Corner, 3> at, past;  // its corners, and those across the opposite edges
    for (std::size_t k = 0; k < 3; ++k) {
        at[k] = corner_at(rims, face[k], first->skeleton, first->other);
        if (!at[k].known) return;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        past[k] = corner_at(rims, rims.body.seeds->across[f][k], first->skeleton, first->other);
        if (!past[k].known) return;
    }
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        least = std::min({least, at[k].w, past[k].w});
        most = std::max({most, at[k].w, past[k].w});
    }
    if (!(most < 4 * least)) return;  // no lattice: rays that graze the common surface
    const auto next = [](std::size_t k) { return (k + 1) % 3; };
    const auto last = [](std::size_t k) { return (k + 2) % 3; };
    std::array<double, 3> D;
    for (std::size_t k = 0; k < 3; ++k) {
        D[k] = past[k].v + at[k].v - at[next(k)].v - at[last(k)].v;
    }
    // The corner that stands alone, in or out, and how far it reaches along its two edges.
    std::size_t k = 0;
    while (at[k].in != (inside == 1)) ++k;
    const std::size_t i = next(k), j = last(k);
    const double s = at[k].v == 0 ? 0 : at[k].v / (at[k].v - at[i].v);
    const double t = at[k].v == 0 ? 0 : at[k].v / (at[k].v - at[j].v);
    double load = s * t *
                  (at[k].v / 3 - 0.5 * ((D[k] + D[i]) * (s / 3 - s * s / 6 - s * t / 12) +
                                        (D[k] + D[j]) * (t / 3 - t * t / 6 - s * t / 12) +
                                        (D[i] + D[j]) * s * t / 12));
    const double mean = (at[0].w + at[1].w + at[2].w) / 3;
    double area = s * t * mean;
    if (inside == 2) {
        load = (at[0].v + at[1].v + at[2].v) / 3 - (D[0] + D[1] + D[2]) / 12 - load;
        area = mean - area;
    }
    // Less what the sum over seeds has given already, and with what whole faces miss.
    double sum = 0, whole = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const bool others_in = at[next(c)].in && at[last(c)].in;
        const bool others_out = !at[next(c)].in && !at[last(c)].in;
        if (at[c].in) {
            sum += at[c].v;
            area -= at[c].w / 3;
            whole += at[c].v;
            if (others_out && !past[c].in) whole -= at[c].v;
        } else if (others_in && past[c].in) {
            whole += at[c].v;
        }
        if (past[c].in) whole -= past[c].v;
    }
    load -= sum / 3 + whole / 12;
    for (std::size_t c = 0; c < 3; ++c) {
        if (!at[c].in) continue;
        changes.push_back(
            {rims.contact[face[c]], sum > 0 ? load * at[c].v / sum : load / inside, area / inside});
    }
}

}  // namespace

void weigh_rims(std::span<const ContactBody> bodies, std::vector<LayerContact>& contacts)
{
    for (LayerContact& contact : contacts) contact.load = contact.area * contact.compression;
    for (std::size_t begin = 0; begin < contacts.size();) {
        const std::uint32_t b = contacts[begin].body;
        Rims rims{bodies, bodies[b], contacts,
                  std::vector<std::uint32_t>(bodies[b].seeds->count(), nobody)};
        std::size_t end = begin;
        for (; end < contacts.size() && contacts[end].body == b; ++end) {
            if (contacts[end].other == b) continue;
            rims.contact[contacts[end].seed] = static_cast<std::uint32_t>(end);
        }
        begin = end;
        constexpr std::size_t chunk = 2048;
        const std::size_t faces = bodies[b].seeds->faces.size();
        std::vector<std::vector<Change>> found((faces + chunk - 1) / chunk);
        geometry::parallel_for(found.size(), 1, [&](std::size_t from, std::size_t to) {
            for (std::size_t c = from; c < to; ++c) {
                for (std::size_t f = c * chunk; f < std::min(faces, (c + 1) * chunk); ++f) {
                    weigh_face(rims, f, found[c]);
                }
            }
        });
        for (const std::vector<Change>& some : found) {
            for (const Change& change : some) {
                contacts[change.contact].load += change.load;
                contacts[change.contact].area += change.area;
            }
        }
    }
    for (LayerContact& contact : contacts) contact.load = std::max(0.0, contact.load);
}

}  // namespace physics

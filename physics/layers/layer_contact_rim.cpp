#include "physics/layers/layer_contact_rim.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

// One body's samples, and which of them are in contact.
struct Rims {
    std::span<const ContactBody> bodies;
    const ContactBody& body;
    std::span<const LayerContact> contacts;  // of all bodies
    std::vector<std::uint32_t> contact;      // N, into contacts, or no_contact
};

// A sample seen from a face at the rim.
struct Corner {
    bool known = false, in = false;
    double w = 0, v = 0;
};

// What a sample's share of each face would be, tripled.
double share(const Rims& rims, std::uint32_t sample, double area)
{
    return 3 * area / rims.body.samples->valence[sample];
}

// Outside: f_i and f_j go on along the ray as they are at the sample, until the common surface.
Corner beyond(const Rims& rims, std::uint32_t sample, std::uint32_t skeleton, std::uint32_t other)
{
    const SampleWalk& walk = *rims.body.walk;
    const SurfaceSamples& samples = *rims.body.samples;
    if (!walk.valid[sample]) return {};
    const ContactBody& them = rims.bodies[other];
    const Transform& frame = rims.body.frames[samples.frame[skeleton]];
    const Vec3 ray = frame.linear() * samples.direction[sample];
    const geometry::FieldValue there = geometry::value_at(*them.field, walk.position[sample]);
    const bool rigid = them.matter.rigid;
    const Vec3 leaves =
        rigid ? Vec3(-there.gradient) : Vec3(walk.gradient[sample] - there.gradient);
    const double slope = -ray.dot(leaves), steepest = leaves.norm();
    if (!(slope > 1e-3 * steepest)) return {};  // the ray runs along the surface
    const double way = (rims.body.field->isovalue - there.f) / slope;
    const double d = walk.distance[sample] + way;
    Corner corner{.known = true, .in = false};
    corner.w = share(rims, sample, samples.crossed(sample, d) * steepest / slope);
    corner.v = corner.w * std::min(0.0, ray.dot(walk.gradient[sample]) * way);
    return corner;
}

Corner corner_at(const Rims& rims, std::uint32_t sample, std::uint32_t skeleton,
                 std::uint32_t other)
{
    if (sample == no_sample) return {};
    const std::uint32_t c = rims.contact[sample];
    if (c == no_contact) return beyond(rims, sample, skeleton, other);
    const LayerContact& contact = rims.contacts[c];
    if (contact.other != other) return {};
    const double w = share(rims, sample, contact.area);
    return {true, true, w, w * contact.compression};
}

// What a contact gets or loses.
struct Change {
    std::uint32_t contact;
    double load, area;
};

std::size_t next(std::size_t k)
{
    return (k + 1) % 3;
}

std::size_t last(std::size_t k)
{
    return (k + 2) % 3;
}

// A face that a rim cuts: its corners, and those across the edges opposite to them.
struct CutFace {
    std::array<Corner, 3> at, past;
    int inside = 0;  // how many of its corners are: 1 or 2
};

// Whether the rim cuts face f, and all that it takes to integrate over it is known.
bool cut_face(const Rims& rims, std::size_t f, CutFace& out)
{
    const geometry::Triangle& face = rims.body.samples->faces[f];
    const LayerContact* first = nullptr;
    out.inside = 0;
    for (const std::uint32_t sample : face) {
        if (rims.contact[sample] == no_contact) continue;
        ++out.inside;
        if (!first) first = &rims.contacts[rims.contact[sample]];
    }
    if (out.inside == 0 || out.inside == 3) return false;
    std::array<Corner, 3>&at = out.at, &past = out.past;
    for (std::size_t k = 0; k < 3; ++k) {
        at[k] = corner_at(rims, face[k], first->skeleton, first->other);
        if (!at[k].known) return false;
    }
    for (std::size_t k = 0; k < 3; ++k) {
        past[k] = corner_at(rims, rims.body.samples->across[f][k], first->skeleton, first->other);
        if (!past[k].known) return false;
    }
    double least = std::numeric_limits<double>::infinity(), most = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        least = std::min({least, at[k].w, past[k].w});
        most = std::max({most, at[k].w, past[k].w});
    }
    return most < 4 * least;  // else no lattice: rays that graze the common surface
}

// What a face has inside the contact.
struct Inside {
    double load, area;
};

Inside integral(const CutFace& face)
{
    const std::array<Corner, 3>& at = face.at;
    std::array<double, 3> D;
    for (std::size_t k = 0; k < 3; ++k) {
        D[k] = face.past[k].v + at[k].v - at[next(k)].v - at[last(k)].v;
    }
    // The corner that stands alone, in or out, and how far it reaches along its two edges.
    std::size_t k = 0;
    while (at[k].in != (face.inside == 1)) ++k;
    const std::size_t i = next(k), j = last(k);
    const double s = at[k].v == 0 ? 0 : at[k].v / (at[k].v - at[i].v);
    const double t = at[k].v == 0 ? 0 : at[k].v / (at[k].v - at[j].v);
    const double load = s * t *
                        (at[k].v / 3 - 0.5 * ((D[k] + D[i]) * (s / 3 - s * s / 6 - s * t / 12) +
                                              (D[k] + D[j]) * (t / 3 - t * t / 6 - s * t / 12) +
                                              (D[i] + D[j]) * s * t / 12));
    const double mean = (at[0].w + at[1].w + at[2].w) / 3;
    const double area = s * t * mean;
    if (face.inside == 1) return {load, area};
    return {(at[0].v + at[1].v + at[2].v) / 3 - (D[0] + D[1] + D[2]) / 12 - load, mean - area};
}

void weigh_face(const Rims& rims, std::size_t f, std::vector<Change>& changes)
{
    CutFace face;
    if (!cut_face(rims, f, face)) return;
    const std::array<Corner, 3>&at = face.at, &past = face.past;
    auto [load, area] = integral(face);
    // Less what the sum over samples has given already, and with what whole faces miss.
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
        changes.push_back({rims.contact[rims.body.samples->faces[f][c]],
                           sum > 0 ? load * at[c].v / sum : load / face.inside,
                           area / face.inside});
    }
}

}  // namespace

void weigh_rims(std::span<const ContactBody> bodies, std::vector<LayerContact>& contacts)
{
    for (LayerContact& contact : contacts) contact.load = contact.area * contact.compression;
    for (std::size_t begin = 0; begin < contacts.size();) {
        const std::uint32_t b = contacts[begin].body;
        Rims rims{bodies, bodies[b], contacts,
                  std::vector<std::uint32_t>(bodies[b].samples->count(), no_contact)};
        std::size_t end = begin;
        for (; end < contacts.size() && contacts[end].body == b; ++end) {
            if (contacts[end].other == b) continue;
            rims.contact[contacts[end].sample] = static_cast<std::uint32_t>(end);
        }
        begin = end;
        constexpr std::size_t chunk = 2048;
        const std::size_t faces = bodies[b].samples->faces.size();
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

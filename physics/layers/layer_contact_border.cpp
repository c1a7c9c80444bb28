#include "physics/layers/layer_contact_border.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace physics {
namespace {

using geometry::Triangle;

// The nearest point of f = c along the gradient.
Vec3 onto_surface(const Field& field, Vec3 p)
{
    for (int i = 0; i < 20; ++i) {
        const geometry::FieldValue at = geometry::value_at(field, p);
        const double slope_sq = at.gradient.squaredNorm();
        const double miss = field.isovalue - at.f;
        if (!(slope_sq > 0) || std::abs(miss) < 1e-15 * field.isovalue) break;
        p += miss / slope_sq * at.gradient;
    }
    return p;
}

// Between p in contact and q free, both on `own`'s surface: where `other`'s field is c as well.
// The sign change is kept between its brackets (Illinois' rule halves what a stuck end weighs).
Vec3 border_point(const Field& own, const Field& other, const Vec3& p, const Vec3& q)
{
    const auto at = [&](double s) { return onto_surface(own, (1 - s) * p + s * q); };
    const auto depth = [&](const Vec3& x) { return geometry::value_at(other, x).f - own.isovalue; };
    double a = 0, b = 1, fa = depth(p), fb = depth(q);
    Vec3 x = p;
    int stuck = 0;
    for (int i = 0; i < 100 && b - a > 1e-15; ++i) {
        double s = fa > fb ? a + (b - a) * fa / (fa - fb) : 0.5 * (a + b);
        if (!(s > a && s < b)) s = 0.5 * (a + b);
        x = at(s);
        const double f = depth(x);
        if (std::abs(f) <= 1e-15 * own.isovalue) break;
        const bool in = f > 0;
        if (in) {
            a = s;
            fa = f;
            if (stuck == 1) fb *= 0.5;
        } else {
            b = s;
            fb = f;
            if (stuck == -1) fa *= 0.5;
        }
        stuck = in ? 1 : -1;
    }
    return x;
}

Vec3 polygon_area(std::span<const Vec3> corners)
{
    Vec3 twice = Vec3::Zero();
    for (std::size_t k = 1; k + 1 < corners.size(); ++k) {
        twice += (corners[k] - corners[0]).cross(corners[k + 1] - corners[0]);
    }
    return 0.5 * twice;
}

// What one face adds to its patch.
struct Share {
    std::uint32_t other = no_contact;
    double area = 0, length = 0;
    bool left_out = false, cut = false;
    BorderPiece piece;
};

struct Surface {
    const ContactBody& body;
    std::vector<std::uint32_t> contact;  // N, number of the sample's contact, or no_contact
};

Share share_of(std::span<const ContactBody> bodies, std::uint32_t b, const Surface& surface,
               const Contacts& contacts, const Triangle& face)
{
    Share share;
    std::array<const LayerContact*, 3> in{};
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::uint32_t c = surface.contact[face[k]];
        if (c == no_contact) continue;
        in[k] = &contacts.contacts[c];
        if (share.other == no_contact) share.other = in[k]->other;
        ++count;
    }
    if (count == 0) return share;
    const SampleWalk& walk = *surface.body.walk;
    for (const std::uint32_t v : face) {
        if (count < 3 && !walk.valid[v]) {  // its surface ends at a territory's border
            share.left_out = true;
            return share;
        }
    }
    const Field& own = *surface.body.field;
    const Field& other = *bodies[share.other].field;
    std::array<Vec3, 4> polygon;
    std::size_t corners = 0, leaves = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        if (in[k]) polygon[corners++] = in[k]->position;
        if (!in[k] == !in[next]) continue;
        const Vec3 p = walk.position[face[in[k] ? k : next]];
        const Vec3 q = walk.position[face[in[k] ? next : k]];
        if (in[k]) leaves = corners;
        polygon[corners++] = border_point(own, other, p, q);
    }
    const Vec3 flat = polygon_area({polygon.data(), corners});
    share.area = flat.norm();
    if (count == 3) return share;

    const Vec3 p = polygon[leaves], q = polygon[(leaves + 1) % corners];
    const Vec3 chord = q - p;
    std::array<Vec3, 2> t;
    for (std::size_t end = 0; end < 2; ++end) {
        const Vec3& x = end == 0 ? p : q;
        // To the left of it, seen from outside, is where the other's field is larger.
        const Vec3 along =
            geometry::value_at(own, x).gradient.cross(geometry::value_at(other, x).gradient);
        const double size = along.norm();
        // Parallel gradients: surfaces that only just touch have no border.
        t[end] = size > 0 ? Vec3(along / size) : Vec3::Zero();
    }
    const double half_cosine = std::min(1.0, 0.5 * (t[0] + t[1]).norm());  // cos(delta / 2)
    const double L = chord.norm() / (0.5 * (1 + half_cosine));
    const Vec3 lens = L / 10 * chord.cross(t[1] - t[0]) - L * L / 60 * t[0].cross(t[1]);
    if (share.area > 0) share.area += lens.dot(flat) / share.area;
    const double half = std::acos(half_cosine);
    share.length = chord.norm() * (half > 1e-6 ? half / std::sin(half) : 1);
    share.cut = true;
    share.piece = {b, share.other, {p, q}, t};
    return share;
}

}  // namespace

LayerContactBorder find_border(std::span<const ContactBody> bodies, const Contacts& contacts)
{
    LayerContactBorder border;
    for (std::uint32_t b = 0; b < bodies.size(); ++b) {
        const ContactBody& body = bodies[b];
        if (!body.samples || body.matter.rigid) continue;
        Surface surface{body, std::vector<std::uint32_t>(body.samples->count(), no_contact)};
        for (std::uint32_t c = 0; c < contacts.contacts.size(); ++c) {
            const LayerContact& contact = contacts.contacts[c];
            if (contact.body == b && contact.other != b) surface.contact[contact.sample] = c;
        }
        const std::vector<Triangle>& faces = body.samples->faces;
        std::vector<Share> shares(faces.size());
        geometry::parallel_for(faces.size(), 256, [&](std::size_t begin, std::size_t end) {
            for (std::size_t f = begin; f < end; ++f) {
                shares[f] = share_of(bodies, b, surface, contacts, faces[f]);
            }
        });
        std::map<std::uint32_t, ContactPatch> patches;
        for (const Share& share : shares) {
            if (share.other == no_contact) continue;
            ContactPatch& patch =
                patches.try_emplace(share.other, ContactPatch{b, share.other}).first->second;
            patch.area += share.area;
            patch.length += share.length;
            if (share.left_out) patch.whole = false;
            if (share.cut) border.pieces.push_back(share.piece);
        }
        for (const auto& [other, patch] : patches) border.patches.push_back(patch);
    }
    return border;
}

}  // namespace physics

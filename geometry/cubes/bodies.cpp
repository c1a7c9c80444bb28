#include "geometry/cubes/bodies.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/union_find.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/nested_pieces.hpp"
#include "geometry/mesh/pieces.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace geometry {
namespace {

// Joins hollows to what they are in: pieces wound against the solid around them, whether or not all
// of the model is mirrored.
void join_hollows(const TriMesh& mesh, const Pieces& pieces, UnionFind& sets)
{
    bool any_out = false, any_in = false;
    for (std::uint32_t p = 0; p < pieces.count(); ++p) {
        if (pieces.encloses[p] == 0) continue;
        (pieces.volume[p] < 0 ? any_in : any_out) = true;
    }
    if (!any_out || !any_in) return;  // they would all be wound as what is around them
    for (const NestedPiece& nested : nested_pieces(mesh, pieces)) {
        if (nested.winding == 0 || is_wound_as_around(pieces, nested)) continue;
        sets.join(nested.piece, nested.around);
    }
}

FaceBodies numbered(const Pieces& pieces, UnionFind& sets)
{
    FaceBodies out;
    out.of.assign(pieces.of.size(), no_index);
    std::vector<std::uint32_t> number(pieces.count(), no_index);
    for (std::size_t t = 0; t < pieces.of.size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        std::uint32_t& body = number[sets.root(pieces.of[t])];
        if (body == no_index) body = static_cast<std::uint32_t>(out.count++);
        out.of[t] = body;
    }
    return out;
}

template <class T> void append(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

// What the bodies have one after another, cubes and corners by their numbers there.
Cubes listed(std::span<const Cubes> bodies)
{
    Cubes all = bodies[0];
    const auto fill_part = [](Cubes& cubes) {
        cubes.part.resize(cubes.count(), ~std::uint64_t{0});
    };
    fill_part(all);
    all.own.resize(all.count(), no_index);
    all.component.clear();
    for (const Cubes& body : bodies.subspan(1)) {
        const auto corners = static_cast<std::uint32_t>(all.corner_count());
        const auto elements = static_cast<std::uint32_t>(all.elements.size());
        append(all.cell, body.cell);
        append(all.corner, body.corner);
        for (auto own : body.corners) {
            for (auto& k : own) k += corners;
            all.corners.push_back(own);
        }
        append(all.mass, body.mass);
        append(all.fill, body.fill);
        append(all.young, body.young);
        append(all.poisson, body.poisson);
        append(all.mass_damping, body.mass_damping);
        append(all.stiffness_damping, body.stiffness_damping);
        append(all.matter, body.matter);
        append(all.part, body.part);
        fill_part(all);
        append(all.elements, body.elements);
        for (const auto own : body.own) all.own.push_back(own == no_index ? own : own + elements);
        all.own.resize(all.count(), no_index);
        for (std::size_t i = 0; i < all.attributes.size(); ++i) {
            append(all.attributes[i].values, body.attributes[i].values);
        }
    }
    if (all.elements.empty()) all.own.clear();
    return all;
}

// 0 .. places, sorted by (z, y, x), and then by number.
std::vector<std::uint32_t> sorted_by_place(std::span<const Vec3i> places)
{
    std::vector<std::uint32_t> order(places.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const Vec3i &p = places[a], &q = places[b];
        return std::tuple(p.z(), p.y(), p.x(), a) < std::tuple(q.z(), q.y(), q.x(), b);
    });
    return order;
}

template <class T> void reorder(std::vector<T>& values, std::span<const std::uint32_t> order)
{
    if (values.empty()) return;
    std::vector<T> out;
    out.reserve(order.size());
    for (const auto i : order) out.push_back(values[i]);
    values = std::move(out);
}

}  // namespace

FaceBodies bodies_of_pieces(const TriMesh& mesh)
{
    const Pieces pieces = find_pieces(mesh);
    UnionFind sets(pieces.count());
    join_hollows(mesh, pieces, sets);
    return numbered(pieces, sets);
}

FaceBodies bodies_of_groups(const TriMesh& mesh)
{
    const Pieces pieces = find_pieces(mesh);
    UnionFind sets(pieces.count());
    join_hollows(mesh, pieces, sets);
    const MeshTopology& topology = *mesh.topology;
    std::vector<std::uint32_t> first(std::max<std::size_t>(1, topology.groups.size()), no_index);
    for (std::size_t t = 0; t < pieces.of.size(); ++t) {
        if (pieces.of[t] == no_index) continue;
        const std::size_t group = topology.group.empty() ? 0 : topology.group[t];
        if (group >= first.size()) continue;
        if (first[group] == no_index) first[group] = pieces.of[t];
        sets.join(pieces.of[t], first[group]);
    }
    return numbered(pieces, sets);
}

Cubes side_by_side(std::span<const Cubes> bodies)
{
    if (bodies.empty()) return {};
    if (bodies.size() == 1) return bodies[0];
    Cubes all = listed(bodies);
    const std::vector<std::uint32_t> cubes = sorted_by_place(all.cell);
    const std::vector<std::uint32_t> corners = sorted_by_place(all.corner);
    std::vector<std::uint32_t> number(corners.size());
    for (std::uint32_t i = 0; i < corners.size(); ++i) number[corners[i]] = i;
    reorder(all.cell, cubes);
    reorder(all.corners, cubes);
    for (auto& own : all.corners) {
        for (auto& k : own) k = number[k];
    }
    reorder(all.corner, corners);
    for (auto* values : {&all.mass, &all.fill, &all.young, &all.poisson, &all.mass_damping,
                         &all.stiffness_damping}) {
        reorder(*values, cubes);
    }
    reorder(all.matter, cubes);
    reorder(all.part, cubes);
    reorder(all.own, cubes);
    for (CubeAttribute& a : all.attributes) reorder(a.values, cubes);
    return all;
}

}  // namespace geometry

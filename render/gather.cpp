// A surface is gathered in this order: its mesh gets normals and a layout, each material's look is
// packed once, the vertices are filled in parallel, the opaque triangles become a batch, and the
// transparent ones wait for finish_gathering.

#include "render/gather.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/mesh/normals.hpp"
#include "geometry/mesh/unstated_material.hpp"
#include "render/surface_layout.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <span>
#include <stdexcept>

namespace render {
namespace {

using geometry::Triangle;
using geometry::Vec2f;

constexpr std::size_t vertex_grain = 8192;
constexpr double crease = 0.7;     // radians, for meshes that come without normals
constexpr float farthest = 1e6;    // stage units
constexpr double touching = 1e-3;  // stage units

std::uint8_t byte(float x)
{
    return static_cast<std::uint8_t>(std::lround(255 * std::clamp(x, 0.0f, 1.0f)));
}

std::array<std::uint8_t, 4> root_and(const Vec3f& linear, float fourth)
{
    const Vec3f root = linear.cwiseMax(0).cwiseSqrt();
    return {byte(root[0]), byte(root[1]), byte(root[2]), byte(fourth)};
}

// A direction as a point of the square -1..1: the octahedron unfolded. Cigolle et al., A survey of
// efficient representations for independent unit vectors, JCGT 3(2), 2014.
Vec2f octahedral(const Vec3f& unit)
{
    const float sum = unit.cwiseAbs().sum();
    Vec2f at = unit.head<2>() / sum;
    if (unit.z() < 0) {
        const Vec2f folded(1 - std::abs(at.y()), 1 - std::abs(at.x()));
        at = Vec2f(std::copysign(folded.x(), at.x()), std::copysign(folded.y(), at.y()));
    }
    return at;
}

std::array<std::int16_t, 2> packed(const Vec3f& normal)
{
    const float length = normal.norm();
    const Vec2f at = octahedral(length > 0 && std::isfinite(length) ? Vec3f(normal / length)
                                                                    : Vec3f(Vec3f::UnitY()));
    return {static_cast<std::int16_t>(std::lround(at[0] * 32767)),
            static_cast<std::int16_t>(std::lround(at[1] * 32767))};
}

bool drawable(const Gathering& all, const Vec3f& p)
{
    return (p - all.centre).cwiseAbs().maxCoeff() <= all.reach;  // false for not-a-number
}

Batch open_batch(const Gathering& all, Batch::Shape shape)
{
    Batch batch;
    batch.shape = shape;
    batch.first = static_cast<std::uint32_t>(all.list.indices.size());
    return batch;
}

void close_batch(Gathering& all, Batch batch)
{
    batch.count = static_cast<std::uint32_t>(all.list.indices.size()) - batch.first;
    if (batch.count > 0) all.list.opaque.push_back(batch);
}

void add_vertex(Gathering& all, const Vertex& vertex)
{
    all.list.indices.push_back(static_cast<std::uint32_t>(all.list.vertices.size()));
    all.list.vertices.push_back(vertex);
}

// The mesh with normals, or the given one when it has them. Null when it has none and none can be
// computed, as its faces name vertices that are not there.
std::shared_ptr<const TriMesh> with_normals(const std::shared_ptr<const TriMesh>& mesh)
{
    const auto& topology = *mesh->topology;
    if (topology.normal_triangles.size() == topology.triangles.size() &&
        (!mesh->normals.empty() || topology.triangles.empty())) {
        return mesh;
    }
    auto out = std::make_shared<TriMesh>();
    out->topology = mesh->topology;
    out->positions = mesh->positions;
    out->colours = mesh->colours;
    out->attributes = mesh->attributes;
    const std::size_t count = mesh->positions.size();
    const auto broken = [&](const Triangle& t) {
        return t[0] >= count || t[1] >= count || t[2] >= count;
    };
    if (std::any_of(topology.triangles.begin(), topology.triangles.end(), broken)) return nullptr;
    geometry::compute_normals(*out, crease);
    return out;
}

[[noreturn]] void no_such_attribute(const TriMesh& mesh, const std::string& wanted)
{
    std::string has;
    for (const auto& a : mesh.attributes) has += (has.empty() ? "" : ", ") + a.name;
    throw std::invalid_argument("the mesh is to be coloured by `" + wanted +
                                "`, which it does not have; it has " +
                                (has.empty() ? "no attributes" : has));
}

const geometry::Attribute& find_attribute(const TriMesh& mesh, const std::string& name)
{
    for (const auto& a : mesh.attributes) {
        if (a.name == name && a.values.size() == mesh.positions.size()) return a;
    }
    no_such_attribute(mesh, name);
}

// What each material looks like, once.
std::vector<Vertex> looks_of(const TriMesh& mesh, const Surface& surface)
{
    const Paint& paint = surface.paint;
    const geometry::Material plain;
    const auto& materials = mesh.topology->materials;
    std::vector<Vertex> looks(std::max<std::size_t>(1, materials.size()));
    for (std::size_t m = 0; m < looks.size(); ++m) {
        const geometry::Material& material = m < materials.size() ? materials[m] : plain;
        const Vec3f& colour = paint.by == Paint::By::constant ? paint.colour : material.colour;
        looks[m] = {};
        looks[m].colour = root_and(colour, material.roughness);
        looks[m].material = {byte(material.metallic), byte(material.opacity * surface.opacity),
                             surface.receives ? std::uint8_t{255} : std::uint8_t{0}, 0};
    }
    return looks;
}

// Of which materials the vertices show their own colours, where they have any: also of those that
// nothing was said of.
std::vector<char> own_colours(const TriMesh& mesh, Paint::By by, std::size_t looks)
{
    std::vector<char> own(looks, by == Paint::By::vertex_colour);
    if (!geometry::has_vertex_colours(mesh)) return std::vector<char>(looks, 0);
    if (by != Paint::By::material) return own;
    const auto& materials = mesh.topology->materials;
    for (std::size_t m = 0; m < looks; ++m) {
        own[m] = m >= materials.size() || geometry::is_unstated(materials[m]);
    }
    return own;
}

// Appends where in their pictures the vertices from `base` on lie. Those of surfaces without
// textures lie nowhere.
void add_uvs(Gathering& all, const TriMesh& mesh, const SurfaceLayout& layout, std::size_t base)
{
    if (layout.uv.empty()) return;
    auto& uvs = all.list.uvs;
    uvs.resize(base);
    for (const std::uint32_t i : layout.uv) {
        const Vec2f at = i == geometry::no_index ? Vec2f(0, 0) : mesh.topology->uvs[i];
        uvs.push_back({at.x(), at.y()});
    }
}

// Appends the surface's vertices. Returns how many of them cannot be drawn.
std::size_t add_vertices(Gathering& all, const Surface& surface, const TriMesh& mesh,
                         const SurfaceLayout& layout, const geometry::Attribute* attribute)
{
    const Paint& paint = surface.paint;
    const std::vector<Vertex> looks = looks_of(mesh, surface);
    const std::vector<char> own = own_colours(mesh, paint.by, looks.size());
    const std::size_t base = all.list.vertices.size(), count = layout.position.size();
    all.list.vertices.resize(base + count);
    std::atomic<std::size_t> bad = 0;
    geometry::parallel_for(count, vertex_grain, [&](std::size_t begin, std::size_t end) {
        std::size_t bad_here = 0;
        for (std::size_t i = begin; i < end; ++i) {
            Vertex& v = all.list.vertices[base + i];
            const std::uint32_t from = layout.position[i];
            const Vec3f& p = mesh.positions[from];
            const std::uint16_t material = layout.material[i];
            v = looks[material];
            v.position = {p[0], p[1], p[2]};
            v.normal = packed(mesh.normals[layout.normal[i]]);
            if (attribute) v.value = paint.scale.place(attribute->values[from]);
            if (own[material]) {
                const auto rough = v.colour[3];
                v.colour = root_and(mesh.colours[from], 0);
                v.colour[3] = rough;
            }
            bad_here += drawable(all, p) ? 0 : 1;
        }
        bad += bad_here;
    });
    add_uvs(all, mesh, layout, base);
    return bad;
}

// The number of a texture in the list, which gets it where it does not have it; -1 without one.
std::int32_t number_of(DrawList& list, const std::shared_ptr<const geometry::Texture>& texture,
                       bool normals)
{
    if (!texture) return -1;
    auto& all = list.textures;
    const auto same = [&](const DrawnTexture& t) {
        return t.normals == normals && t.texture->digest() == texture->digest();
    };
    const auto at = std::find_if(all.begin(), all.end(), same);
    const auto number = static_cast<std::int32_t>(at - all.begin());
    if (at == all.end()) all.push_back({texture, normals});
    return number;
}

// The batch for a part of a surface.
Batch batch_of(Gathering& all, const SurfaceLayout::Part& part, const TriMesh& mesh,
               const Surface& surface)
{
    Batch batch = open_batch(all, Batch::Shape::triangles);
    batch.mapped = surface.paint.by == Paint::By::attribute;
    batch.map = surface.paint.scale.map;
    batch.shadow = surface.shadow;
    batch.body = surface.kind == Surface::Kind::body;
    batch.ghost = surface.kind == Surface::Kind::ghost;
    if (!part.textured) return batch;
    const geometry::Material& material = mesh.topology->materials[part.material];
    batch.cover.texture = number_of(all.list, material.texture, false);
    batch.cover.normals = number_of(all.list, material.normal_map, true);
    batch.cover.bump = material.bump;
    const Paint::By by = surface.paint.by;
    batch.cover.colours = by == Paint::By::material || by == Paint::By::checker;
    batch.cover.use = material.use;
    return batch;
}

// Appends triangles that are drawn alike, whose vertices start at `offset`. Where `some_bad`, those
// with a vertex that cannot be drawn are left out.
void add_triangles(Gathering& all, std::span<const Triangle> triangles, bool clear,
                   const Batch& batch, std::uint32_t offset, bool some_bad)
{
    DrawList& list = all.list;
    const auto draws = [&](const Triangle& t) {
        if (!some_bad) return true;
        for (const auto i : t) {
            const auto& p = list.vertices[offset + i].position;
            if (!drawable(all, {p[0], p[1], p[2]})) return false;
        }
        return true;
    };
    if (!clear) {
        list.indices.reserve(list.indices.size() + 3 * triangles.size());
        for (const Triangle& t : triangles) {
            if (!draws(t)) continue;
            for (const auto i : t) list.indices.push_back(offset + i);
        }
        close_batch(all, batch);
        return;
    }
    const auto style = static_cast<std::uint32_t>(all.styles.size());
    all.styles.push_back(batch);
    Box& bounds = all.clear_bounds.back();
    for (const Triangle& t : triangles) {
        if (!draws(t)) continue;
        Vec3f sum = Vec3f::Zero();
        for (const auto i : t) {
            const Vec3f p(list.vertices[offset + i].position.data());
            sum += p - all.centre;
            bounds.add(Vec3(p.cast<double>()));
        }
        all.clear.push_back(
            {sum.dot(all.towards_eye), {offset + t[0], offset + t[1], offset + t[2]}, style});
    }
}

}  // namespace

Gathering start_gathering(DrawList& list, const Vec3& towards_eye)
{
    return {list,
            towards_eye.cast<float>(),
            list.units.centre.cast<float>(),
            farthest / float(list.units.scale),
            {},
            {},
            {}};
}

void add_surface(Gathering& all, const Surface& surface, std::size_t number)
{
    const auto mesh = with_normals(surface.mesh);
    const std::string name = "surface " + std::to_string(number + 1);
    const auto warn = [&](const std::string& text) { all.list.warnings.push_back(name + text); };
    if (!mesh) {
        warn(" is not drawn: it has no normals, and faces that name vertices that are not there");
        return;
    }
    SurfaceLayout made;
    const SurfaceLayout* layout = surface.layout.get();
    if (!layout || !layout->suits(*mesh)) {
        made = surface_layout(*mesh);
        layout = &made;
    }
    if (layout->skipped > 0) {
        warn(": " + std::to_string(layout->skipped) +
             " faces are not drawn: they name vertices, normals or materials that are not there");
    }
    const geometry::Attribute* attribute = nullptr;
    if (surface.paint.by == Paint::By::attribute) {
        attribute = &find_attribute(*mesh, surface.paint.attribute);
    }

    const auto offset = static_cast<std::uint32_t>(all.list.vertices.size());
    const std::size_t bad = add_vertices(all, surface, *mesh, *layout, attribute);
    if (bad > 0) {
        warn(": " + std::to_string(bad) +
             " vertices are not finite or immensely far away: their faces are not drawn");
    }
    all.clear_bounds.emplace_back();
    std::span<const Triangle> rest(layout->triangles);
    // A ghost of opacity 1 too: only what is laid over a body spares it.
    const bool clear = surface.opacity < 1 || surface.kind == Surface::Kind::ghost;
    for (const SurfaceLayout::Part& part : layout->parts) {
        const Batch batch = batch_of(all, part, *mesh, surface);
        add_triangles(all, rest.first(part.count), part.clear || clear, batch, offset, bad > 0);
        rest = rest.subspan(part.count);
    }
}

void add_lines(Gathering& all, const Lines& lines)
{
    Batch batch = open_batch(all, Batch::Shape::lines);
    batch.size = lines.width;
    batch.shadow = false;
    Vertex v{};
    v.colour = root_and(lines.colour, 1);
    v.material = {0, 255, 0, 0};
    for (std::size_t i = 0; i + 1 < lines.ends.size(); i += 2) {
        if (!drawable(all, lines.ends[i]) || !drawable(all, lines.ends[i + 1])) continue;
        for (std::size_t k = i; k < i + 2; ++k) {
            const Vec3f& p = lines.ends[k];
            v.position = {p[0], p[1], p[2]};
            add_vertex(all, v);
        }
    }
    close_batch(all, batch);
}

void add_balls(Gathering& all, const Balls& balls)
{
    if (balls.colours.size() != 1 && balls.colours.size() != balls.centres.size()) {
        throw std::invalid_argument("balls need one colour, or one for each");
    }
    Batch batch = open_batch(all, Batch::Shape::balls);
    batch.shadow = balls.shadow;
    batch.size = balls.smallest;
    Vertex v{};
    v.material = {0, 255, 255, 0};
    v.value = balls.radius;
    for (std::size_t i = 0; i < balls.centres.size(); ++i) {
        const Vec3f& p = balls.centres[i];
        if (!drawable(all, p)) continue;
        v.position = {p[0], p[1], p[2]};
        v.colour = root_and(balls.colours[balls.colours.size() == 1 ? 0 : i], 0.5);
        add_vertex(all, v);
    }
    close_batch(all, batch);
}

// Whether two lie in each other by more than `least`, m, along each axis; what is thinner than
// that need not.
bool any_overlap(const std::vector<Box>& boxes, double least)
{
    for (std::size_t i = 0; i < boxes.size(); ++i) {
        for (std::size_t k = 0; k < i; ++k) {
            const Vec3 both = boxes[i].hi.cwiseMin(boxes[k].hi) - boxes[i].lo.cwiseMax(boxes[k].lo);
            const Vec3 thinner = boxes[i].size().cwiseMin(boxes[k].size());
            const Vec3 needed = (0.5 * thinner).cwiseMin(least);
            if ((both.array() >= needed.array()).all()) return true;
        }
    }
    return false;
}

// All transparent triangles in the order that they have. Neighbours with the same style share a
// batch.
static void add_clear(Gathering& all)
{
    DrawList& list = all.list;
    for (std::size_t i = 0; i < all.clear.size(); ++i) {
        const Gathering::ClearTriangle& triangle = all.clear[i];
        if (i == 0 || triangle.style != all.clear[i - 1].style) {
            Batch batch = all.styles[triangle.style];
            batch.first = static_cast<std::uint32_t>(list.indices.size());
            batch.count = 0;
            list.clear.push_back(batch);
        }
        list.indices.insert(list.indices.end(), triangle.corners.begin(), triangle.corners.end());
        list.clear.back().count += 3;
    }
}

// By the triangles' centres.
void finish_gathering(Gathering& all)
{
    DrawList& list = all.list;
    if (!list.uvs.empty()) list.uvs.resize(list.vertices.size());
    if (any_overlap(all.clear_bounds, touching / list.units.scale)) add_clear(all);
    list.layered = list.clear.size();
    std::stable_sort(all.clear.begin(), all.clear.end(),
                     [](const auto& a, const auto& b) { return a.depth < b.depth; });
    add_clear(all);
}

}  // namespace render

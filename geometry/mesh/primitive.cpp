#include "geometry/mesh/primitive.hpp"

#include "geometry/base/numbering.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/normals.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

namespace geometry {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double most_faces = 50e6;

void want_size(const char* what, double value)
{
    if (!(value > 0) || !(value < 1e30)) {
        throw std::invalid_argument(std::string(what) + ": expected a positive length in metres");
    }
}

void want_count(const char* what, int value, int least)
{
    if (value < least) {
        throw std::invalid_argument(std::string(what) + ": expected at least " +
                                    std::to_string(least) + ", found " + std::to_string(value));
    }
}

void want_faces(double faces)
{
    if (faces > most_faces) {
        throw std::invalid_argument(fmt::format(
            "the shape would have {:.15g} faces, the limit is 50 million: lower its counts",
            faces));
    }
}

// A sheet of quads whose vertices are welded by a lattice key, each cut into two triangles.
struct Quads {
    MeshTopology topology;
    std::vector<Vec3f> positions, normals;

    void quad(const std::array<std::uint32_t, 4>& v, const std::array<std::uint32_t, 4>& n,
              const std::array<std::uint32_t, 4>& uv)
    {
        // A pole's quad has two equal vertices: half of it is nothing.
        const auto add = [&](std::size_t a, std::size_t b, std::size_t c) {
            if (v[a] == v[b] || v[b] == v[c] || v[c] == v[a]) return;
            topology.triangles.push_back({v[a], v[b], v[c]});
            topology.normal_triangles.push_back({n[a], n[b], n[c]});
            topology.uv_triangles.push_back({uv[a], uv[b], uv[c]});
        };
        add(0, 1, 2);
        add(0, 2, 3);
    }
    TriMesh mesh() &&
    {
        TriMesh out;
        out.topology = std::make_shared<const MeshTopology>(std::move(topology));
        out.positions = std::move(positions);
        out.normals = std::move(normals);
        return out;
    }
};

// A surface (u, v) -> position and normal over a lattice of nu by nv quads, u to the right and v up
// when seen from outside. A closed direction joins its last line to its first.
template <class Position, class Normal>
void add_surface(Quads& out, int nu, int nv, bool closed_u, bool closed_v, const Position& position,
                 const Normal& normal)
{
    const auto base = static_cast<std::uint32_t>(out.positions.size());
    const auto base_uv = static_cast<std::uint32_t>(out.topology.uvs.size());
    const int lines_u = closed_u ? nu : nu + 1, lines_v = closed_v ? nv : nv + 1;
    for (int j = 0; j < lines_v; ++j) {
        stop_if_asked();
        for (int i = 0; i < lines_u; ++i) {
            out.positions.push_back(
                position(double(i) / nu, double(j) / nv).template cast<float>());
            out.normals.push_back(normal(double(i) / nu, double(j) / nv).template cast<float>());
        }
    }
    for (int j = 0; j <= nv; ++j) {
        stop_if_asked();
        for (int i = 0; i <= nu; ++i) {
            out.topology.uvs.emplace_back(float(i) / float(nu), float(j) / float(nv));
        }
    }
    const auto vertex = [&](int i, int j) {
        return base + static_cast<std::uint32_t>((i % lines_u) + (j % lines_v) * lines_u);
    };
    const auto uv = [&](int i, int j) {
        return base_uv + static_cast<std::uint32_t>(i + j * (nu + 1));
    };
    for (int j = 0; j < nv; ++j) {
        stop_if_asked();
        for (int i = 0; i < nu; ++i) {
            const std::array v{vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1),
                               vertex(i, j + 1)};
            out.quad(v, v, {uv(i, j), uv(i + 1, j), uv(i + 1, j + 1), uv(i, j + 1)});
        }
    }
}

// One vertex a position: a box's edges, a cylinder's rims and a sphere's poles come welded.
TriMesh welded(TriMesh mesh)
{
    Numbering<3> vertices(mesh.positions.size());
    std::vector<std::uint32_t> vertex;
    for (const Vec3f& p : mesh.positions) vertex.push_back(vertices.add(bits(p)));
    if (vertices.size() == mesh.positions.size()) return mesh;

    std::vector<Vec3f> positions(vertices.size());
    for (std::size_t i = 0; i < vertex.size(); ++i) positions[vertex[i]] = mesh.positions[i];
    mesh.positions = std::move(positions);
    Numbering<4> normals(mesh.normals.size());  // of a vertex, by their bits
    const auto normal_of = [&](std::uint32_t v, std::uint32_t n) {
        const auto b = bits(mesh.normals[n]);
        return normals.add({v, b[0], b[1], b[2]});
    };
    auto topology = std::make_shared<MeshTopology>();
    const MeshTopology& old = *mesh.topology;
    topology->uvs = old.uvs;
    StopCheck check;
    for (std::size_t f = 0; f < old.triangles.size(); ++f) {
        check();
        Triangle t = old.triangles[f];
        for (auto& v : t) v = vertex[v];
        if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
        topology->triangles.push_back(t);
        Triangle n = old.normal_triangles[f];
        for (std::size_t k = 0; k < 3; ++k) n[k] = normal_of(t[k], n[k]);
        topology->normal_triangles.push_back(n);
        topology->uv_triangles.push_back(old.uv_triangles[f]);
    }
    mesh.normals.clear();
    for (const auto& key : normals.keys()) {
        mesh.normals.emplace_back(std::bit_cast<float>(key[1]), std::bit_cast<float>(key[2]),
                                  std::bit_cast<float>(key[3]));
    }
    mesh.topology = std::move(topology);
    return mesh;
}

}  // namespace

TriMesh box(const Vec3& size, const Vec3i& divisions)
{
    for (int d = 0; d < 3; ++d) {
        want_size("each size of a box", size[d]);
        want_count("each division of a box", divisions[d], 1);
    }
    const auto& n = divisions.cast<double>();
    want_faces(4 * (n[0] * n[1] + n[1] * n[2] + n[2] * n[0]));

    // Side by side: axis w points out, and u x v = w.
    Quads out;
    for (int w = 0; w < 3; ++w) {
        for (const int sign : {-1, 1}) {
            const int u = sign > 0 ? (w + 1) % 3 : (w + 2) % 3;
            const int v = sign > 0 ? (w + 2) % 3 : (w + 1) % 3;
            // From the division's number, so that neighbouring sides agree on every bit.
            const auto at = [&](int axis, double t) {
                return size[axis] * (std::round(t * n[axis]) / n[axis] - 0.5);
            };
            add_surface(
                out, divisions[u], divisions[v], false, false,
                [&](double s, double t) {
                    Vec3 p;
                    p[u] = at(u, s);
                    p[v] = at(v, t);
                    p[w] = 0.5 * sign * size[w];
                    return p;
                },
                [&](double, double) { return Vec3(sign * Vec3::Unit(w)); });
        }
    }
    return welded(std::move(out).mesh());
}

TriMesh uv_sphere(double radius, int segments, int rings)
{
    want_size("the radius of a sphere", radius);
    want_count("segments", segments, 3);
    want_count("rings", rings, 2);
    want_faces(2.0 * segments * rings);
    const auto direction = [&](double s, double t) {
        // The poles exactly, so that each welds to one vertex.
        const double across = t == 0 || t == 1 ? 0 : std::sin(pi * t);
        return Vec3(across * std::sin(2 * pi * s), -std::cos(pi * t),
                    across * std::cos(2 * pi * s));
    };
    Quads out;
    add_surface(
        out, segments, rings, true, false,
        [&](double s, double t) { return Vec3(radius * direction(s, t)); }, direction);
    TriMesh mesh = welded(std::move(out).mesh());
    return mesh;
}

TriMesh icosphere(double radius, int subdivisions)
{
    want_size("the radius of a sphere", radius);
    want_count("subdivisions", subdivisions, 0);
    want_faces(20 * std::pow(4.0, subdivisions));

    const double phi = std::numbers::phi;
    std::vector<Vec3> at{{-1, phi, 0}, {1, phi, 0}, {-1, -phi, 0}, {1, -phi, 0},
                         {0, -1, phi}, {0, 1, phi}, {0, -1, -phi}, {0, 1, -phi},
                         {phi, 0, -1}, {phi, 0, 1}, {-phi, 0, -1}, {-phi, 0, 1}};
    for (Vec3& p : at) p.normalize();
    std::vector<Triangle> triangles{{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                    {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                    {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                    {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int level = 0; level < subdivisions; ++level) {
        const auto corners = static_cast<std::uint32_t>(at.size());
        Numbering<2> edges(triangles.size() * 3 / 2);
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const std::uint32_t edge = edges.add({std::min(a, b), std::max(a, b)});
            if (corners + edge == at.size()) at.push_back((at[a] + at[b]).normalized());
            return corners + edge;
        };
        std::vector<Triangle> finer;
        finer.reserve(4 * triangles.size());
        StopCheck check;
        for (const auto& [a, b, c] : triangles) {
            check();
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
        }
        triangles = std::move(finer);
    }

    TriMesh mesh;
    StopCheck check;
    for (const Vec3& p : at) {
        check();
        mesh.positions.push_back((radius * p).cast<float>());
        mesh.normals.push_back(p.cast<float>());
    }
    MeshTopology topology;
    topology.normal_triangles = triangles;
    topology.triangles = std::move(triangles);
    mesh.topology = std::make_shared<const MeshTopology>(std::move(topology));
    return mesh;
}

TriMesh grid(double size_x, double size_z, int divisions_x, int divisions_z)
{
    want_size("the x size of a grid", size_x);
    want_size("the z size of a grid", size_z);
    want_count("x divisions", divisions_x, 1);
    want_count("z divisions", divisions_z, 1);
    want_faces(2.0 * divisions_x * divisions_z);
    Quads out;
    add_surface(
        out, divisions_x, divisions_z, false, false,
        [&](double s, double t) { return Vec3((s - 0.5) * size_x, 0, (0.5 - t) * size_z); },
        [](double, double) { return Vec3(Vec3::UnitY()); });
    return std::move(out).mesh();
}

TriMesh cylinder(double radius, double height, int segments, int rings)
{
    want_size("the radius of a cylinder", radius);
    want_size("the height of a cylinder", height);
    want_count("segments", segments, 3);
    want_count("rings", rings, 1);
    want_faces(2.0 * segments * (rings + 1.0));
    const auto around = [](double s) {
        return Vec3(std::sin(2 * pi * s), 0, std::cos(2 * pi * s));
    };

    Quads out;
    add_surface(
        out, segments, rings, true, false,
        [&](double s, double t) {
            return Vec3(radius * around(s) + (t - 0.5) * height * Vec3::UnitY());
        },
        [&](double s, double) { return around(s); });
    for (const int sign :
         {-1, 1}) {  // the caps: fans, as one row of quads whose far edge is a point
        add_surface(
            out, segments, 1, true, false,
            [&](double s, double t) {
                const double r = sign > 0 ? (1 - t) * radius : t * radius;
                return Vec3(r * around(s) + 0.5 * sign * height * Vec3::UnitY());
            },
            [&](double, double) { return Vec3(sign * Vec3::UnitY()); });
    }
    return welded(std::move(out).mesh());
}

TriMesh torus(double radius, double tube, int segments, int tube_segments)
{
    want_size("the radius of a torus", radius);
    want_size("the radius of the tube", tube);
    want_count("segments", segments, 3);
    want_count("segments around the tube", tube_segments, 3);
    want_faces(2.0 * segments * tube_segments);
    if (tube >= radius) {
        throw std::invalid_argument(
            "the radius of the tube must be less than the radius of the torus");
    }
    const auto around = [](double s) {
        return Vec3(std::sin(2 * pi * s), 0, std::cos(2 * pi * s));
    };
    const auto normal = [&](double s, double t) {
        return Vec3(std::cos(2 * pi * t) * around(s) + std::sin(2 * pi * t) * Vec3::UnitY());
    };
    Quads out;
    add_surface(
        out, segments, tube_segments, true, true,
        [&](double s, double t) { return Vec3(radius * around(s) + tube * normal(s, t)); }, normal);
    return std::move(out).mesh();
}

}  // namespace geometry

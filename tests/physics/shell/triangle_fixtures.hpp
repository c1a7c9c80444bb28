#pragma once

// Sheets of triangles for tests of shells.

#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/shell/shell.hpp"
#include "tests/physics/shell/shell_fixtures.hpp"

#include <functional>

namespace fixtures {

// How squares are cut in two: along one diagonal, in turns, or each as chance has it, with vertices
// moved by up to `moved` of a square too.
enum class Cut { alike, in_turns, random };

struct Squares {
    int ni = 8, nj = 8;
    double a = 0.125;  // m
    Cut cut = Cut::random;
    double moved = 0.3;
    int rim = 0;  // rows of squares outside 0 .. ni a, 0 .. nj a, whose borders are kept straight
};

inline double chance(std::uint32_t seed, std::uint32_t i)
{
    std::uint32_t x = seed * 2654435761u + i * 40503u + 12345u;
    x ^= x >> 16, x *= 2246822519u, x ^= x >> 13, x *= 3266489917u, x ^= x >> 16;
    return double(x) / 4294967296.0;
}

// In the plane y = 0, or where `to` maps (x, z).
inline geometry::TriMesh squares(
    const Squares& s, const std::function<Vec3(double, double)>& to = [](double x, double z) {
        return Vec3(x, 0, z);
    })
{
    geometry::TriMesh mesh;
    auto topology = std::make_shared<geometry::MeshTopology>();
    const bool random = s.cut == Cut::random;
    const auto kept = [&](int i, int n) {
        return i == -s.rim || i == 0 || i == n || i == n + s.rim;
    };
    const int across = s.ni + 2 * s.rim + 1;
    std::uint32_t drawn = 0;
    for (int j = -s.rim; j <= s.nj + s.rim; ++j) {
        for (int i = -s.rim; i <= s.ni + s.rim; ++i) {
            const double di = 2 * chance(7, drawn++) - 1, dj = 2 * chance(7, drawn++) - 1;
            const double x = i + (random && !kept(i, s.ni) ? s.moved * di : 0);
            const double z = j + (random && !kept(j, s.nj) ? s.moved * dj : 0);
            mesh.positions.push_back(to(x * s.a, z * s.a).cast<float>());
        }
    }
    for (int j = 0; j < s.nj + 2 * s.rim; ++j) {
        for (int i = 0; i < s.ni + 2 * s.rim; ++i) {
            const auto k = static_cast<std::uint32_t>(j * across + i);
            const auto up = static_cast<std::uint32_t>(across);
            const bool other = s.cut == Cut::in_turns ? (i + j) % 2 == 1
                               : random               ? chance(9, k) < 0.5
                                                      : false;
            if (other) {
                topology->triangles.push_back({k, k + up, k + 1});
                topology->triangles.push_back({k + 1, k + up, k + up + 1});
            } else {
                topology->triangles.push_back({k, k + up + 1, k + 1});
                topology->triangles.push_back({k, k + up, k + up + 1});
            }
        }
    }
    mesh.topology = std::move(topology);
    return mesh;
}

inline Cubes sheet_of(const geometry::TriMesh& mesh, double thickness, double nu = 0.3,
                      double young = 1e6, double density = 1000)
{
    return geometry::make_sheet(mesh, thickness, {"sheet", density, young, nu, 0, 0}).cubes;
}

// Pins that hold corners whose place at rest passes a test.
template <class Test> physics::Pins held_at(const Cubes& cubes, const Test& test)
{
    physics::Pins out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (!test(cubes.corner_position(k))) continue;
        out.corner.push_back(k);
        out.target.push_back(cubes.corner_position(k));
    }
    return out;
}

}  // namespace fixtures

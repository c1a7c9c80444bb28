#include "geometry/cubes/mean_attributes.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cells/held_cells.hpp"
#include "geometry/cells/voxel_grid.hpp"
#include "geometry/cubes/assign_matter.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/cubes/local_matter.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

using Attributes = std::span<const Attribute* const>;

bool is_between(char c)
{
    return c == ' ' || c == ',' || c == '\t';
}

std::vector<std::string> words_of(const std::string& text)
{
    std::vector<std::string> words;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (is_between(text[i])) continue;
        if (i == 0 || is_between(text[i - 1])) words.emplace_back();
        words.back() += text[i];
    }
    return words;
}

double value_at(const TriMesh& mesh, std::uint32_t triangle, const Vec3& barycentric,
                const Attribute& a)
{
    const Triangle& t = mesh.triangles()[triangle];
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        sum += barycentric[static_cast<Eigen::Index>(k)] * double(a.values[t[k]]);
    }
    return sum;
}

// Of p in a triangle, each 0 to 1 also where the triangle is a needle, whose rounding errors are
// large; the triangle's middle where it has no area.
Vec3 barycentric_of(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3 normal = (b - a).cross(c - a);
    const double area_sq = normal.squaredNorm();
    if (!(area_sq > 0)) return Vec3::Constant(1.0 / 3);
    const double u = (c - b).cross(p - b).dot(normal) / area_sq;
    const double v = (a - c).cross(p - c).dot(normal) / area_sq;
    const Vec3 all(u, v, 1 - u - v);
    if (!all.allFinite()) return Vec3::Constant(1.0 / 3);
    if (all.minCoeff() >= 0) return all;
    const Vec3 within = all.cwiseMax(0.0).cwiseMin(1.0);
    return within / within.sum();  // which is 1/3 at least, as the sum of `all` is 1
}

// A piece of a triangle: its area, and the middle of that.
struct Piece {
    double area = 0;
    Vec3 middle = Vec3::Zero();
};

Piece measured(const Polygon& polygon)
{
    Piece out;
    for (std::size_t i = 2; i < polygon.n; ++i) {
        const Vec3 &a = polygon.p[0], &b = polygon.p[i - 1], &c = polygon.p[i];
        const double area = 0.5 * (b - a).cross(c - a).norm();
        out.area += area;
        out.middle += area / 3 * (a + b + c);
    }
    if (out.area > 0) out.middle /= out.area;
    return out;
}

// Sums of weight times value, by attribute and cube; and of weights.
struct Sums {
    std::vector<std::vector<double>> value;
    std::vector<double> weight;

    Sums(std::size_t attributes, std::size_t cubes)
        : value(attributes, std::vector<double>(cubes, 0.0)), weight(cubes, 0.0)
    {}
};

void add_faces(const Cubes& cubes, const TriMesh& mesh, Attributes attributes, Sums& sums)
{
    const CubeFinder finder(cubes);
    const VoxelGrid grid{cubes.size, cubes.origin, Vec3i::Zero()};
    LatticeMesh lattice = to_lattice(mesh, grid);
    if (!cubes.part.empty()) lattice = snapped_to_quarters(std::move(lattice), grid);
    for (std::uint32_t t = 0; t < lattice.triangles.size(); ++t) {
        std::array<Vec3, 3> corner;
        Polygon triangle;
        for (std::size_t k = 0; k < 3; ++k) {
            corner[k] = lattice.positions[lattice.triangles[t][k]];
            triangle.add(corner[k]);
        }
        clip_polygon_to_cells(triangle, [&](const Vec3i& cell, const Polygon& polygon) {
            const Piece piece = measured(polygon);
            if (!(piece.area > 0)) return;
            const Vec3 inside =
                (piece.middle - cell.cast<double>()).cwiseMax(0.0).cwiseMin(1 - 1e-9);
            const std::uint32_t cube = finder.find_near(cell.cast<double>() + inside);
            if (cube == no_index) return;
            const Vec3 at = barycentric_of(piece.middle, corner[0], corner[1], corner[2]);
            sums.weight[cube] += piece.area;
            for (std::size_t i = 0; i < attributes.size(); ++i) {
                sums.value[i][cube] +=
                    piece.area * value_at(mesh, static_cast<std::uint32_t>(lattice.source_of(t)),
                                          at, *attributes[i]);
            }
        });
    }
}

Vec3 place_of(const Cubes& cubes, std::size_t cube, const Vec3& in_cell)
{
    return cubes.origin + cubes.size * (cubes.cell[cube].cast<double>() + in_cell);
}

// The places in a cube or a triangle whose mean stands for it, m.
PlacesInCell places_in(const Cubes& cubes, std::size_t cube)
{
    PlacesInCell out;
    if (cubes.is_sheet()) {
        const std::array<Vec3, 3> points = sheet_points(cubes, cube);
        std::copy(points.begin(), points.end(), out.at.begin());
        out.count = points.size();
        return out;
    }
    out = places_in_cell(cubes, cube);
    for (std::size_t i = 0; i < out.count; ++i) out.at[i] = place_of(cubes, cube, out.at[i]);
    return out;
}

Cubes with_values(Cubes cubes, Attributes attributes, std::vector<std::vector<double>> values)
{
    for (std::size_t i = 0; i < attributes.size(); ++i) {
        cubes = with_attribute(std::move(cubes),
                               {attributes[i]->name, attributes[i]->unit, std::move(values[i])});
    }
    return cubes;
}

// A cube that faces only touch gets the value where they are nearest to the middle of what it
// holds.
void add_nearest(const Cubes& cubes, const TriMesh& mesh, Attributes attributes, Sums& sums)
{
    if (std::all_of(sums.weight.begin(), sums.weight.end(), [](double w) { return w > 0; })) return;
    const TriangleBvh tree(mesh);
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (sums.weight[c] > 0) continue;
        const Box held = held_box(cubes, c);
        const auto hit = tree.closest(cubes.origin + cubes.size * 0.5 * (held.lo + held.hi));
        if (!hit) continue;
        sums.weight[c] = 1;
        for (std::size_t i = 0; i < attributes.size(); ++i) {
            sums.value[i][c] = value_at(mesh, hit.triangle, hit.barycentric, *attributes[i]);
        }
    }
}

}  // namespace

std::vector<const Attribute*> chosen_attributes(const std::string& wanted,
                                                std::span<const Attribute> attributes)
{
    std::vector<std::uint8_t> chosen(attributes.size(), 0);
    for (const std::string& word : words_of(wanted)) {
        const bool many = word.find_first_of("*?") != std::string::npos;
        bool found = many;
        for (std::size_t i = 0; i < attributes.size(); ++i) {
            if (!matches(attributes[i].name, word)) continue;
            if (many && !is_own_name(attributes[i].name)) continue;
            check_own_name(attributes[i].name);
            chosen[i] = 1;
            found = true;
        }
        if (found) continue;
        std::string has;
        for (const Attribute& a : attributes) has += (has.empty() ? "" : ", ") + a.name;
        throw std::invalid_argument(fmt::format("the mesh has no attribute '{}'; it has {}", word,
                                                has.empty() ? "none" : has));
    }
    std::vector<const Attribute*> out;
    for (std::size_t i = 0; i < attributes.size(); ++i) {
        if (chosen[i] != 0) out.push_back(&attributes[i]);
    }
    return out;
}

std::vector<CubeAttribute> chosen_values(const std::string& wanted, const Cubes& cubes)
{
    std::vector<CubeAttribute> out;
    const auto add = [&](const std::string& name) {
        const auto same = [&](const CubeAttribute& a) { return a.name == name; };
        if (std::any_of(out.begin(), out.end(), same)) return;
        out.push_back({name, unit_of(cubes, name), cube_values(cubes, name)});
    };
    for (const std::string& word : words_of(wanted)) {
        if (word.find_first_of("*?") == std::string::npos) {
            add(word);
            continue;
        }
        for (const CubeAttribute& a : cubes.attributes) {
            if (matches(a.name, word)) add(a.name);
        }
    }
    return out;
}

Cubes with_means_of_surface(Cubes cubes, const TriMesh& mesh, Attributes attributes)
{
    if (attributes.empty()) return cubes;
    if (cubes.is_sheet()) return with_means_of_solid(std::move(cubes), mesh, attributes);
    Sums sums(attributes.size(), cubes.count());
    add_faces(cubes, mesh, attributes, sums);
    add_nearest(cubes, mesh, attributes, sums);
    for (auto& values : sums.value) {
        for (std::size_t c = 0; c < values.size(); ++c)
            values[c] /= std::max(sums.weight[c], 1e-300);
    }
    return with_values(std::move(cubes), attributes, std::move(sums.value));
}

Cubes with_means_of_solid(Cubes cubes, const TriMesh& mesh, Attributes attributes)
{
    if (attributes.empty()) return cubes;
    const TriangleBvh tree(mesh);
    constexpr std::size_t cubes_a_task = 512;
    std::vector<std::vector<double>> values(attributes.size(),
                                            std::vector<double>(cubes.count(), 0.0));
    parallel_for(cubes.count(), cubes_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const PlacesInCell places = places_in(cubes, c);
            for (std::size_t a = 0; a < places.count; ++a) {
                const auto hit = tree.closest(places.at[a]);
                if (!hit) continue;
                for (std::size_t i = 0; i < attributes.size(); ++i) {
                    values[i][c] += value_at(mesh, hit.triangle, hit.barycentric, *attributes[i]);
                }
            }
            for (auto& of_all : values) of_all[c] /= double(places.count);
        }
    });
    return with_values(std::move(cubes), attributes, std::move(values));
}

void add_attributes(Samples& samples, const TriMesh& mesh, Attributes attributes)
{
    if (attributes.empty()) return;
    const std::size_t n = samples.positions.size();
    const std::size_t first = samples.attributes.size();
    for (const Attribute* a : attributes) {
        check_own_name(a->name);
        samples.attributes.push_back({a->name, a->unit, std::vector<float>(n, 0.f)});
    }
    const auto put = [&](std::size_t sample, std::uint32_t triangle, const Vec3& barycentric) {
        for (std::size_t i = 0; i < attributes.size(); ++i) {
            samples.attributes[first + i].values[sample] =
                static_cast<float>(value_at(mesh, triangle, barycentric, *attributes[i]));
        }
    };
    if (!samples.triangle.empty()) {
        parallel_for(n, 4096, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                const Triangle& t = mesh.triangles()[samples.triangle[s]];
                const auto at = [&](std::size_t k) {
                    return Vec3(mesh.positions[t[k]].cast<double>());
                };
                put(s, samples.triangle[s],
                    barycentric_of(samples.positions[s].cast<double>(), at(0), at(1), at(2)));
            }
        });
    } else if (!mesh.triangles().empty()) {
        const TriangleBvh tree(mesh);
        parallel_for(n, 512, [&](std::size_t begin, std::size_t end) {
            for (std::size_t s = begin; s < end; ++s) {
                const auto hit = tree.closest(samples.positions[s].cast<double>());
                if (hit) put(s, hit.triangle, hit.barycentric);
            }
        });
    } else {
        std::size_t s = 0;  // those with finite positions, as sample_points() has them
        for (std::size_t v = 0; v < mesh.positions.size() && s < n; ++v) {
            if (!mesh.positions[v].allFinite()) continue;
            for (std::size_t i = 0; i < attributes.size(); ++i) {
                samples.attributes[first + i].values[s] = attributes[i]->values[v];
            }
            ++s;
        }
    }
}

void add_means_of_samples(Cubes& cubes, std::span<const Deposit> deposits,
                          std::span<const Samples* const> sets, std::span<const std::uint8_t> used)
{
    // m^3, of a sample without one: nothing beside one that has a volume, and those of a cube
    // where none has one count alike. Times any float it is a normal number still.
    constexpr double least_volume = 1e-150;
    std::vector<CubeAttribute> means;
    std::vector<std::vector<double>> weights;
    const auto place = [&](const Attribute& a) {
        const auto same = [&](const CubeAttribute& b) { return a.name == b.name; };
        const auto found = std::find_if(means.begin(), means.end(), same);
        const auto at = static_cast<std::size_t>(found - means.begin());
        if (found == means.end()) {
            means.push_back({a.name, a.unit, std::vector<double>(cubes.count(), 0.0)});
            weights.emplace_back(cubes.count(), 0.0);
        }
        return at;
    };
    std::size_t deposit = 0, sample = 0;
    for (const Samples* set : sets) {
        std::vector<std::size_t> to;
        for (const Attribute& a : set->attributes) to.push_back(place(a));
        for (std::size_t s = 0; s < set->positions.size(); ++s, ++sample) {
            if (used[sample] == 0) continue;
            const Deposit& d = deposits[deposit++];
            const double weight = std::max(d.volume, least_volume);
            for (std::size_t i = 0; i < to.size(); ++i) {
                means[to[i]].values[d.cube] += weight * double(set->attributes[i].values[s]);
                weights[to[i]][d.cube] += weight;
            }
        }
    }
    for (std::size_t i = 0; i < means.size(); ++i) {
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            if (weights[i][c] > 0) means[i].values[c] /= weights[i][c];
        }
        cubes = with_attribute(std::move(cubes), std::move(means[i]));
    }
}

}  // namespace geometry

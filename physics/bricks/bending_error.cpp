#include "physics/bricks/bending_error.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/cubes/cube_finder.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/pieces.hpp"
#include "geometry/mesh/wall_thickness.hpp"
#include "physics/body/stiffness.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::no_index;
using geometry::Vec3;
using geometry::Vec3i;

constexpr std::size_t sample_count = 2048;
constexpr double thin_below = 12;  // cubes: outer ones half full make an error of 3 / t^2, 2 %
constexpr double alone_below = 5;  // cubes: thicker walls hold no half a cube more than they are
constexpr double thinnest = 1e-3;  // cubes: faces nearer than this are two sides of one sheet
constexpr double considerable = 0.25;  // share of a part's surface
constexpr double least_held = 0.05;    // cubes: more than min_fill makes of the thinnest wall
constexpr std::size_t few = 12;        // samples that say too little of a part

bool share_corners(const Cubes& cubes, std::uint32_t a, std::uint32_t b)
{
    const auto& of_b = cubes.corners[b];
    return std::any_of(cubes.corners[a].begin(), cubes.corners[a].end(), [&](std::uint32_t k) {
        return std::find(of_b.begin(), of_b.end(), k) != of_b.end();
    });
}

// What a cell has of stiffness.
struct Held {
    double share = -1;              // negative where it has no cube
    std::uint32_t cube = no_index;  // one of its cubes
};

// Of the cubes in a cell; with `from`, of those that share corners with that cube.
Held held_by(const Cubes& cubes, const Vec3i& cell, std::uint32_t from = no_index)
{
    const auto before = [](const Vec3i& a, const Vec3i& b) {
        return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
    };
    const auto range = std::equal_range(cubes.cell.begin(), cubes.cell.end(), cell, before);
    Held out;
    for (auto at = range.first; at != range.second; ++at) {
        const auto c = static_cast<std::uint32_t>(at - cubes.cell.begin());
        if (from != no_index && !share_corners(cubes, from, c)) continue;
        out.share = std::max(out.share, 0.0) + stiffness_share(cubes, c, Weighting::filled);
        out.cube = c;
    }
    return out;
}

// The stiffness along a line across a wall; s = 0 in the middle of the wall, lengths in cubes.
struct Section {
    double s0 = 0, s1 = 0, s2 = 0;

    void add(double f, double a, double b)
    {
        if (a > b) std::swap(a, b);
        s0 += f * (b - a);
        s1 += f * (b * b - a * a) / 2;
        s2 += f * (b * b * b - a * a * a) / 3;
    }
    double variance() const { return s2 / s0 - s1 * s1 / (s0 * s0); }
};

// A line across a wall, in cubes.
struct Across {
    Vec3 middle, way;
    std::uint32_t cube = no_index;  // that holds the middle, where pieces are apart
};

// Adds what lies from the middle in one direction, up to the reach or, beyond half the thickness,
// the first cell without a cube. Where pieces are apart, cubes count that hang together with the
// one in the middle, from cell to cell.
void add_half(const Cubes& cubes, const Across& line, double sign, double half, double reach,
              Section& section)
{
    const Vec3 &middle = line.middle, d = sign * line.way;
    std::uint32_t from = line.cube;
    Vec3i cell = middle.array().floor().cast<int>();
    Vec3 next;  // where the line passes the cell's far side along each axis
    for (int k = 0; k < 3; ++k) {
        const double side = d[k] > 0 ? cell[k] + 1 : cell[k];
        next[k] = d[k] == 0 ? std::numeric_limits<double>::infinity() : (side - middle[k]) / d[k];
    }
    for (double s = 0; s < reach;) {
        int k = 0;
        const double end = std::min(next.minCoeff(&k), reach);
        const Held held = held_by(cubes, cell, from);
        if (held.share < 0 && s >= half) return;
        if (held.share > 0) section.add(held.share, sign * s, sign * end);
        if (from != no_index && held.cube != no_index) from = held.cube;
        s = end;
        cell[k] += d[k] > 0 ? 1 : -1;
        next[k] += 1 / std::abs(d[k]);
    }
}

// The stiffness along the line across a wall of thickness t (cubes), whose middle is at `middle`
// (m). `finder` where pieces are apart.
Section section_at(const Cubes& cubes, const geometry::CubeFinder* finder, const Vec3& middle,
                   const Vec3& way, double t)
{
    constexpr double smeared = 1.75;  // cubes: a cube's diagonal, and rounding
    Across line{(middle - cubes.origin) / cubes.size, way};
    if (finder) line.cube = finder->find(line.middle);
    Section section;
    for (const double sign : {-1.0, 1.0}) {
        add_half(cubes, line, sign, t / 2, t / 2 + smeared, section);
    }
    return section;
}

// How walls lie in the grid: square to an axis, or to none. Those of one part that lie otherwise
// bend in another direction, or are another wall.
constexpr std::size_t tilted = 3, lies = 4;
constexpr double straight = 2;  // degrees

struct Wall {
    std::uint32_t part = 0;
    std::size_t lie = tilted;  // 0, 1, 2: square to that axis
    Vec3 point{0, 0, 0};       // m
    double thickness = 0;      // cubes
    double factor = 0;         // 0: no cube was met
    double held = 0;           // cubes, of full stiffness along the line across it
    double excess = 1;         // share of the factor's excess over 1 that is left
    bool rolled = false;       // tilted about its long side alone, which lies along the grid
};

// How the wall lies, and what is left of its excess: cubes in steps give way in shear, so that a
// tilted wall is softer than its sections. Measured on strips and bars (bench/thin_walls.py): 0.75
// from 12 degrees on. One that is rolled about its long side has no steps along it, and all of its
// excess.
void set_lie(const Vec3& normal, Wall& wall)
{
    int axis = 0;
    const double along = std::min(normal.cwiseAbs().maxCoeff(&axis), 1.0);
    const double degrees = std::acos(along) * 180 / std::numbers::pi;
    wall.lie = degrees < straight ? static_cast<std::size_t>(axis) : tilted;
    wall.excess = wall.rolled ? 1 : std::max(0.75, 1 - 0.02 * degrees);
}

// Whether a piece is a strip or a bar that lies along an axis of the grid, by the second moments of
// its surface: those of a triangle a, b, c are area / 12 (a a' + b b' + c c' + s s'), s = a + b +
// c.
std::vector<std::uint8_t> lie_along_the_grid(const geometry::TriMesh& mesh,
                                             const geometry::Pieces& pieces)
{
    struct Moments {
        double area = 0;
        Vec3 first{0, 0, 0};
        geometry::Mat3 second = geometry::Mat3::Zero();
    };
    std::vector<Moments> all(pieces.count());
    const Vec3 middle = geometry::bounds(mesh).centre();
    for (std::size_t i = 0; i < mesh.triangles().size(); ++i) {
        if (pieces.of[i] == geometry::no_index) continue;  // it is not finite
        const auto& corners = mesh.triangles()[i];
        std::array<Vec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) {
            p[k] = mesh.positions[corners[k]].cast<double>() - middle;
        }
        const double area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm();
        const Vec3 sum = p[0] + p[1] + p[2];
        Moments& m = all[pieces.of[i]];
        m.area += area;
        m.first += area / 3 * sum;
        m.second += area / 12 * sum * sum.transpose();
        for (const Vec3& corner : p) m.second += area / 12 * corner * corner.transpose();
    }
    constexpr double longer = 1.5;  // times than wide
    std::vector<std::uint8_t> out(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) {
        const Moments& m = all[i];
        if (!(m.area > 0)) continue;
        const geometry::Mat3 spread = m.second - m.first * m.first.transpose() / m.area;
        const Eigen::SelfAdjointEigenSolver<geometry::Mat3> axes(spread);
        const Vec3 along = axes.eigenvectors().col(2).cwiseAbs();
        const double degrees = std::acos(std::min(along.maxCoeff(), 1.0)) * 180 / std::numbers::pi;
        out[i] =
            axes.eigenvalues()[2] > longer * longer * axes.eigenvalues()[1] && degrees < straight;
    }
    return out;
}

// Groups are parts where there are several; else pieces are.
bool by_group(const geometry::TriMesh& mesh)
{
    return mesh.topology->groups.size() > 1 &&
           mesh.topology->group.size() == mesh.triangles().size();
}

std::string part_name(const geometry::TriMesh& mesh, std::size_t pieces, std::uint32_t part)
{
    if (by_group(mesh)) return "'" + mesh.topology->groups[part] + "'";
    return pieces > 1 ? "piece " + std::to_string(part + 1) : std::string();
}

// Whether the model is filled from 1.75 to 11.25 cubes below the surface on either side, so that no
// wall is thin there.
bool thick(const Cubes& cubes, const geometry::WallSample& sample)
{
    const Vec3 at = (sample.point - cubes.origin) / cubes.size;
    for (const double sign : {-1.0, 1.0}) {
        bool full = true;
        for (double depth = 1.75; full && depth < thin_below - 0.5; depth += 9.5 / 11) {
            const Vec3 p = at + sign * depth * sample.inward;
            full = held_by(cubes, p.array().floor().cast<int>()).share > 0.999;
        }
        if (full) return true;
    }
    return false;
}

// Samples of the surface; none where no wall is thin.
std::vector<geometry::WallSample> candidates(const geometry::TriMesh& mesh, const Cubes& cubes)
{
    std::vector<geometry::WallSample> samples = geometry::wall_points(mesh, sample_count);
    std::vector<std::uint8_t> thin(samples.size());
    geometry::parallel_for(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) thin[i] = thick(cubes, samples[i]) ? 0 : 1;
    });
    if (std::find(thin.begin(), thin.end(), 1) == thin.end()) samples.clear();
    return samples;
}

// The wall at one sample; its factor stays 0 where it is not thin.
Wall wall_at(const Cubes& cubes, const geometry::CubeFinder* finder, const geometry::WallSample& s,
             const WallOptions& options, bool along)
{
    Wall wall;
    wall.rolled = along;
    const bool found = std::isfinite(s.thickness);
    const double t = found ? s.thickness : options.thickness;
    if (!(t > 0) || t > thin_below * cubes.size) return wall;
    wall.thickness = t / cubes.size;
    set_lie(s.inward, wall);
    const Vec3 middle = found ? Vec3(s.point + 0.5 * t * s.inward) : s.point;
    const Section section = section_at(cubes, finder, middle, s.inward, wall.thickness);
    if (!(section.s0 > 0)) return wall;
    // Between the faces of a hollow is less matter than half of a wall there would be.
    if (wall.thickness > 1 && section.s0 < 0.5 * wall.thickness) return wall;
    const bool shared = wall.thickness > alone_below && section.s0 > wall.thickness + 0.5;
    if (shared) return wall;
    wall.held = section.s0;
    wall.factor = 12 * section.variance() / (wall.thickness * wall.thickness);
    return wall;
}

std::vector<Wall> walls_of(const geometry::TriMesh& mesh, const geometry::Pieces& pieces,
                           const Cubes& cubes, const WallOptions& options,
                           std::vector<geometry::WallSample> samples)
{
    if (options.solid) {
        geometry::find_thickness(mesh, pieces, thinnest * cubes.size, thin_below * cubes.size,
                                 samples);
    }
    const bool groups = by_group(mesh);
    std::optional<geometry::CubeFinder> finder;
    if (!cubes.part.empty()) finder.emplace(cubes);
    const std::vector<std::uint8_t> along = lie_along_the_grid(mesh, pieces);
    std::vector<Wall> walls(samples.size());
    geometry::parallel_for(samples.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const geometry::WallSample& s = samples[i];
            const std::uint32_t piece = pieces.of[s.triangle];
            const bool hollow = !options.solid && pieces.encloses[piece] != 0;
            if (!hollow) {
                walls[i] =
                    wall_at(cubes, finder ? &*finder : nullptr, s, options, along[piece] != 0);
            }
            walls[i].point = s.point;
            walls[i].part = groups ? mesh.topology->group[s.triangle] : piece;
        }
    });
    return walls;
}

// What some walls of one part say together.
ThinPart together(std::vector<Wall> thin, std::size_t all, double size)
{
    std::sort(thin.begin(), thin.end(),
              [](const Wall& a, const Wall& b) { return a.thickness < b.thickness; });
    const double median = thin[thin.size() / 2].thickness;
    double inverse = 0, sum = 0, rolled = 0, excess = 0, count = 0, held = 0, own = 0;
    geometry::Box around;
    for (const Wall& w : thin) {
        around.add(w.point);
        if (w.thickness > 1.5 * median || w.thickness < median / 1.5) continue;
        inverse += 1 / w.factor;
        sum += w.factor;
        rolled += w.rolled ? 1 : 0;
        excess += w.excess;
        count += 1;
        held += w.held;
        own += std::max(w.thickness, least_held);
    }
    ThinPart part;
    // A wall that stands alone holds its thickness or less. This one shares cubes with other
    // matter.
    if (held > 1.25 * own) return part;
    part.thickness = median * size;
    part.where = thin[thin.size() / 2].point;
    part.share = static_cast<double>(thin.size()) / static_cast<double>(all);
    // The sections along a strip bend in series, those across one that is rolled side by side. Of
    // cubes as thick as the wall, these slide on each other.
    const double series = count / inverse, beside = sum / count;
    const double across = median < 1.5 ? std::sqrt(series * beside) : beside;
    const double mean = rolled > 0.5 * count ? across : series;
    part.slenderness = (around.hi - around.lo).norm() / part.thickness;
    part.factor = 1 + (excess / count) * (mean - 1);
    return part;
}

}  // namespace

std::vector<ThinPart> thin_parts(const geometry::TriMesh& mesh, const Cubes& cubes,
                                 const WallOptions& options)
{
    if (!options.solid && !(options.thickness > 0)) return {};
    std::vector<geometry::WallSample> samples = candidates(mesh, cubes);
    if (samples.empty()) return {};
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    std::map<std::uint32_t, std::size_t> all;
    std::map<std::uint32_t, std::array<std::vector<Wall>, lies>> thin;
    for (const Wall& w : walls_of(mesh, pieces, cubes, options, std::move(samples))) {
        ++all[w.part];
        if (w.factor > 0) thin[w.part][w.lie].push_back(w);
    }
    std::vector<ThinPart> parts;
    for (auto& [number, by_lie] : thin) {
        const std::size_t of_part = all[number];
        ThinPart worst;
        worst.factor = 0;
        for (std::vector<Wall>& walls : by_lie) {
            if (of_part < few || double(walls.size()) < considerable * double(of_part)) continue;
            const ThinPart part = together(std::move(walls), of_part, cubes.size);
            if (part.thickness > 0 && part.factor > worst.factor) worst = part;
        }
        if (!(worst.thickness > 0)) continue;
        worst.factor = std::max(worst.factor, 1.0);
        worst.name = part_name(mesh, pieces.count(), number);
        parts.push_back(worst);
    }
    std::stable_sort(parts.begin(), parts.end(),
                     [](const ThinPart& a, const ThinPart& b) { return a.factor > b.factor; });
    return parts;
}

std::optional<ThinPart> thinnest_wall(const geometry::TriMesh& mesh)
{
    const geometry::Pieces pieces = geometry::find_pieces(mesh);
    std::vector<geometry::WallSample> samples = geometry::wall_points(mesh, sample_count);
    std::erase_if(samples, [&](const geometry::WallSample& s) {
        return pieces.encloses[pieces.of[s.triangle]] == 0;
    });
    const geometry::Box box = geometry::bounds(mesh);
    const double across = box.empty() ? 0 : (box.hi - box.lo).norm();
    geometry::find_thickness(mesh, pieces, thinnest / 32 * across, across, samples);
    std::map<std::uint32_t, std::vector<geometry::WallSample>> parts;
    const bool groups = by_group(mesh);
    for (const geometry::WallSample& s : samples) {
        parts[groups ? mesh.topology->group[s.triangle] : pieces.of[s.triangle]].push_back(s);
    }
    std::optional<ThinPart> least;
    const bool some_large = std::any_of(parts.begin(), parts.end(),
                                        [](const auto& part) { return part.second.size() >= few; });
    for (auto& [number, walls] : parts) {
        if (some_large && walls.size() < few) continue;
        const auto middle =
            walls.begin() + static_cast<std::ptrdiff_t>(considerable / 2 * double(walls.size()));
        std::nth_element(walls.begin(), middle, walls.end(),
                         [](const auto& a, const auto& b) { return a.thickness < b.thickness; });
        if (!std::isfinite(middle->thickness)) continue;
        if (least && least->thickness <= middle->thickness) continue;
        least = ThinPart{part_name(mesh, pieces.count(), number), middle->thickness, middle->point};
    }
    return least;
}

double size_for_wall(double thickness)
{
    const double size = thickness / 4, digit = std::pow(10, std::floor(std::log10(size)) - 1);
    return std::floor(size / digit * (1 + 1e-5)) * digit;  // positions are floats
}

}  // namespace physics

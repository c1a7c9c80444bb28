#include "geometry/mesh/polygons.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <tuple>

namespace geometry {
namespace {

// The end of the polygon that begins at triangle `begin`.
std::size_t end_of(const std::vector<std::uint32_t>& polygon, std::size_t begin)
{
    std::size_t end = begin + 1;
    while (end < polygon.size() && polygon[end] == polygon[begin]) ++end;
    return end;
}

// Whether the triangles of a list look the same; also where it is empty.
template <class T> bool is_same(const std::vector<T>& of, std::size_t begin, std::size_t end)
{
    for (std::size_t f = begin + 1; f < end && f < of.size(); ++f) {
        if (of[f] != of[begin]) return false;
    }
    return true;
}

class OutlineFinder {
public:
    explicit OutlineFinder(const MeshTopology& topology) : topology_(topology) {}

    // Adds the outline of triangles begin .. end to `out`; false, with nothing added, where they
    // are no polygon.
    bool add(std::size_t begin, std::size_t end, std::vector<std::uint32_t>& out)
    {
        if (!is_same(topology_.material, begin, end) || !is_same(topology_.group, begin, end)) {
            return false;
        }
        sides_.clear();
        for (std::size_t f = begin; f < end; ++f) {
            const Triangle& t = topology_.triangles[f];
            for (std::size_t k = 0; k < 3; ++k) {
                sides_.push_back(
                    {t[k], t[(k + 1) % 3], static_cast<std::uint32_t>(3 * f + k), false});
            }
        }
        return has_one_uv_a_corner() && keep_border(end - begin) && walk(begin, end, out);
    }

private:
    struct Side {
        std::uint32_t from, to, corner;
        bool cancels;
    };

    Triangle uv_triangle(std::uint32_t corner) const { return topology_.uv_triangles[corner / 3]; }

    bool has_one_uv_a_corner()
    {
        std::sort(sides_.begin(), sides_.end(), [](const Side& a, const Side& b) {
            return std::tie(a.from, a.corner) < std::tie(b.from, b.corner);
        });
        if (topology_.uv_triangles.size() != topology_.triangles.size()) return true;
        const auto differs = [&](const Side& a, const Side& b) {
            return a.from == b.from &&
                   uv_triangle(a.corner)[a.corner % 3] != uv_triangle(b.corner)[b.corner % 3];
        };
        return std::adjacent_find(sides_.begin(), sides_.end(), differs) == sides_.end();
    }

    // sides_: those of the border, by their first vertices. False unless each vertex has one.
    bool keep_border(std::size_t triangles)
    {
        const auto by_ends = [](const Side& a, const Side& b) {
            const auto key = [](const Side& s) {
                return std::tuple(std::min(s.from, s.to), std::max(s.from, s.to), s.from, s.corner);
            };
            return key(a) < key(b);
        };
        std::sort(sides_.begin(), sides_.end(), by_ends);
        for (std::size_t i = 1; i < sides_.size(); ++i) {
            Side &a = sides_[i - 1], &b = sides_[i];
            if (a.from == b.from && a.to == b.to) return false;
            if (a.from == b.to && a.to == b.from) a.cancels = b.cancels = true;
        }
        std::erase_if(sides_, [](const Side& s) { return s.cancels; });
        if (sides_.size() != triangles + 2) return false;
        const auto by_first = [](const Side& a, const Side& b) { return a.from < b.from; };
        std::sort(sides_.begin(), sides_.end(), by_first);
        const auto same = [](const Side& a, const Side& b) { return a.from == b.from; };
        return std::adjacent_find(sides_.begin(), sides_.end(), same) == sides_.end();
    }

    // Where triangulate() began: it cuts a fan from its first corner and, of other polygons, the
    // ear at the first corner that is one.
    std::uint32_t first_vertex(std::size_t begin, std::size_t end) const
    {
        const auto& triangles = topology_.triangles;
        const Triangle& first = triangles[begin];
        const bool fan = std::all_of(triangles.begin() + std::ptrdiff_t(begin),
                                     triangles.begin() + std::ptrdiff_t(end),
                                     [&](const Triangle& t) { return t[0] == first[0]; });
        return fan ? first[0] : first[1];
    }

    bool walk(std::size_t begin, std::size_t end, std::vector<std::uint32_t>& out) const
    {
        const std::uint32_t start = first_vertex(begin, end);
        const std::size_t before = out.size();
        std::uint32_t at = start;
        for (std::size_t i = 0; i < sides_.size(); ++i) {
            const auto side =
                std::lower_bound(sides_.begin(), sides_.end(), at,
                                 [](const Side& s, std::uint32_t v) { return s.from < v; });
            const bool found = side != sides_.end() && side->from == at;
            if (!found || (i > 0 && at == start)) {  // it parts, or closes too soon
                out.resize(before);
                return false;
            }
            out.push_back(first_corner(at, begin, side->corner));
            at = side->to;
        }
        if (at == start) return true;
        out.resize(before);
        return false;
    }

    // Of the corners at a vertex, that of the first triangle where it has it.
    std::uint32_t first_corner(std::uint32_t vertex, std::size_t begin, std::uint32_t other) const
    {
        const Triangle& first = topology_.triangles[begin];
        for (std::size_t k = 0; k < 3; ++k) {
            if (first[k] == vertex) return static_cast<std::uint32_t>(3 * begin + k);
        }
        return other;
    }

    const MeshTopology& topology_;
    std::vector<Side> sides_;
};

}  // namespace

void add_polygon(std::vector<std::uint32_t>& polygon, std::size_t triangles)
{
    const std::uint32_t number = polygon.empty() ? 0 : polygon.back() + 1;
    polygon.insert(polygon.end(), triangles, number);
}

bool has_triangles_only(const std::vector<std::uint32_t>& polygon)
{
    return polygon.empty() || std::size_t{polygon.back()} + 1 == polygon.size();
}

std::vector<std::uint32_t> polygons_left(const std::vector<std::uint32_t>& polygon,
                                         std::span<const std::uint8_t> gone)
{
    std::vector<std::uint32_t> left;
    if (polygon.size() != gone.size()) return left;
    for (std::size_t begin = 0, end = 0; begin < polygon.size(); begin = end) {
        end = end_of(polygon, begin);
        const auto lost = static_cast<std::size_t>(
            std::count_if(gone.begin() + std::ptrdiff_t(begin), gone.begin() + std::ptrdiff_t(end),
                          [](std::uint8_t is_gone) { return is_gone != 0; }));
        if (lost == 0) {
            add_polygon(left, end - begin);
        } else {
            for (std::size_t f = begin + lost; f < end; ++f) add_polygon(left, 1);
        }
    }
    if (has_triangles_only(left)) left.clear();
    return left;
}

std::size_t Outlines::most_corners() const
{
    std::size_t most = 0;
    for (std::size_t p = 0; p < count(); ++p) most = std::max(most, (*this)[p].size());
    return most;
}

Outlines outlines(const MeshTopology& topology)
{
    const std::size_t triangles = topology.triangles.size();
    const bool some = topology.polygon.size() == triangles;
    Outlines out;
    out.begin.reserve((some && triangles > 0 ? topology.polygon.back() + 1 : triangles) + 1);
    out.corner.reserve(3 * triangles);
    OutlineFinder finder(topology);
    StopCheck check;
    const auto end_polygon = [&] {
        out.begin.push_back(static_cast<std::uint32_t>(out.corner.size()));
    };
    for (std::size_t begin = 0, end = 0; begin < triangles; begin = end) {
        check();
        end = some ? end_of(topology.polygon, begin) : begin + 1;
        if (end > begin + 1 && finder.add(begin, end, out.corner)) {
            end_polygon();
            continue;
        }
        for (std::size_t f = begin; f < end; ++f) {
            for (std::size_t k = 0; k < 3; ++k) {
                out.corner.push_back(static_cast<std::uint32_t>(3 * f + k));
            }
            end_polygon();
        }
    }
    return out;
}

}  // namespace geometry

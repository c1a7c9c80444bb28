#include "physics/bricks/coarse_transfer.hpp"

#include "geometry/base/parallel.hpp"

#include <algorithm>

namespace physics {
namespace {

using Eigen::Vector4f;
using geometry::Vec3i;

constexpr std::size_t cells_a_run = 64, nodes_a_run = 128;

// A motion, t and w, or a force and its moment. The fourth numbers are 0.
struct Six {
    Vector4f t = Vector4f::Zero(), w = Vector4f::Zero();

    static Six load(const float* six)
    {
        return {{six[0], six[1], six[2], 0}, {six[3], six[4], six[5], 0}};
    }
    void store(float* six) const
    {
        std::copy_n(t.data(), 3, six);
        std::copy_n(w.data(), 3, six + 3);
    }
    void add(float by, const Six& other)
    {
        t += by * other.t;
        w += by * other.w;
    }
};

// Of nodes, bit 0 of the number: x, or of monomials.
using EightSix = std::array<Six, 8>;

Vector4f at_node(unsigned a)
{
    return {float(a & 1), float(a >> 1 & 1), float(a >> 2 & 1), 0};
}

// x^i y^j z^k at a place on the line (y, z), for x^i = 1.
std::array<float, 4> on_line(float y, float z)
{
    return {1, y, z, y * z};
}

// e_x cross v, and v cross e_x.
Vector4f x_cross(const Vector4f& v)
{
    return {0, -v[2], v[1], 0};
}
Vector4f cross_x(const Vector4f& v)
{
    return {0, v[2], -v[1], 0};
}

// Visits the corners of a coarse cell that lie on a line along x: visit(y, z, corners).
template <class Visit>
void for_lines(const CoarseGrid& grid, std::size_t c, std::span<const Vec3i> corner,
               const Visit& visit)
{
    const float unit = 1 / static_cast<float>(grid.ratio);
    const auto all = grid.corners.of(c);
    for (std::size_t i = 0, end = 0; i < all.size(); i = end) {
        const Vec3i& first = corner[all[i]];
        for (end = i + 1; end < all.size(); ++end) {
            const Vec3i& next = corner[all[end]];
            if (next.y() != first.y() || next.z() != first.z()) break;
        }
        const Vec3i place = place_in_cell(first, grid.cell[c], grid.ratio);
        visit(unit * float(place.y()), unit * float(place.z()), all.subspan(i, end - i));
    }
}

// Sums of forces, and of x and x^2 times them, and of moments, along a line.
struct LineMoments {
    std::array<Vector4f, 3> force{Vector4f::Zero(), Vector4f::Zero(), Vector4f::Zero()};
    std::array<Vector4f, 2> moment{Vector4f::Zero(), Vector4f::Zero()};

    void add(float x, const Vector4f& f)
    {
        const Vector4f xf = x * f;
        force[0] += f;
        force[1] += xf;
        force[2] += x * xf;
    }
    void add(float x, const Six& s)
    {
        add(x, s.t);
        moment[0] += s.w;
        moment[1] += x * s.w;
    }
    void add_to(float y, float z, EightSix& sum) const
    {
        const auto weight = on_line(y, z);
        const Vector4f arm(0, y, z, 0);
        for (std::size_t i = 0; i < 2; ++i) {
            const Six of_line{force[i], arm.cross3(force[i]) + x_cross(force[i + 1]) + moment[i]};
            for (std::size_t m = 0; m < 4; ++m) sum[i + 2 * m].add(weight[m], of_line);
        }
    }
};

// Of monomials to nodes: the transpose of to_monomials().
void to_nodes(EightSix& sum)
{
    for (unsigned bit = 1; bit < 8; bit *= 2) {
        for (unsigned a = 0; a < 8; ++a) {
            if ((a & bit) == 0) sum[a].add(-1, sum[a | bit]);
        }
    }
    for (unsigned a = 1; a < 8; ++a) sum[a].w -= at_node(a).cross3(sum[a].t);
}

void to_monomials(EightSix& nodes)
{
    for (unsigned a = 1; a < 8; ++a) nodes[a].t -= nodes[a].w.cross3(at_node(a));
    for (unsigned bit = 1; bit < 8; bit *= 2) {
        for (unsigned a = 0; a < 8; ++a) {
            if ((a & bit) != 0) nodes[a].add(-1, nodes[a ^ bit]);
        }
    }
}

// What moves the corners of a line: t = c[0] + x c[1] + x^2 c[2], w = b[0] + x b[1].
struct LineMotion {
    std::array<Vector4f, 3> c;
    std::array<Vector4f, 2> b;

    LineMotion(const EightSix& monomials, float y, float z)
    {
        const auto weight = on_line(y, z);
        const Vector4f arm(0, y, z, 0);
        std::array<Six, 2> sum;
        for (std::size_t i = 0; i < 2; ++i) {
            for (std::size_t m = 0; m < 4; ++m) sum[i].add(weight[m], monomials[i + 2 * m]);
            b[i] = sum[i].w;
        }
        c[0] = sum[0].t + b[0].cross3(arm);
        c[1] = sum[1].t + b[1].cross3(arm) + cross_x(b[0]);
        c[2] = cross_x(b[1]);
    }
    Vector4f t(float x) const { return c[0] + x * (c[1] + x * c[2]); }
    Vector4f w(float x) const { return b[0] + x * b[1]; }
};

// by_node = P^T of forces on corners: read(k) gives them, Vector4f or Six.
template <class Read>
void restrict_to(const CoarseGrid& grid, std::span<const Vec3i> corner, const Read& read,
                 Aligned<float>& by_cell, Aligned<float>& by_node)
{
    const float unit = 1 / static_cast<float>(grid.ratio);
    by_cell.resize(48 * grid.cell.size());
    geometry::parallel_for(grid.cell.size(), cells_a_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            EightSix sum{};
            const int first = grid.ratio * grid.cell[c].x();
            for_lines(grid, c, corner, [&](float y, float z, std::span<const std::uint32_t> line) {
                LineMoments moments;
                for (const auto k : line) {
                    moments.add(unit * float(corner[k].x() - first), read(k));
                }
                moments.add_to(y, z, sum);
            });
            to_nodes(sum);
            for (std::size_t a = 0; a < 8; ++a) sum[a].store(&by_cell[48 * c + 6 * a]);
        }
    });
    by_node.resize(6 * grid.node.size());
    geometry::parallel_for(grid.node.size(), nodes_a_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            float sum[6] = {};
            for (const auto share : grid.shares.of(n)) {
                for (std::size_t i = 0; i < 6; ++i) sum[i] += by_cell[6 * std::size_t{share} + i];
            }
            std::copy(sum, sum + 6, &by_node[6 * n]);
        }
    });
}

// move(k, x, line) of each corner, with how its line moves.
template <class Move>
void prolong(const CoarseGrid& grid, std::span<const Vec3i> corner, const float* by_node,
             const Move& move)
{
    const float unit = 1 / static_cast<float>(grid.ratio);
    geometry::parallel_for(grid.cell.size(), cells_a_run, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            EightSix nodes;
            for (std::size_t a = 0; a < 8; ++a) {
                nodes[a] = Six::load(by_node + 6 * std::size_t{grid.nodes[c][a]});
            }
            to_monomials(nodes);
            const int first = grid.ratio * grid.cell[c].x();
            for_lines(grid, c, corner, [&](float y, float z, std::span<const std::uint32_t> line) {
                const LineMotion motion(nodes, y, z);
                for (const auto k : line) move(k, unit * float(corner[k].x() - first), motion);
            });
        }
    });
}

Eigen::Map<const Vector4f> four(const float* at)
{
    return Eigen::Map<const Vector4f>(at);
}

}  // namespace

void restrict_corners(const CoarseGrid& grid, std::span<const Vec3i> corner, const float* r,
                      const std::uint32_t* slot, CornerTurns turns, Aligned<float>& by_cell,
                      Aligned<float>& by_node)
{
    const auto force = [&](std::uint32_t k) { return four(r + 4 * std::size_t{slot[k]}); };
    if (!turns) return restrict_to(grid, corner, force, by_cell, by_node);
    const auto turned_back = [&](std::uint32_t k) -> Vector4f {
        const float* const row = turns + 12 * std::size_t{k};
        const float* const f = r + 4 * std::size_t{slot[k]};
        return f[0] * four(row) + f[1] * four(row + 4) + f[2] * four(row + 8);
    };
    restrict_to(grid, corner, turned_back, by_cell, by_node);
}

void prolong_corners(const CoarseGrid& grid, std::span<const Vec3i> corner, const float* by_node,
                     const std::uint32_t* slot, CornerTurns turns, float* z)
{
    if (!turns) {
        prolong(grid, corner, by_node, [&](std::uint32_t k, float x, const LineMotion& line) {
            Eigen::Map<Vector4f>(z + 4 * std::size_t{slot[k]}) += line.t(x);
        });
        return;
    }
    prolong(grid, corner, by_node, [&](std::uint32_t k, float x, const LineMotion& line) {
        const float* const row = turns + 12 * std::size_t{k};
        float* const to = z + 4 * std::size_t{slot[k]};
        const Vector4f t = line.t(x);
        for (std::size_t i = 0; i < 3; ++i) to[i] += four(row + 4 * i).dot(t);
    });
}

void restrict_nodes(const CoarseGrid& grid, std::span<const Vec3i> node, const float* r,
                    Aligned<float>& by_cell, Aligned<float>& by_node)
{
    const float unit = 1 / static_cast<float>(grid.ratio);
    const auto read = [&](std::uint32_t k) {
        Six out = Six::load(r + 6 * std::size_t{k});
        out.w *= unit;
        return out;
    };
    restrict_to(grid, node, read, by_cell, by_node);
}

void prolong_nodes(const CoarseGrid& grid, std::span<const Vec3i> node, const float* by_node,
                   float* d, float* z)
{
    const float unit = 1 / static_cast<float>(grid.ratio);
    prolong(grid, node, by_node, [&](std::uint32_t k, float x, const LineMotion& line) {
        const std::size_t at = 6 * std::size_t{k};
        Six{line.t(x), unit * line.w(x)}.store(d + at);
        for (std::size_t i = at; i < at + 6; ++i) z[i] += d[i];
    });
}

}  // namespace physics

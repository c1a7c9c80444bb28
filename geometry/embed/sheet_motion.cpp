#include "geometry/embed/sheet_motion.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/cubes/sheet.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace geometry {
namespace {

constexpr std::size_t sheet_task = 4096;
// A triangle has collapsed whose height is less than this share of a side: what rounding leaves of
// one that has none is far below.
constexpr double collapsed_height = 1e-9;

// Two sides of a triangle and its unit normal, column by column.
std::optional<Mat3> frame_of(const Vec3& a, const Vec3& b, const Vec3& c)
{
    const Vec3 u = b - a, v = c - a, normal = u.cross(v);
    const double twice_area = normal.norm();
    const bool stands = twice_area > collapsed_height * std::max(u.squaredNorm(), v.squaredNorm());
    if (!stands || !std::isfinite(twice_area)) return std::nullopt;
    Mat3 out;
    out << u, v, normal / twice_area;
    return out;
}

// D = F - I, which is 0 at rest to the last bit, summed by weights.
struct Weighed {
    Mat3 sum = Mat3::Zero();
    double weight = 0;

    bool is_gap() const { return !(weight > 0); }
    Mat3 mean() const { return sum / weight; }
    void add(const Mat3& D, double by)
    {
        sum += by * D;
        weight += by;
    }
};

Weighed gradient_of_triangle(const Cubes& sheet, std::span<const Vec3> x, std::size_t cell)
{
    const auto [a, b, c] = sheet_triangle(sheet, cell);
    const std::optional<Mat3> before = frame_of(sheet.place[a], sheet.place[b], sheet.place[c]);
    const std::optional<Mat3> now = frame_of(x[a], x[b], x[c]);
    if (!before || !now) return {};
    Weighed out;
    out.add((*now - *before) * before->inverse(), cell_area(sheet, cell));
    return out;
}

// Gives corners at which all triangles have collapsed the mean of the others of these triangles.
void fill_gaps(const Cubes& sheet, std::vector<Weighed>& at)
{
    if (std::none_of(at.begin(), at.end(), [](const Weighed& w) { return w.is_gap(); })) return;
    std::vector<Weighed> filled(at.size());
    for (std::size_t cell = 0; cell < sheet.count(); ++cell) {
        const auto triangle = sheet_triangle(sheet, cell);
        for (const auto k : triangle) {
            if (!at[k].is_gap()) continue;
            for (const auto other : triangle) {
                if (!at[other].is_gap()) filled[k].add(at[other].mean(), 1);
            }
        }
    }
    for (std::size_t k = 0; k < at.size(); ++k) {
        if (at[k].is_gap()) at[k] = filled[k];
    }
}

// F_i - I. K.
std::vector<Mat3> gradients_at_corners(const Cubes& sheet, std::span<const Vec3> x)
{
    std::vector<Weighed> of(sheet.count());
    parallel_for(of.size(), sheet_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) of[c] = gradient_of_triangle(sheet, x, c);
    });
    std::vector<Weighed> at(sheet.corner_count());
    for (std::size_t c = 0; c < of.size(); ++c) {
        if (of[c].is_gap()) continue;
        for (const auto k : sheet_triangle(sheet, c)) {
            at[k].sum += of[c].sum;
            at[k].weight += of[c].weight;
        }
    }
    fill_gaps(sheet, at);
    std::vector<Mat3> out(at.size(), Mat3::Zero());
    for (std::size_t k = 0; k < out.size(); ++k) {
        if (!at[k].is_gap()) out[k] = at[k].mean();
    }
    return out;
}

// A vertex's place on the sheet: the corners of its triangle, and their shares of it.
struct OnSheet {
    std::array<std::uint32_t, 3> corner;
    std::array<double, 3> share;

    OnSheet(const Binding& binding, const Cubes& sheet, std::size_t v)
        : corner(sheet_triangle(sheet, binding.used[binding.cube[v]]))
    {
        const double s = double(binding.local[v].x()), t = double(binding.local[v].y());
        share = {(1 - t) * (1 - s), (1 - t) * s, t};
    }

    Vec3 mean(std::span<const Vec3> at) const
    {
        return share[0] * at[corner[0]] + share[1] * at[corner[1]] + share[2] * at[corner[2]];
    }

    Mat3 mean(std::span<const Mat3> at) const
    {
        return share[0] * at[corner[0]] + share[1] * at[corner[1]] + share[2] * at[corner[2]];
    }
};

// cof(F) n to unit length; n where that is nothing.
Vec3f turned_by(const Mat3& F, const Vec3f& n)
{
    const Vec3 to = double(n.x()) * F.col(1).cross(F.col(2)) +
                    double(n.y()) * F.col(2).cross(F.col(0)) +
                    double(n.z()) * F.col(0).cross(F.col(1));
    const double length = to.norm();
    return length > 1e-12 && std::isfinite(length) ? Vec3f((to / length).cast<float>()) : n;
}

}  // namespace

void carry_with_sheet(const Binding& binding, const TriMesh& rest, const Cubes& sheet,
                      std::span<const Vec3> x, TriMesh& out)
{
    const std::vector<Mat3> gradient = gradients_at_corners(sheet, x);
    parallel_for(rest.positions.size(), sheet_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const OnSheet on(binding, sheet, v);
            const Vec3 X = rest.positions[v].cast<double>(), B = on.mean(sheet.place);
            const Vec3 off = X.allFinite() ? Vec3(X - B) : Vec3(Vec3::Zero());
            const Vec3 u = on.mean(x) - B + on.mean(gradient) * off;
            out.positions[v] = (X + u).cast<float>();
        }
    });
    parallel_for(rest.normals.size(), sheet_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t n = begin; n < end; ++n) {
            const std::uint32_t v = binding.normal_vertex[n];
            out.normals[n] = rest.normals[n];
            if (v >= binding.cube.size()) continue;
            const Mat3 F = Mat3::Identity() + OnSheet(binding, sheet, v).mean(gradient);
            out.normals[n] = turned_by(F, rest.normals[n]);
        }
    });
}

}  // namespace geometry

#include "physics/bricks/coarse_energy.hpp"

#include <algorithm>

namespace physics {
namespace {

using Eigen::Index;
using geometry::Mat3;
using geometry::Vec3;
using geometry::Vec3i;

Vec3i bits_of(unsigned a)
{
    return {int(a & 1), int(a >> 1 & 1), int(a >> 2 & 1)};
}

// The matrix of w -> w x d.
Mat3 turn_by(const Vec3& d)
{
    Mat3 m;
    m << 0, d.z(), -d.y(), -d.z(), 0, d.x(), d.y(), -d.x(), 0;
    return m;
}

double weight_at(const Vec3i& place, unsigned node, int ratio)
{
    double weight = 1;
    for (int i = 0; i < 3; ++i) {
        const double s = double(place[i]) / ratio;
        weight *= node >> i & 1 ? s : 1 - s;
    }
    return weight;
}

template <class Each> void for_each_place(int end, const Each& each)
{
    for (int z = 0; z < end; ++z)
        for (int y = 0; y < end; ++y)
            for (int x = 0; x < end; ++x) each(Vec3i(x, y, z));
}

Eigen::Matrix<double, 24, 48> cube_motion(const Vec3i& place, int ratio)
{
    Eigen::Matrix<double, 24, 48> q;
    for (unsigned a = 0; a < 8; ++a) {
        q.middleRows<3>(3 * Index(a)) = corner_motion(place + bits_of(a), ratio);
    }
    return q;
}

// energy = C^T energy C, C block diagonal over the nodes: t += turn_by(at(node)) w, w *= scale.
template <class At> void move_origin(CellMatrix& energy, double scale, const At& at)
{
    for (unsigned j = 0; j < 8; ++j) {
        const Mat3 turn = turn_by(at(j));
        auto columns = energy.middleCols<6>(6 * Index(j));
        columns.rightCols<3>() =
            (scale * columns.rightCols<3>() + columns.leftCols<3>() * turn).eval();
    }
    for (unsigned j = 0; j < 8; ++j) {
        const Mat3 turn = turn_by(at(j));
        auto rows = energy.middleRows<6>(6 * Index(j));
        rows.bottomRows<3>() =
            (scale * rows.bottomRows<3>() + turn.transpose() * rows.topRows<3>()).eval();
    }
}

// energy = N^T energy N along one axis: low and high nodes lie at shares s and e of the cell.
void spread_along(int axis, double s, double e, CellMatrix& energy)
{
    for (unsigned j = 0; j < 8; ++j) {
        const unsigned k = j | 1u << axis;
        if (j == k) continue;
        auto low = energy.middleCols<6>(6 * Index(j)), high = energy.middleCols<6>(6 * Index(k));
        const Eigen::Matrix<double, 48, 6> sum = (1 - s) * low + (1 - e) * high;
        high = (s * low + e * high).eval();
        low = sum;
    }
    for (unsigned j = 0; j < 8; ++j) {
        const unsigned k = j | 1u << axis;
        if (j == k) continue;
        auto low = energy.middleRows<6>(6 * Index(j)), high = energy.middleRows<6>(6 * Index(k));
        const Eigen::Matrix<double, 6, 48> sum = (1 - s) * low + (1 - e) * high;
        high = (s * low + e * high).eval();
        low = sum;
    }
}

}  // namespace

Eigen::Matrix<double, 3, 48> corner_motion(const Vec3i& place, int ratio)
{
    Eigen::Matrix<double, 3, 48> q;
    for (unsigned j = 0; j < 8; ++j) {
        const double weight = weight_at(place, j, ratio);
        const Vec3 from = place.cast<double>() / ratio - bits_of(j).cast<double>();
        q.middleCols<3>(6 * Index(j)) = weight * Mat3::Identity();
        q.middleCols<3>(6 * Index(j) + 3) = weight * turn_by(from);
    }
    return q;
}

CubeEnergies::CubeEnergies(int ratio, const CubeMatrices& cubes) : ratio_(ratio), cubes_(cubes)
{
    for (auto& full : full_) full.setZero();
    full_corners_.setZero();
    for_each_place(ratio, [&](const Vec3i& place) {
        const auto q = cube_motion(place, ratio);
        std::array<CellMatrix, 3> cube;
        for (std::size_t i = 0; i < 3; ++i) {
            cube[i] = q.transpose() * cubes.parts[i] * q;
            full_[i] += cube[i];
        }
        cube_.push_back(cube);
    });
    for_each_place(ratio + 1, [&](const Vec3i& place) {
        const auto q = corner_motion(place, ratio);
        corner_.emplace_back(q.transpose() * q);
        if (place.maxCoeff() < ratio) full_corners_ += corner_.back();
    });
}

std::size_t CubeEnergies::cube_at(const Vec3i& place) const
{
    return std::size_t((place.z() * ratio_ + place.y()) * ratio_ + place.x());
}

std::size_t CubeEnergies::corner_at(const Vec3i& place) const
{
    const int edge = ratio_ + 1;
    return std::size_t((place.z() * edge + place.y()) * edge + place.x());
}

// Cells that are full of equal cubes need no sum over them: false where this one is not.
bool CubeEnergies::add_full_cell(const GridView& fine, const CoarseGrid& grid, std::size_t c,
                                 std::span<const double> diagonal, CellMatrix& sum) const
{
    const auto cubes = grid.cells.of(c), corners = grid.corners.of(c);
    const auto all = static_cast<std::size_t>(ratio_ * ratio_ * ratio_);
    if (cubes.size() != all || corners.size() != all) return false;
    const auto& weight = cubes_.weights[cubes[0]];
    const double own = diagonal[corners[0]];
    for (const auto cube : cubes) {
        if (cubes_.weights[cube] != weight || !cubes_.is_shared(cube)) return false;
    }
    for (const auto k : corners) {
        const Vec3i place = place_in_cell(fine.corner[k], grid.cell[c], ratio_);
        if (diagonal[k] != own || place.maxCoeff() == ratio_) return false;
    }
    sum += weight[0] * full_[0] + weight[1] * full_[1] + weight[2] * full_[2];
    sum += own * full_corners_;
    return true;
}

void CubeEnergies::add_cell(const GridView& fine, const CoarseGrid& grid, std::size_t c,
                            std::span<const double> diagonal, std::span<const std::uint8_t> held,
                            CellMatrix& sum) const
{
    const bool any_out =
        std::any_of(grid.cells.of(c).begin(), grid.cells.of(c).end(), [&](std::uint32_t cube) {
            if (held.empty()) return false;
            const Eight& eight = fine.corners[cube];
            return std::any_of(eight.begin(), eight.end(),
                               [&](std::uint32_t k) { return held[k] != 0; });
        });
    if (!any_out && add_full_cell(fine, grid, c, diagonal, sum)) return;
    for (const auto cube : grid.cells.of(c)) {
        const Vec3i place = fine.cell[cube] - ratio_ * grid.cell[c];
        const auto& w = cubes_.weights[cube];
        const auto& table = cube_[cube_at(place)];
        bool out = false;
        for (const auto k : fine.corners[cube]) out |= !held.empty() && held[k] != 0;
        if (!out && cubes_.is_shared(cube)) {
            sum += w[0] * table[0] + w[1] * table[1] + w[2] * table[2];
            continue;
        }
        auto q = cube_motion(place, ratio_);
        for (unsigned a = 0; a < 8; ++a) {
            for (unsigned i = 0; i < 3; ++i) {
                if (out && held[fine.corners[cube][a]] >> i & 1) q.row(3 * Index(a) + i).setZero();
            }
        }
        sum += q.transpose() * (cubes_.of(cube) * q);
    }
    for (const auto k : grid.corners.of(c)) {
        const Vec3i place = place_in_cell(fine.corner[k], grid.cell[c], ratio_);
        sum += diagonal[k] * corner_[corner_at(place)];
    }
}

// In motions about the coarse cell's origin the map is the same for all six numbers, and falls
// apart by axes.
void add_cell_of_cells(const CellMatrix& energy, const Vec3i& place, int ratio, CellMatrix& sum)
{
    CellMatrix m = energy;
    const Vec3 at = place.cast<double>() / ratio;
    move_origin(m, 1.0 / ratio,
                [&](unsigned j) { return Vec3(at + bits_of(j).cast<double>() / ratio); });
    for (int axis = 0; axis < 3; ++axis) {
        spread_along(axis, at[axis], at[axis] + 1.0 / ratio, m);
    }
    move_origin(m, 1, [](unsigned j) { return Vec3(-bits_of(j).cast<double>()); });
    sum += m;
}

}  // namespace physics

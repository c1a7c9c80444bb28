#include "physics/bricks/brick_flow.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/brick_kernels.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Mat3;
using geometry::no_index;

constexpr std::size_t blocks_a_task = 16;

// In the order of plastic_rows.
constexpr Eigen::Index row_of[6] = {0, 0, 0, 1, 1, 2}, column_of[6] = {0, 1, 2, 1, 2, 2};

// Of lane 0 of some rows, times `scale`.
BrickStrain load_rest(const double* rows, double scale)
{
    BrickStrain out;
    for (std::size_t i = 0; i < 6; ++i) {
        const double value = scale * rows[i * block_lanes];
        out.mean(row_of[i], column_of[i]) = out.mean(column_of[i], row_of[i]) = value;
    }
    for (std::size_t i = 0; i < 12; ++i) {
        out.bent.data()[i] = scale * rows[(6 + i) * block_lanes];
    }
    return out;
}

void store_rest(const BrickStrain& rest, double scale, double* rows, float* low)
{
    const auto store = [&](std::size_t i, double value) {
        rows[i * block_lanes] = scale * value;
        low[i * block_lanes] = static_cast<float>(scale * value);
    };
    for (std::size_t i = 0; i < 6; ++i) store(i, rest.mean(row_of[i], column_of[i]));
    for (std::size_t i = 0; i < 12; ++i) store(6 + i, rest.bent.data()[i]);
}

// The same rest shape with the volume 1.
Mat3 as_large(const Mat3& strain)
{
    return with_volume_1(Mat3::Identity() + strain) - Mat3::Identity();
}

// R^T C / (4 h) of a brick, less I of the mean, from its corners (4 numbers a slot) and its
// rotation (rows of lanes).
BrickStrain strain_of(const std::uint32_t* slots, const double* x, const double* rotation,
                      double edge)
{
    Eigen::Matrix<double, 3, 7> c = Eigen::Matrix<double, 3, 7>::Zero();
    for (unsigned a = 0; a < 8; ++a) {
        const Eigen::Map<const Eigen::Vector3d> at(x + 4 * std::size_t{slots[a * block_lanes]});
        const double s[3] = {(a & 1) ? 1.0 : -1.0, (a & 2) ? 1.0 : -1.0, (a & 4) ? 1.0 : -1.0};
        const double sign[7] = {
            s[0], s[1], s[2], s[0] * s[1], s[1] * s[2], s[2] * s[0], s[0] * s[1] * s[2]};
        for (Eigen::Index m = 0; m < 7; ++m) c.col(m) += sign[m] * at;
    }
    Mat3 r;
    for (Eigen::Index k = 0; k < 9; ++k) {
        r(k / 3, k % 3) = rotation[std::size_t(k) * block_lanes];
    }
    const Eigen::Matrix<double, 3, 7> turned = r.transpose() * c / (4 * edge);
    BrickStrain out;
    const Mat3 stretch = turned.leftCols<3>();
    out.mean = 0.5 * (stretch + stretch.transpose()) - Mat3::Identity();
    out.bent = turned.rightCols<4>();
    return out;
}

}  // namespace

double size_of(const BrickStrain& strain)
{
    // Column of the monomial of two axes.
    constexpr Eigen::Index of[3][3] = {{-1, 0, 2}, {0, -1, 1}, {2, 1, -1}};
    const auto& b = strain.bent;
    double sum = strain.mean.squaredNorm();
    for (Eigen::Index n = 0; n < 3; ++n) {
        const Eigen::Index j = (n + 1) % 3, k = (n + 2) % 3;
        const double jj = b(j, of[n][j]), kk = b(k, of[n][k]);
        const double jk = 0.5 * (b(k, of[n][j]) + b(j, of[n][k]));
        sum += (jj * jj + kk * kk + 2 * jk * jk) / 3;
    }
    sum += 2 * b.col(3).squaredNorm() / 9;
    return std::sqrt(sum);
}

BrickStrain flowed(const BrickStrain& rest, const BrickStrain& now, const PlasticOptions& options,
                   double dt)
{
    constexpr double least = 0.05;  // of its volume: what is crushed or inside out has no shape
    if (!((Mat3::Identity() + now.mean).determinant() > least)) return rest;
    BrickStrain beyond{now.mean - rest.mean, now.bent - rest.bent};
    beyond.mean.diagonal().array() -= beyond.mean.trace() / 3;
    const double share = share_that_flows(options, size_of(beyond), dt);
    if (!(share > 0)) return rest;
    BrickStrain out{as_large(rest.mean + share * beyond.mean), rest.bent + share * beyond.bent};
    const double size = size_of(out);
    if (size > options.limit) {
        const double by = options.limit / size;
        out.mean = as_large(by * out.mean);
        out.bent *= by;
    }
    return out;
}

// By which strain the rest shape of lane i flows, or would.
double BrickElasticity::flow_lane(std::size_t i, const double* x, double dt, Flow how)
{
    const std::size_t block = i / block_lanes, lane = i % block_lanes;
    if (body_.layout.cube[i] == no_index || (!held_.empty() && held_[i] > 0)) return 0;
    const double edge = body_.block_edge[block];
    const BrickStrain now = strain_of(&body_.layout.gather[block * 8 * block_lanes + lane], x,
                                      &rotation_[block * 9 * block_lanes + lane], edge);
    const std::size_t at = block * plastic_rows * block_lanes + lane;
    const BrickStrain rest =
        plastic_.empty() ? BrickStrain{} : load_rest(&plastic_[at], 1 / (4 * edge));
    const BrickStrain next = flowed(rest, now, body_.plastic, dt);
    const double flowed = size_of({next.mean - rest.mean, next.bent - rest.bent});
    if (!(flowed > least_flow)) return 0;
    if (how == Flow::taken) store_rest(next, 4 * edge, &plastic_[at], &plastic_low_[at]);
    return flowed;
}

double BrickElasticity::flow(const double* x, double dt, Flow how)
{
    if (!may_flow()) return 0;
    evaluate(x, nullptr, {});  // the rotations there
    const std::size_t blocks = body_.layout.blocks();
    const auto flow_all = [&](Flow as) {
        std::vector<double> most(blocks, 0);
        geometry::parallel_for(blocks, blocks_a_task, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin * block_lanes; i < end * block_lanes; ++i) {
                double& own = most[i / block_lanes];
                own = std::max(own, flow_lane(i, x, dt, as));
            }
        });
        return most.empty() ? 0 : *std::max_element(most.begin(), most.end());
    };
    if (plastic_.empty()) {
        const double would = flow_all(Flow::told);
        if (would == 0 || how == Flow::told) return would;
        plastic_.assign(blocks * plastic_rows * block_lanes, 0);
        plastic_low_.assign(plastic_.size(), 0);
    }
    return flow_all(how);
}

void BrickElasticity::load_plastic(const std::vector<float>& from)
{
    plastic_.clear(), plastic_low_.clear();
    if (from.size() != plastic_rows * body_.cubes) return;
    const BrickLayout& layout = body_.layout;
    plastic_.assign(layout.blocks() * plastic_rows * block_lanes, 0);
    plastic_low_.assign(plastic_.size(), 0);
    for (std::size_t i = 0; i < layout.cube.size(); ++i) {
        if (layout.cube[i] == no_index) continue;
        const std::size_t block = i / block_lanes;
        for (std::size_t k = 0; k < plastic_rows; ++k) {
            const std::size_t to = (block * plastic_rows + k) * block_lanes + i % block_lanes;
            plastic_[to] = 4 * body_.block_edge[block] *
                           double(from[plastic_rows * std::size_t{layout.cube[i]} + k]);
            plastic_low_[to] = static_cast<float>(plastic_[to]);
        }
    }
}

std::vector<float> BrickElasticity::plastic() const
{
    std::vector<float> out;
    if (plastic_.empty()) return out;
    const BrickLayout& layout = body_.layout;
    out.resize(plastic_rows * body_.cubes);
    for (std::size_t i = 0; i < layout.cube.size(); ++i) {
        if (layout.cube[i] == no_index) continue;
        const std::size_t block = i / block_lanes;
        for (std::size_t k = 0; k < plastic_rows; ++k) {
            const std::size_t at = (block * plastic_rows + k) * block_lanes + i % block_lanes;
            out[plastic_rows * std::size_t{layout.cube[i]} + k] =
                static_cast<float>(plastic_[at] / (4 * body_.block_edge[block]));
        }
    }
    return out;
}

std::vector<float> BrickElasticity::plastic_strain() const
{
    std::vector<float> out(may_flow() || !plastic_.empty() ? body_.cubes : 0, 0.0f);
    if (plastic_.empty()) return out;
    const BrickLayout& layout = body_.layout;
    for (std::size_t i = 0; i < layout.cube.size(); ++i) {
        if (layout.cube[i] == no_index) continue;
        const std::size_t block = i / block_lanes;
        const double* const rows = &plastic_[block * plastic_rows * block_lanes + i % block_lanes];
        out[layout.cube[i]] =
            static_cast<float>(size_of(load_rest(rows, 1 / (4 * body_.block_edge[block]))));
    }
    return out;
}

}  // namespace physics

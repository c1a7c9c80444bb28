// The matrices of cubes, by products of the kernels with one displacement after the other.

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/body/point_contact.hpp"
#include "physics/bricks/brick_elasticity.hpp"
#include "physics/bricks/brick_hessian.hpp"
#include "physics/bricks/brick_kernels.hpp"

#include <numeric>

namespace physics {
namespace {

constexpr std::size_t blocks_a_run = 8;
constexpr std::size_t block_corners = 8 * block_lanes;

// Block `block` as the only one, its corners in order.
BrickCoefficients<double> alone(const BrickCoefficients<double>& all, std::size_t block,
                                const std::uint32_t* in_order)
{
    return {in_order,
            in_order,
            all.stiffness + block * 3 * block_lanes,
            all.rotation + block * 9 * block_lanes,
            all.element,
            all.excess ? all.excess + block * block_lanes : nullptr,
            all.own_at ? all.own_at + block : nullptr,
            all.own,
            all.own_weight,
            all.own_mass};
}

}  // namespace

bool BrickElasticity::cube_matrices(std::vector<BrickMatrix>& out) const
{
    const auto all = weighted();
    const bool curved = uses_hessian();
    std::vector<std::uint32_t> in_order(block_corners);
    std::iota(in_order.begin(), in_order.end(), 0u);
    out.resize(body_.cubes);
    geometry::parallel_for(
        body_.layout.blocks(), blocks_a_run, [&](std::size_t begin, std::size_t end) {
            Aligned<double> p(4 * block_corners, 0), q(4 * block_corners, 0);
            for (std::size_t block = begin; block < end; ++block) {
                const auto bricks = alone(all, block, in_order.data());
                BrickCurvature<double> curvature;
                if (curved) {
                    curvature = {strained_.data() + block * strained_rows * block_lanes,
                                 share_.data() + block * block_lanes, stiffness_weight_,
                                 4 * body_.block_edge[block]};
                    if (!plastic_.empty()) {
                        curvature.plastic = plastic_.data() + block * plastic_rows * block_lanes;
                    }
                }
                const std::uint32_t* cube = &body_.layout.cube[block * block_lanes];
                for (std::size_t column = 0; column < 24; ++column) {
                    std::fill(p.begin(), p.end(), 0);
                    std::fill(q.begin(), q.end(), 0);
                    double* moved = &p[4 * block_lanes * (column / 3) + column % 3];
                    for (std::size_t lane = 0; lane < block_lanes; ++lane) moved[4 * lane] = 1;
                    if (curved) {
                        add_hessian_times(bricks, curvature, 0, 1, p.data(), q.data());
                    } else {
                        add_stiffness_times(bricks, 0, 1, p.data(), q.data());
                    }
                    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
                        if (cube[lane] == geometry::no_index) continue;
                        double* to = out[cube[lane]].data() + 24 * column;
                        for (std::size_t row = 0; row < 24; ++row) {
                            to[row] = q[4 * (row / 3 * block_lanes + lane) + row % 3];
                        }
                    }
                }
            }
        });
    if (law_.on()) law_.add_matrices(part(), stiffness_weight_, out);
    return true;
}

// The cube with these eight corners, by slot; no_index where there is none.
std::uint32_t BrickElasticity::cube_with(const std::uint32_t* corners) const
{
    const auto& of = body_.rest->corners;
    const auto slot = [&](std::uint32_t c, std::size_t a) {
        return static_cast<std::uint32_t>(body_.base.slot_of(of[c][a]));
    };
    if (first_of_.empty()) {
        first_of_.assign(body_.base.corners + 1, 0);
        by_first_.resize(body_.cubes);
        for (std::uint32_t c = 0; c < body_.cubes; ++c) ++first_of_[slot(c, 0) + 1];
        std::partial_sum(first_of_.begin(), first_of_.end(), first_of_.begin());
        std::vector<std::uint32_t> next(first_of_.begin(), first_of_.end() - 1);
        for (std::uint32_t c = 0; c < body_.cubes; ++c) by_first_[next[slot(c, 0)]++] = c;
    }
    for (auto i = first_of_[corners[0]]; i < first_of_[corners[0] + 1]; ++i) {
        std::size_t same = 1;
        while (same < 8 && slot(by_first_[i], same) == corners[same]) ++same;
        if (same == 8) return by_first_[i];
    }
    return geometry::no_index;
}

void BrickElasticity::add_contact(const PointContact& contact, const geometry::Mat3& block,
                                  std::span<BrickMatrix> to) const
{
    if (contact.count != 8) return;
    const std::uint32_t cube = cube_with(contact.corners.data());
    if (cube == geometry::no_index) return;
    for (std::size_t i = 0; i < 8; ++i) {
        for (std::size_t j = 0; j < 8; ++j) {
            to[cube].block<3, 3>(Eigen::Index(3 * i), Eigen::Index(3 * j)) +=
                double(contact.weight[i]) * double(contact.weight[j]) * block;
        }
    }
}

std::shared_ptr<const Dissection>
BrickElasticity::dissection(const std::vector<std::uint32_t>& held) const
{
    // Solves with more than these take longer than any other way.
    constexpr double most_entries_a_corner = 1500;
    constexpr std::size_t uncut = 8;
    if (!body_.dissections) return nullptr;
    return body_.dissections->find({0, 0, {}, {held, {}}}, [&]() -> DissectionCache::Factor {
        const geometry::Cubes& cubes = *body_.rest;
        std::vector<char> left_out(cubes.corner_count(), 0);
        for (const auto k : held) left_out[k] = 1;
        const double most = most_entries_a_corner * static_cast<double>(cubes.corner_count());
        Dissection tree = dissect(cubes, left_out, most, uncut);
        if (tree.fronts.empty()) return nullptr;
        return std::make_shared<const Dissection>(std::move(tree));
    });
}

}  // namespace physics

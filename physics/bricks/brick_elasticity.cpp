#include "physics/bricks/brick_elasticity.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "physics/bricks/brick_hessian.hpp"
#include "physics/bricks/brick_kernels.hpp"
#include "physics/bricks/corner_factor.hpp"
#include "physics/bricks/cube_matrices.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

using geometry::no_index;

// Below this the threads would wait for each other longer than they work.
constexpr std::size_t blocks_worth_threads = 256;

template <class Each> void for_each_piece(const BrickLayout& layout, const Each& each)
{
    const std::size_t n = layout.pieces.size();
    const std::size_t grain = layout.blocks() < blocks_worth_threads ? n : 1;
    geometry::parallel_for(n, grain, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) each(p);
    });
}

template <class T> void clear_own(const BrickPiece& piece, T* y)
{
    std::fill(y + 4 * std::size_t{piece.first_corner}, y + 4 * std::size_t{piece.last_corner},
              T(0));
    std::fill(y + 4 * std::size_t{piece.first_copy}, y + 4 * std::size_t{piece.last_copy}, T(0));
}

// Shared corners: the sum of their copies.
template <class T> void add_copies(const BrickLayout& layout, T* y)
{
    const std::size_t count = layout.corners - layout.shared;
    geometry::parallel_for(count, 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            T sum[4] = {0, 0, 0, 0};
            for (auto j = layout.copy_at[i]; j < layout.copy_at[i + 1]; ++j) {
                const T* from = y + 4 * std::size_t{layout.copy[j]};
                for (std::size_t k = 0; k < 4; ++k) sum[k] += from[k];
            }
            std::copy(sum, sum + 4, y + 4 * (layout.shared + i));
        }
    });
}

// Of the factor, in 3 x 3 blocks: a solve then costs about as much as 20 products with K.
constexpr double most_entries_a_corner = 150;

// Below this the diagonal takes fewer products than cycles would.
constexpr std::size_t fewest_cubes_for_multigrid = 2000;

// K of a cube of edge h is mu parts[0] + lambda parts[1] + third_modulus() parts[2].
std::array<BrickMatrix, 3> stiffness_parts(double h, BrickElement element)
{
    const BrickMatrix a = brick_stiffness(h, {0, 1}, element);
    if (element == BrickElement::trilinear) {
        return {a, brick_stiffness(h, {1, 0}, element), BrickMatrix::Zero()};
    }
    // At mu = 1, the third of lambda = 0, 1 and 2: two equations for the second and third part.
    const double m0 = third_modulus({0, 1}, element), m1 = third_modulus({1, 1}, element);
    const double m2 = third_modulus({2, 1}, element);
    const BrickMatrix one = brick_stiffness(h, {1, 1}, element) - a;
    const BrickMatrix two = brick_stiffness(h, {2, 1}, element) - a;
    const BrickMatrix third = (two - 2 * one) / (m2 - 2 * m1 + m0);
    return {a - m0 * third, one - (m1 - m0) * third, third};
}

}  // namespace

BrickElasticity::BrickElasticity(const BricksBody& body)
    : body_(body), quaternion_(body.layout.blocks() * 4 * block_lanes, 0),
      rotation_(body.layout.blocks() * 9 * block_lanes),
      rotation_low_(body.layout.blocks() * 9 * block_lanes), weighted_(body.stiffness.size()),
      weighted_low_(body.stiffness.size()), excess_(body.excess.size()),
      excess_low_(body.excess.size()), law_(body)
{}

double BrickElasticity::largest_rate(const double* w) const
{
    const BrickLayout& layout = body_.layout;
    std::vector<double> largest_sq(layout.pieces.size(), 0);
    for_each_piece(layout, [&](std::size_t p) {
        double most = 0;
        for (std::size_t b = layout.pieces[p].first_block; b < layout.pieces[p].last_block; ++b) {
            const std::uint32_t* corner = &layout.gather[b * 8 * block_lanes];
            for (std::size_t i = block_lanes; i < 8 * block_lanes; ++i) {
                const double* from = w + 4 * std::size_t{corner[i % block_lanes]};
                const double* to = w + 4 * std::size_t{corner[i]};
                double sum = 0;
                for (std::size_t k = 0; k < 3; ++k) sum += (to[k] - from[k]) * (to[k] - from[k]);
                most = std::max(most, sum);
            }
        }
        const double edge = body_.block_edge[layout.pieces[p].first_block];
        largest_sq[p] = most / (edge * edge);
    });
    double most = 0;
    for (const double sq : largest_sq) most = std::max(most, sq);
    return std::sqrt(most);
}

double BrickElasticity::evaluate(const double* x, double* f, Measures measures)
{
    const BrickLayout& layout = body_.layout;
    std::vector<double> energy(layout.pieces.size());
    Corotation at;
    if (!held_.empty()) at.held = held_.data();
    if (!plastic_.empty()) at.plastic = plastic_.data();
    at.quaternion = quaternion_.data();
    at.rotation = rotation_.data();
    at.rotation_low = rotation_low_.data();
    at.force = f;
    if (hessian_ && f) at.strained = strained_.data(), at.strained_low = strained_low_.data();
    at.stress = measures.stress;
    at.volume = measures.volume;
    at.energy = measures.energy;
    at.material = body_.material.data();
    auto bricks = coefficients(body_.stiffness.data(), rotation_.data());
    bricks.own = body_.own.matrices.data();
    for_each_piece(layout, [&](std::size_t p) {
        const BrickPiece& piece = layout.pieces[p];
        if (f) clear_own(piece, f);
        Corotation own = at;
        own.h = body_.block_edge[piece.first_block];
        energy[p] = corotate(bricks, own, piece.first_block, piece.last_block, x);
        if (law_.on()) energy[p] += law_.evaluate(own, piece.first_block, piece.last_block, x);
    });
    if (f) add_copies(layout, f);
    double total = 0;
    for (const double e : energy) total += e;
    return total;
}

bool BrickElasticity::use_hessian(bool on)
{
    hessian_ = on;
    if (on) law_.keep_whole();
    if (on && strained_.empty()) {
        const std::size_t lanes = body_.layout.blocks() * block_lanes;
        strained_.assign(lanes * strained_rows, 0);
        strained_low_.assign(lanes * strained_rows, 0);
        share_.assign(lanes, 0);
        share_low_.assign(lanes, 0);
        weigh(stiffness_weight_, damping_weight_);
    }
    return true;
}

void BrickElasticity::weigh(double stiffness, double damping)
{
    for (std::size_t i = 0; i < share_.size(); ++i) {
        const double whole = stiffness + damping * body_.stiffness_damping[i];
        share_[i] = whole > 0 ? stiffness / whole : 0;
        share_low_[i] = static_cast<float>(share_[i]);
    }
    stiffness_weight_ = stiffness;
    damping_weight_ = damping;
    for (std::size_t row = 0; row < weighted_.size(); row += block_lanes) {
        const double* beta = &body_.stiffness_damping[row / (3 * block_lanes) * block_lanes];
        for (std::size_t lane = 0; lane < block_lanes; ++lane) {
            const double k = body_.stiffness[row + lane] * (stiffness + damping * beta[lane]);
            weighted_[row + lane] = k;
            weighted_low_[row + lane] = static_cast<float>(k);
        }
    }
    own_weight_.resize(body_.own.blocks * block_lanes, 0);
    own_weight_low_.resize(own_weight_.size(), 0);
    for (std::size_t block = 0; block < body_.own.at.size(); ++block) {
        if (body_.own.at[block] == no_index) continue;
        for (std::size_t lane = 0; lane < block_lanes; ++lane) {
            const double weight =
                stiffness + damping * body_.stiffness_damping[block * block_lanes + lane];
            const std::size_t to = body_.own.at[block] * block_lanes + lane;
            own_weight_[to] = weight;
            own_weight_low_[to] = static_cast<float>(weight);
        }
    }
}

template <class T>
BrickCoefficients<T> BrickElasticity::coefficients(const T* stiffness, const T* rotation) const
{
    return {body_.layout.gather.data(),
            body_.layout.scatter.data(),
            stiffness,
            rotation,
            body_.element,
            nullptr,
            body_.own.at.empty() ? nullptr : body_.own.at.data()};
}

BrickCoefficients<float> BrickElasticity::weighted_low() const
{
    auto bricks = coefficients(weighted_low_.data(), rotation_low_.data());
    bricks.own = body_.own.matrices_low.data();
    bricks.own_weight = own_weight_low_.data();
    bricks.own_mass = body_.own.mass_low.data();
    if (mass_weight_ != 0 && body_.has_brick_mass()) bricks.excess = excess_low_.data();
    return bricks;
}

BrickCoefficients<double> BrickElasticity::weighted() const
{
    auto bricks = coefficients(weighted_.data(), rotation_.data());
    bricks.own = body_.own.matrices.data();
    bricks.own_weight = own_weight_.data();
    bricks.own_mass = body_.own.mass.data();
    if (mass_weight_ != 0 && body_.has_brick_mass()) bricks.excess = excess_.data();
    return bricks;
}

template <class T>
void BrickElasticity::multiply_any(const BrickCoefficients<T>& bricks,
                                   const BrickCurvature<T>& curvature, const T* p, T* y) const
{
    const bool curved = hessian_ && curvature.stiffness > 0;
    const BrickLayout& layout = body_.layout;
    for_each_piece(layout, [&](std::size_t i) {
        const BrickPiece& piece = layout.pieces[i];
        clear_own(piece, y);
        if (curved) {
            BrickCurvature<T> own = curvature;
            own.edge = static_cast<T>(4 * body_.block_edge[piece.first_block]);
            add_hessian_times(bricks, own, piece.first_block, piece.last_block, p, y);
        } else {
            add_stiffness_times(bricks, piece.first_block, piece.last_block, p, y);
        }
        if (law_.on() && stiffness_weight_ > 0) {
            law_.add_times(part(), static_cast<T>(stiffness_weight_), piece.first_block,
                           piece.last_block, p, y);
        }
    });
    add_copies(layout, y);
}

void BrickElasticity::multiply(const float* p, float* y) const
{
    BrickCurvature<float> curvature{strained_low_.data(), share_low_.data(),
                                    static_cast<float>(stiffness_weight_)};
    if (!plastic_low_.empty()) curvature.plastic = plastic_low_.data();
    multiply_any(weighted_low(), curvature, p, y);
}

void BrickElasticity::multiply(const double* p, double* y) const
{
    BrickCurvature<double> curvature{strained_.data(), share_.data(), stiffness_weight_};
    if (!plastic_.empty()) curvature.plastic = plastic_.data();
    multiply_any(weighted(), curvature, p, y);
}

bool BrickElasticity::excess(Lumped of, const double* v, double* y) const
{
    const Aligned<double>& lanes = of == Lumped::mass ? body_.excess : body_.damped_excess;
    if (lanes.empty()) return false;
    auto bricks = coefficients<double>(nullptr, nullptr);
    bricks.excess = lanes.data();
    bricks.own_mass = body_.own.mass.data();
    for_each_piece(body_.layout, [&](std::size_t i) {
        const BrickPiece& piece = body_.layout.pieces[i];
        clear_own(piece, y);
        add_excess_times(bricks, piece.first_block, piece.last_block, v, y);
    });
    add_copies(body_.layout, y);
    return true;
}

void BrickElasticity::couple(double mass, double damping)
{
    const bool same = mass == mass_weight_ && damping == mass_damping_weight_;
    mass_weight_ = mass, mass_damping_weight_ = damping;
    if (same || mass == 0) return;
    for (std::size_t i = 0; i < excess_.size(); ++i) {
        excess_[i] = mass * body_.excess[i];
        if (!body_.damped_excess.empty()) excess_[i] += damping * body_.damped_excess[i];
        excess_low_[i] = static_cast<float>(excess_[i]);
    }
}

void BrickElasticity::add_diagonal(double* d) const
{
    for (std::size_t k = 0; k < body_.base.corners; ++k) {
        double value =
            stiffness_weight_ * body_.diagonal[k] + damping_weight_ * body_.damping_diagonal[k];
        if (body_.has_brick_mass()) value -= mass_weight_ * body_.excess_diagonal[k];
        if (!body_.damped_excess_diagonal.empty()) {
            value -= mass_damping_weight_ * body_.damped_excess_diagonal[k];
        }
        for (std::size_t i = 0; i < 3; ++i) d[4 * k + i] += value;
    }
    if (law_.on()) law_.add_diagonal(part(), stiffness_weight_, d);
}

CubeMatrices BrickElasticity::matrices_at_rest(double stiffness, double damping,
                                               const HeldCorners& held) const
{
    CubeMatrices out;
    out.held = held.matter;
    out.held_factor = stiffness;
    out.parts = stiffness_parts(body_.base.h, body_.element);
    const geometry::Cubes& rest = *body_.rest;
    if (!rest.own.empty()) {
        out.cubes = &rest;
        out.own_factor.assign(body_.cubes, 0);
    }
    auto& weights = out.weights;  // mu, lambda and third_modulus()
    weights.resize(body_.cubes);
    const auto& cube = body_.layout.cube;
    for (std::size_t i = 0; i < cube.size(); ++i) {
        if (cube[i] == no_index) continue;
        const double* k = &body_.stiffness[i / block_lanes * 3 * block_lanes + i % block_lanes];
        const double factor = stiffness + damping * body_.stiffness_damping[i];
        for (std::size_t j = 0; j < 3; ++j) {
            weights[cube[i]][j] = factor * 16 / body_.base.h * k[j * block_lanes];
        }
        if (out.cubes) {
            out.own_factor[cube[i]] =
                factor * rest.young[cube[i]] * body_.block_edge[i / block_lanes];
        }
    }
    return out;
}

std::vector<double> BrickElasticity::by_corner(const std::vector<double>& by_slot) const
{
    std::vector<double> out(by_slot.size());
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = by_slot[body_.base.slot[k]];
    return out;
}

FactorCache::Factor BrickElasticity::make_factor(double stiffness, double damping,
                                                 const std::vector<double>& mass,
                                                 const HeldCorners& held) const
{
    const geometry::Cubes& cubes = *body_.rest;
    std::vector<char> left_out(cubes.corner_count(), 0);
    for (const auto k : held.whole) left_out[k] = 1;
    std::vector<std::uint8_t> axes;
    if (!held.along.empty()) axes = axes_by_corner(held, cubes.corner_count());
    const double most = most_entries_a_corner * static_cast<double>(cubes.corner_count());
    Dissection dissection = dissect(cubes, left_out, most);
    if (dissection.fronts.empty()) return nullptr;
    auto factor = CornerFactor::make(
        std::move(dissection), matrices_at_rest(stiffness, damping, held), by_corner(mass), axes);
    if (!factor) return nullptr;
    return std::make_shared<const CornerFactor>(std::move(*factor));
}

double BrickElasticity::prepare_inverse(double stiffness, double damping,
                                        const std::vector<double>& mass, const HeldCorners& held)
{
    factor_ = body_.factors->find({stiffness, damping, mass, held},
                                  [&] { return make_factor(stiffness, damping, mass, held); });
    // Measured: 0.6 ns an entry of the factor, 20 ns a cube.
    return factor_ ? 0.03 * factor_->entries() / static_cast<double>(body_.cubes)
                   : std::numeric_limits<double>::infinity();
}

void BrickElasticity::apply_inverse(const float* r, float* z)
{
    const std::size_t k_end = body_.base.corners;
    turned_.resize(body_.base.numbers, 0);
    solved_.assign(body_.base.numbers, 0);
    for (std::size_t k = 0; k < k_end; ++k) {
        const float *m = &rotation_low_[body_.turns_with[k]], *from = r + 4 * k;
        float* to = &turned_[4 * k];
        for (std::size_t i = 0; i < 3; ++i) {
            to[i] = m[i * block_lanes] * from[0] + m[(3 + i) * block_lanes] * from[1] +
                    m[(6 + i) * block_lanes] * from[2];
        }
    }
    factor_->solve(turned_.data(), solved_.data(), body_.base.slot.data(), factor_work_);
    for (std::size_t k = 0; k < k_end; ++k) {
        const float *m = &rotation_low_[body_.turns_with[k]], *from = &solved_[4 * k];
        float* to = z + 4 * k;
        for (std::size_t i = 0; i < 3; ++i) {
            to[i] = m[3 * i * block_lanes] * from[0] + m[(3 * i + 1) * block_lanes] * from[1] +
                    m[(3 * i + 2) * block_lanes] * from[2];
        }
    }
}

MultigridCache::Factor BrickElasticity::make_multigrid(double stiffness, double damping,
                                                       const std::vector<double>& mass,
                                                       const HeldCorners& held) const
{
    return std::make_shared<const Multigrid>(
        Multigrid::make(*body_.rest, matrices_at_rest(stiffness, damping, held), by_corner(mass),
                        axes_by_corner(held, body_.base.corners)));
}

double BrickElasticity::prepare_coarse(double stiffness, double damping,
                                       const std::vector<double>& mass, const HeldCorners& held)
{
    if (!body_.multigrids || body_.cubes < fewest_cubes_for_multigrid) return 0;
    multigrid_ = body_.multigrids->find({stiffness, damping, mass, held}, [&] {
        return make_multigrid(stiffness, damping, mass, held);
    });
    turn_corners();
    return body_.largest_eigenvalue;
}

// Gathers the rotations that corners turn with.
void BrickElasticity::turn_corners()
{
    const auto& slot = body_.base.slot;
    corner_turns_.resize(12 * slot.size());
    geometry::parallel_for(slot.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const float* const m = &rotation_low_[body_.turns_with[slot[k]]];
            float* const rows = &corner_turns_[12 * k];
            for (std::size_t i = 0; i < 3; ++i) {
                for (std::size_t j = 0; j < 3; ++j) {
                    rows[4 * i + j] = m[(3 * i + j) * block_lanes];
                }
                rows[4 * i + 3] = 0;
            }
        }
    });
}

void BrickElasticity::add_coarse(const float* r, float* z)
{
    multigrid_->correct(r, z, body_.base.slot.data(), corner_turns_.data(), multigrid_work_);
}

void BrickElasticity::load_rotations(const std::vector<float>& from)
{
    const auto& cube = body_.layout.cube;
    if (from.size() != 4 * body_.cubes) return;
    for (std::size_t i = 0; i < cube.size(); ++i) {
        if (cube[i] == no_index) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            quaternion_[(i / block_lanes * 4 + k) * block_lanes + i % block_lanes] =
                double(from[4 * std::size_t{cube[i]} + k]);
        }
    }
}

void BrickElasticity::hold(const std::vector<HeldRotation>& rotations)
{
    held_.clear();
    if (rotations.empty()) return;
    const auto& cube = body_.layout.cube;
    std::vector<std::uint32_t> lane_of(body_.cubes);
    for (std::uint32_t i = 0; i < cube.size(); ++i) {
        if (cube[i] != no_index) lane_of[cube[i]] = i;
    }
    held_.assign(cube.size(), 0);
    for (const auto& [c, quaternion] : rotations) {
        const std::size_t i = lane_of[c];
        held_[i] = 1;
        for (std::size_t k = 0; k < 4; ++k) {
            quaternion_[(i / block_lanes * 4 + k) * block_lanes + i % block_lanes] =
                double(quaternion[k]);
        }
    }
}

std::vector<float> BrickElasticity::rotations() const
{
    const auto& cube = body_.layout.cube;
    std::vector<float> out(4 * body_.cubes);
    for (std::size_t i = 0; i < cube.size(); ++i) {
        if (cube[i] == no_index) continue;
        for (std::size_t k = 0; k < 4; ++k) {
            out[4 * std::size_t{cube[i]} + k] = static_cast<float>(
                quaternion_[(i / block_lanes * 4 + k) * block_lanes + i % block_lanes]);
        }
    }
    return out;
}

}  // namespace physics

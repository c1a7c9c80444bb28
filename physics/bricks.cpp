#include "physics/bricks.hpp"

#include "geometry/parallel.hpp"
#include "geometry/plane.hpp"
#include "physics/brick_kernels.hpp"
#include "physics/report_texts.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace physics {
namespace {

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

// K of a cube of edge h is mu parts[0] + lambda parts[1] + lambda' parts[2].
std::array<BrickMatrix, 3> stiffness_parts(double h, BrickElement element)
{
    const BrickMatrix a = brick_stiffness(h, {0, 1}, element);
    if (element == BrickElement::trilinear) {
        return {a, brick_stiffness(h, {1, 0}, element), BrickMatrix::Zero()};
    }
    // lambda' is 2/3 for lambda = mu = 1 and 1 for lambda = 2, mu = 1.
    const BrickMatrix one = brick_stiffness(h, {1, 1}, element) - a;
    const BrickMatrix two = brick_stiffness(h, {2, 1}, element) - a;
    const BrickMatrix bend = -3 * (two - 2 * one);
    return {a, one - 2.0 / 3 * bend, bend};
}

class BrickElasticity final : public Elasticity {
public:
    explicit BrickElasticity(const BricksBody& body)
        : body_(body), quaternion_(body.layout.blocks() * 4 * block_lanes),
          rotation_(body.layout.blocks() * 9 * block_lanes),
          rotation_low_(body.layout.blocks() * 9 * block_lanes), weighted_(body.stiffness.size()),
          weighted_low_(body.stiffness.size())
    {}

    std::size_t room() const override { return 4 * body_.layout.slots; }

    void forces(const double* x, double* f) override { evaluate(x, f, {}); }
    double energy(const double* x) override { return evaluate(x, nullptr, {}); }

    double largest_difference(const double* w) const override
    {
        const BrickLayout& layout = body_.layout;
        std::vector<double> largest_sq(layout.pieces.size(), 0);
        for_each_piece(layout, [&](std::size_t p) {
            double most = 0;
            for (std::size_t b = layout.pieces[p].first_block; b < layout.pieces[p].last_block;
                 ++b) {
                const std::uint32_t* corner = &layout.gather[b * 8 * block_lanes];
                for (std::size_t i = block_lanes; i < 8 * block_lanes; ++i) {
                    const double* from = w + 4 * std::size_t{corner[i % block_lanes]};
                    const double* to = w + 4 * std::size_t{corner[i]};
                    double sum = 0;
                    for (std::size_t k = 0; k < 3; ++k)
                        sum += (to[k] - from[k]) * (to[k] - from[k]);
                    most = std::max(most, sum);
                }
            }
            largest_sq[p] = most;
        });
        double most = 0;
        for (const double sq : largest_sq) most = std::max(most, sq);
        return std::sqrt(most);
    }

    // Lanes of blocks to fill, where not null.
    struct Measures {
        float* stress = nullptr;  // Pa
        float* volume = nullptr;  // of that at rest
    };
    // Forces where f is not null, and measures. Returns the energy.
    double evaluate(const double* x, double* f, Measures measures)
    {
        const BrickLayout& layout = body_.layout;
        std::vector<double> energy(layout.pieces.size());
        Corotation at;
        at.h = body_.base.h;
        at.quaternion = quaternion_.data();
        at.rotation = rotation_.data();
        at.rotation_low = rotation_low_.data();
        at.force = f;
        at.stress = measures.stress;
        at.volume = measures.volume;
        at.material = body_.material.data();
        const auto bricks = coefficients(body_.stiffness.data(), rotation_.data());
        for_each_piece(layout, [&](std::size_t p) {
            const BrickPiece& piece = layout.pieces[p];
            if (f) clear_own(piece, f);
            energy[p] = corotate(bricks, at, piece.first_block, piece.last_block, x);
        });
        if (f) add_copies(layout, f);
        double total = 0;
        for (const double e : energy) total += e;
        return total;
    }

    void weigh(double stiffness, double damping) override
    {
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
    }

    void multiply(const float* p, float* y) const override
    {
        multiply_any(coefficients(weighted_low_.data(), rotation_low_.data()), p, y);
    }
    void multiply(const double* p, double* y) const override
    {
        multiply_any(coefficients(weighted_.data(), rotation_.data()), p, y);
    }

    void add_diagonal(double* d) const override
    {
        for (std::size_t k = 0; k < body_.base.corners; ++k) {
            const double value =
                stiffness_weight_ * body_.diagonal[k] + damping_weight_ * body_.damping_diagonal[k];
            for (std::size_t i = 0; i < 3; ++i) d[4 * k + i] += value;
        }
    }

    double prepare_inverse(double stiffness, double damping, const std::vector<double>& mass,
                           const std::vector<std::uint32_t>& held) override
    {
        factor_ = body_.factors->find({stiffness, damping, mass, held},
                                      [&] { return make_factor(stiffness, damping, mass, held); });
        // Measured: 0.6 ns an entry of the factor, 20 ns a cube.
        return factor_ ? 0.03 * factor_->entries() / static_cast<double>(body_.cubes)
                       : std::numeric_limits<double>::infinity();
    }

    // The inverse at rest, turned with the corners.
    void apply_inverse(const float* r, float* z) override
    {
        const std::size_t k_end = body_.base.corners;
        turned_.resize(body_.base.numbers);
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

    // Four numbers a cube: the unit quaternion of its rotation.
    void load_rotations(const std::vector<float>& from)
    {
        const auto& cube = body_.layout.cube;
        if (from.size() != 4 * body_.cubes) return;
        for (std::size_t i = 0; i < cube.size(); ++i) {
            if (cube[i] == no_cube) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                quaternion_[(i / block_lanes * 4 + k) * block_lanes + i % block_lanes] =
                    double(from[4 * std::size_t{cube[i]} + k]);
            }
        }
    }
    std::vector<float> rotations() const override
    {
        const auto& cube = body_.layout.cube;
        std::vector<float> out(4 * body_.cubes);
        for (std::size_t i = 0; i < cube.size(); ++i) {
            if (cube[i] == no_cube) continue;
            for (std::size_t k = 0; k < 4; ++k) {
                out[4 * std::size_t{cube[i]} + k] = static_cast<float>(
                    quaternion_[(i / block_lanes * 4 + k) * block_lanes + i % block_lanes]);
            }
        }
        return out;
    }

private:
    // Null where the factor would be so large that its solves cost more than they save: in solid
    // bodies fill-in grows faster than the iterations that it spares.
    FactorCache::Factor make_factor(double stiffness, double damping,
                                    const std::vector<double>& mass,
                                    const std::vector<std::uint32_t>& held) const
    {
        const geometry::Cubes& cubes = *body_.rest;
        std::vector<char> left_out(cubes.corner_count(), 0);
        for (const auto k : held) left_out[k] = 1;
        const double most = most_entries_a_corner * static_cast<double>(cubes.corner_count());
        Dissection dissection = dissect(cubes, left_out, most);
        if (dissection.fronts.empty()) return nullptr;
        std::vector<std::array<double, 3>> weights(cubes.count());
        const auto& cube = body_.layout.cube;
        for (std::size_t i = 0; i < cube.size(); ++i) {
            if (cube[i] == no_cube) continue;
            const double* k = &body_.stiffness[i / block_lanes * 3 * block_lanes + i % block_lanes];
            const double factor = stiffness + damping * body_.stiffness_damping[i];
            for (std::size_t j = 0; j < 3; ++j) {
                weights[cube[i]][j] = factor * 16 / body_.base.h * k[j * block_lanes];
            }
        }
        std::vector<double> diagonal(cubes.corner_count());
        for (std::size_t k = 0; k < diagonal.size(); ++k) diagonal[k] = mass[body_.base.slot[k]];
        auto factor =
            CornerFactor::make(cubes, std::move(dissection),
                               stiffness_parts(body_.base.h, body_.element), weights, diagonal);
        if (!factor) return nullptr;
        return std::make_shared<const CornerFactor>(std::move(*factor));
    }

    template <class T>
    BrickCoefficients<T> coefficients(const T* stiffness, const T* rotation) const
    {
        return {body_.layout.gather.data(), body_.layout.scatter.data(), stiffness, rotation,
                T(body_.element == BrickElement::trilinear ? 1 : 0)};
    }

    template <class T> void multiply_any(const BrickCoefficients<T>& bricks, const T* p, T* y) const
    {
        const BrickLayout& layout = body_.layout;
        for_each_piece(layout, [&](std::size_t i) {
            const BrickPiece& piece = layout.pieces[i];
            clear_own(piece, y);
            add_stiffness_times(bricks, piece.first_block, piece.last_block, p, y);
        });
        add_copies(layout, y);
    }

    const BricksBody& body_;
    Aligned<double> quaternion_;   // B x 4 x 16
    Aligned<double> rotation_;     // B x 9 x 16
    Aligned<float> rotation_low_;  // B x 9 x 16
    Aligned<double> weighted_;     // B x 3 x 16
    Aligned<float> weighted_low_;  // B x 3 x 16
    double stiffness_weight_ = 0, damping_weight_ = 0;
    FactorCache::Factor factor_;
    Aligned<float> turned_, solved_, factor_work_;
};

std::vector<float> by_cube(const BricksBody& body, const Aligned<float>& lanes)
{
    std::vector<float> out(body.cubes);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        if (body.layout.cube[i] != no_cube) out[body.layout.cube[i]] = lanes[i];
    }
    return out;
}

}  // namespace

BricksBody make_bricks(const geometry::Cubes& cubes, const BrickOptions& options,
                       const geometry::TriMesh* surface)
{
    geometry::need_thickness(cubes, "method bricks");
    BricksBody body;
    body.layout = lay_out_bricks(cubes);
    body.base = make_corner_body(cubes, body.layout.slot, surface);
    body.element = options.element;
    body.cubes = cubes.count();
    body.rest = std::make_shared<const geometry::Cubes>(cubes);
    body.factors = std::make_shared<FactorCache>();
    body.turns_with.assign(body.base.corners, 0);
    const std::size_t lanes = body.layout.cube.size();
    body.stiffness.assign(3 * lanes, 0);
    body.material.assign(2 * lanes, 0);
    body.stiffness_damping.assign(lanes, 0);
    body.diagonal.assign(cubes.corner_count(), 0);
    body.damping_diagonal.assign(cubes.corner_count(), 0);
    const double plain = options.element == BrickElement::trilinear ? 1 : 0;
    for (std::size_t i = 0; i < lanes; ++i) {
        const std::uint32_t c = body.layout.cube[i];
        if (c == no_cube) continue;
        const auto [lambda, mu] = lame(cubes.young[c], cubes.poisson[c]);
        const double bend = plain != 0 ? lambda : 2 * lambda * mu / (lambda + 2 * mu);
        const double share = stiffness_share(cubes, c, options.weighting) * cubes.size / 16;
        const std::size_t block = i / block_lanes, lane = i % block_lanes;
        double* k = &body.stiffness[block * 3 * block_lanes + lane];
        k[0] = share * mu;
        k[block_lanes] = share * lambda;
        k[2 * block_lanes] = share * bend;
        double* m = &body.material[block * 2 * block_lanes + lane];
        m[0] = mu;
        m[block_lanes] = lambda;
        body.stiffness_damping[i] = cubes.stiffness_damping[c];
        // The force on one corner moved along one axis: each monomial of the transform has 1 there.
        const double one =
            share * ((2 * mu + lambda) + 2 * mu + (2 * (2 + plain) * mu + 2 * bend + 2 * mu) / 3 +
                     (4 * mu + lambda) / 9);
        for (const auto corner : cubes.corners[c]) {
            body.turns_with[body.base.slot[corner]] =
                static_cast<std::uint32_t>(block * 9 * block_lanes + lane);
            body.diagonal[body.base.slot[corner]] += one;
            body.damping_diagonal[body.base.slot[corner]] += one * cubes.stiffness_damping[c];
        }
    }
    return body;
}

std::size_t BricksBody::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return sizeof *this - sizeof base + base.bytes() +
           of(layout.slot, layout.cube, layout.gather, layout.scatter, layout.copy_at, layout.copy,
              layout.pieces, stiffness, material, stiffness_damping, diagonal, damping_diagonal);
}

State rest_state(const BricksBody& body)
{
    return rest_state(body.base);
}

std::unique_ptr<Elasticity> elasticity_of(const BricksBody& body,
                                          const std::vector<float>& rotation)
{
    auto elasticity = std::make_unique<BrickElasticity>(body);
    elasticity->load_rotations(rotation);
    return elasticity;
}

State advance(const BricksBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    BrickElasticity elasticity(body);
    elasticity.load_rotations(state.rotation);
    state = advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
    Aligned<float> stress(body.layout.cube.size()), volume(body.layout.cube.size());
    elasticity.evaluate(by_slot(body.base, state.x).data(), nullptr,
                        {stress.data(), volume.data()});
    state.stress = by_cube(body, stress);
    const auto inverted =
        std::count_if(volume.begin(), volume.end(), [](float v) { return v < 0.1f; });
    if (inverted > 0)
        state.report.warnings.push_back(told_of_inverted(std::size_t(inverted), volume.size()));
    state.rotation = elasticity.rotations();
    return state;
}

Strained strain(const BricksBody& body, const std::vector<Vec3>& x)
{
    BrickElasticity elasticity(body);
    Aligned<double> f(4 * body.layout.slots, 0);
    Aligned<float> stress(body.layout.cube.size());
    Strained out;
    out.energy = elasticity.evaluate(by_slot(body.base, x).data(), f.data(), {stress.data()});
    for (std::size_t k = 0; k < body.base.corners; ++k) {
        out.force.emplace_back(f[4 * std::size_t{body.base.slot[k]}],
                               f[4 * std::size_t{body.base.slot[k]} + 1],
                               f[4 * std::size_t{body.base.slot[k]} + 2]);
    }
    out.stress = by_cube(body, stress);
    return out;
}

}  // namespace physics

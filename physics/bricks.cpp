#include "physics/bricks.hpp"

#include "geometry/parallel.hpp"
#include "physics/brick_kernels.hpp"

#include <algorithm>

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

class BrickElasticity final : public Elasticity {
public:
    explicit BrickElasticity(const BricksBody& body)
        : body_(body), quaternion_(body.layout.blocks() * 4 * block_lanes),
          rotation_(body.layout.blocks() * 9 * block_lanes),
          rotation_low_(body.layout.blocks() * 9 * block_lanes), weighted_(body.stiffness.size()),
          weighted_low_(body.stiffness.size())
    {}

    std::size_t room() const override { return 4 * body_.layout.slots; }

    void forces(const double* x, double* f) override { evaluate(x, f, nullptr); }

    // Also the energy, and the stress where it is not null: blocks x 16.
    double evaluate(const double* x, double* f, float* stress)
    {
        const BrickLayout& layout = body_.layout;
        std::vector<double> energy(layout.pieces.size());
        Corotation at;
        at.h = body_.base.h;
        at.quaternion = quaternion_.data();
        at.rotation = rotation_.data();
        at.rotation_low = rotation_low_.data();
        at.force = f;
        at.stress = stress;
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
    std::vector<float> rotations() const
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
    BricksBody body;
    body.layout = lay_out_bricks(cubes);
    body.base = make_corner_body(cubes, body.layout.slot, surface);
    body.element = options.element;
    body.cubes = cubes.count();
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

State advance(const BricksBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options)
{
    BrickElasticity elasticity(body);
    elasticity.load_rotations(state.rotation);
    state = advance_implicitly(body.base, elasticity, std::move(state), loads, dt, options);
    Aligned<float> stress(body.layout.cube.size());
    elasticity.evaluate(by_slot(body.base, state.x).data(), nullptr, stress.data());
    state.stress = by_cube(body, stress);
    state.rotation = elasticity.rotations();
    return state;
}

Strained strain(const BricksBody& body, const std::vector<Vec3>& x)
{
    BrickElasticity elasticity(body);
    Aligned<double> f(4 * body.layout.slots, 0);
    Aligned<float> stress(body.layout.cube.size());
    Strained out;
    out.energy = elasticity.evaluate(by_slot(body.base, x).data(), f.data(), stress.data());
    for (std::size_t k = 0; k < body.base.corners; ++k) {
        out.force.emplace_back(f[4 * std::size_t{body.base.slot[k]}],
                               f[4 * std::size_t{body.base.slot[k]} + 1],
                               f[4 * std::size_t{body.base.slot[k]} + 2]);
    }
    out.stress = by_cube(body, stress);
    return out;
}

}  // namespace physics

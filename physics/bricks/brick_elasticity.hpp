#pragma once

// The elastic forces of bricks as the implicit time step asks for them: runs the kernels
// (brick_kernels.hpp) over all pieces of a body, on all threads, and keeps the cubes' rotations
// between calls.

#include "physics/bricks/bricks_body.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/bricks/mean_law.hpp"
#include "physics/bricks/rotation_knots.hpp"

namespace physics {

template <class T> struct BrickCoefficients;
template <class T> struct BrickCurvature;
struct CubeMatrices;

class BrickElasticity final : public Elasticity {
public:
    explicit BrickElasticity(const BricksBody& body);  // which must outlive it

    std::size_t room() const override { return 4 * body_.layout.slots; }
    void forces(const double* x, double* f) override { evaluate(x, f, {}); }
    double energy(const double* x) override { return evaluate(x, nullptr, {}); }
    double largest_rate(const double* w) const override;
    void weigh(double stiffness, double damping) override;
    bool use_hessian(bool on) override;
    void multiply(const float* p, float* y) const override;
    void multiply(const double* p, double* y) const override;
    void add_diagonal(double* d) const override;
    double prepare_inverse(double stiffness, double damping, const std::vector<double>& mass,
                           const HeldCorners& held) override;
    bool excess(Lumped of, const double* v, double* y) const override;
    void couple(double mass, double damping) override;
    // The inverse at rest, turned with the corners.
    void apply_inverse(const float* r, float* z) override;
    double prepare_coarse(double stiffness, double damping, const std::vector<double>& mass,
                          const HeldCorners& held) override;
    // The coarse grids at rest, turned with the corners.
    void add_coarse(const float* r, float* z) override;
    bool cube_matrices(std::vector<BrickMatrix>& out) const override;
    bool uses_hessian() const override { return hessian_ && stiffness_weight_ > 0; }
    std::size_t cube_count() const override { return body_.cubes; }
    std::shared_ptr<const Dissection>
    dissection(const std::vector<std::uint32_t>& held) const override;
    // Of a collider: contacts between parts stand in no one matrix.
    ElementsOfMethod elements(const double*) const override { return {body_.rest->corners, {}}; }
    void add_contact(const PointContact& contact, const geometry::Mat3& block,
                     std::span<BrickMatrix> to) const override;

    // Lanes of blocks to fill, where not null.
    struct Measures {
        float* stress = nullptr;  // Pa
        float* volume = nullptr;  // of that at rest
        float* energy = nullptr;  // J
    };
    // Forces where f is not null, and measures. Returns the energy.
    double evaluate(const double* x, double* f, Measures measures);

    // Four numbers a cube: the unit quaternion of its rotation. Others are not taken.
    void load_rotations(const std::vector<float>& from);
    std::vector<float> rotations() const override;

    // Numbers a cube of State::plastic: those of plastic_rows, as strains. Others are not taken.
    void load_plastic(const std::vector<float>& from);
    std::vector<float> plastic() const;         // empty: nothing has flowed
    std::vector<float> plastic_strain() const;  // C, of each rest shape; empty: none may or did
    bool may_flow() const override { return body_.plastic.yield > 0; }
    double flow(const double* x, double dt, Flow how) override;
    // Cubes that keep these rotations from here on, whatever their corners do; none: all turn.
    void hold(const std::vector<HeldRotation>& rotations);

private:
    // Null where the factor would be so large that its solves cost more than they save: in solid
    // bodies fill-in grows faster than the iterations that it spares.
    FactorCache::Factor make_factor(double stiffness, double damping,
                                    const std::vector<double>& mass, const HeldCorners& held) const;
    void turn_corners();
    MultigridCache::Factor make_multigrid(double stiffness, double damping,
                                          const std::vector<double>& mass,
                                          const HeldCorners& held) const;
    double flow_lane(std::size_t i, const double* x, double dt, Flow how);
    MeanLaw::Part part() const
    {
        return uses_hessian() ? MeanLaw::Part::whole : MeanLaw::Part::positive;
    }
    std::uint32_t cube_with(const std::uint32_t* corners) const;
    // `held` must outlive them.
    CubeMatrices matrices_at_rest(double stiffness, double damping, const HeldCorners& held) const;
    std::vector<double> by_corner(const std::vector<double>& by_slot) const;
    template <class T>
    BrickCoefficients<T> coefficients(const T* stiffness, const T* rotation) const;
    BrickCoefficients<float> weighted_low() const;
    BrickCoefficients<double> weighted() const;
    template <class T>
    void multiply_any(const BrickCoefficients<T>& bricks, const BrickCurvature<T>& curvature,
                      const T* p, T* y) const;

    const BricksBody& body_;
    Aligned<double> quaternion_;   // B x 4 x 16
    Aligned<double> held_;         // B x 16, 1: held; empty: none is
    Aligned<double> rotation_;     // B x 9 x 16
    Aligned<float> rotation_low_;  // B x 9 x 16
    Aligned<float> corner_turns_;  // K x 12, CornerTurns, as the multigrid was asked for
    Aligned<double> weighted_;     // B x 3 x 16
    Aligned<float> weighted_low_;  // B x 3 x 16
    Aligned<double> own_weight_;   // own blocks x 16
    Aligned<float> own_weight_low_;
    double stiffness_weight_ = 0, damping_weight_ = 0;
    double mass_weight_ = 0, mass_damping_weight_ = 0;
    Aligned<double> excess_;     // B x 16, as coupled
    Aligned<float> excess_low_;  // the same in single precision
    bool hessian_ = false;
    MeanLaw law_;
    Aligned<double> plastic_;           // B x plastic_rows x 16, m; empty: nothing has flowed
    Aligned<float> plastic_low_;        // the same in single precision
    Aligned<double> strained_, share_;  // as BrickCurvature has them; empty until used
    Aligned<float> strained_low_, share_low_;      // the same in single precision
    mutable std::vector<std::uint32_t> first_of_;  // K by slot, into by_first_; empty until used
    mutable std::vector<std::uint32_t> by_first_;  // C, cubes by their first corner
    FactorCache::Factor factor_;
    MultigridCache::Factor multigrid_;
    Multigrid::Work multigrid_work_;
    Aligned<float> turned_, solved_, factor_work_;
};

}  // namespace physics

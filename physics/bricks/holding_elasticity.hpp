#pragma once

// The elasticity of a method with the springs of pins that hold points of the material
// (state/hold_matter.hpp): f -= A (x - t), K += A. The springs do not turn with the cubes, and
// damp nothing.

#include "physics/body/corner_body.hpp"
#include "physics/body/pin_paths.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/state/state.hpp"

#include <utility>

namespace physics {

class HoldingElasticity final : public Elasticity {
public:
    // All must outlive it. `from` is where the targets were when the frame began, as many.
    HoldingElasticity(const CornerBody& body, Elasticity& method, const HeldMatter& matter,
                      std::vector<Vec3> from);

    std::size_t room() const override { return method_.room(); }
    void forces(const double* x, double* f) override;
    double energy(const double* x) override;
    double largest_rate(const double* w) const override { return method_.largest_rate(w); }
    void weigh(double stiffness, double damping) override;
    bool use_hessian(bool on) override { return method_.use_hessian(on); }
    void multiply(const float* p, float* y) const override;
    void multiply(const double* p, double* y) const override;
    void add_diagonal(double* d) const override;
    bool excess(Lumped of, const double* v, double* y) const override
    {
        return method_.excess(of, v, y);
    }
    void couple(double mass, double damping) override { method_.couple(mass, damping); }
    bool cube_matrices(std::vector<BrickMatrix>& out) const override;
    bool uses_hessian() const override { return method_.uses_hessian(); }
    std::size_t cube_count() const override { return method_.cube_count(); }
    std::shared_ptr<const Dissection>
    dissection(const std::vector<std::uint32_t>& held) const override
    {
        return method_.dissection(held);
    }
    std::shared_ptr<const Dissection>
    dissection_with(const std::vector<std::uint32_t>& held,
                    const std::vector<std::array<std::uint32_t, 8>>& more,
                    const double* x) const override
    {
        return method_.dissection_with(held, more, x);
    }
    double product_work() const override { return method_.product_work(); }
    std::vector<float> rotations() const override { return method_.rotations(); }
    double prepare_inverse(double stiffness, double damping, const std::vector<double>& mass,
                           const HeldCorners& held) override
    {
        return method_.prepare_inverse(stiffness, damping, mass, held);
    }
    void apply_inverse(const float* r, float* z) override { method_.apply_inverse(r, z); }
    double prepare_coarse(double stiffness, double damping, const std::vector<double>& mass,
                          const HeldCorners& held) override;
    void add_coarse(const float* r, float* z) override { method_.add_coarse(r, z); }
    void add_contact(const PointContact& contact, const geometry::Mat3& block,
                     std::span<BrickMatrix> cubes) const override
    {
        method_.add_contact(contact, block, cubes);
    }
    bool may_flow() const override { return method_.may_flow(); }
    double flow(const double* x, double dt, Flow how) override { return method_.flow(x, dt, how); }
    bool look_back(const double* came, double tau) override { return method_.look_back(came, tau); }
    bool targets_move() const override { return paths_.move(); }
    std::vector<Vec3> targets(double share) const override;
    // m a frame, of each of these then.
    std::vector<Vec3> target_velocities(double share) const;
    std::vector<Vec3> at_end(std::vector<Vec3> forces, double share) const override
    {
        return paths_.at_end(std::move(forces), share);
    }
    void at_share(double share) override;

private:
    template <class T> struct Spring {
        T stiffness[8][8];
        T axis[4];  // 1: held along it
    };
    template <class T>
    void add_times(const std::vector<Spring<T>>& springs, const T* p, T* y) const;
    // d(cube, corner, axis) = x - t, of cube c: 8 times 4 numbers.
    void away(std::size_t c, const double* x, double d[8][4]) const;

    Elasticity& method_;
    const HeldMatter& matter_;
    PinPaths paths_;                                // of its targets
    std::vector<Vec3> target_;                      // m, now
    std::vector<std::array<std::uint32_t, 8>> at_;  // of each cube, first numbers in vectors
    std::vector<Spring<double>> springs_;
    std::vector<Spring<float>> springs_low_;
    double weight_ = 0;
};

}  // namespace physics

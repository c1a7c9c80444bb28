#pragma once

// The elastic forces of solids and sheets together: those of each on its own slots. What they give
// each other are contacts, which the step adds.

#include "physics/bricks/elasticity.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/mixed/mixed_body.hpp"

namespace physics {

class MixedElasticity final : public Elasticity {
public:
    // All must outlive it.
    MixedElasticity(const MixedBody& body, Elasticity& bricks, Elasticity& shell);

    std::size_t room() const override { return body_.base.numbers; }
    void forces(const double* x, double* f) override;
    double energy(const double* x) override;
    double largest_rate(const double* w) const override;
    void weigh(double stiffness, double damping) override;
    bool use_hessian(bool on) override;
    bool uses_hessian() const override { return bricks_.uses_hessian() || shell_.uses_hessian(); }
    void multiply(const float* p, float* y) const override;
    void multiply(const double* p, double* y) const override;
    double product_work() const override;
    void add_diagonal(double* d) const override;
    bool excess(Lumped of, const double* v, double* y) const override;
    void couple(double mass, double damping) override { bricks_.couple(mass, damping); }
    bool cube_matrices(std::vector<BrickMatrix>& out) const override;
    std::size_t cube_count() const override { return bricks_.cube_count() + shell_.cube_count(); }
    std::shared_ptr<const Dissection>
    dissection(const std::vector<std::uint32_t>& held) const override;
    std::shared_ptr<const Dissection>
    dissection_with(const std::vector<std::uint32_t>& held,
                    const std::vector<std::array<std::uint32_t, 8>>& more,
                    const double* x) const override;
    void add_contact(const PointContact& contact, const geometry::Mat3& block,
                     std::span<BrickMatrix> to) const override;
    bool may_flow() const override { return bricks_.may_flow(); }
    double flow(const double* x, double dt, Flow how) override;
    bool look_back(const double* came, double tau) override
    {
        take(came, high_);
        return shell_.look_back(high_.sheets.data(), tau);
    }

private:
    // Vectors of their own, of each kind.
    template <class T> struct Own {
        Aligned<T> solids, sheets, solids_out, sheets_out;
    };
    template <class T> void take(const T* from, Own<T>& own) const;
    template <class T> void give(const Own<T>& own, T* to) const;
    template <class T> void multiply_any(Own<T>& own, const T* p, T* y) const;
    std::shared_ptr<const Dissection>
    dissected(const std::vector<std::uint32_t>& held,
              const std::vector<std::array<std::uint32_t, 8>>& more, const double* x) const;

    const MixedBody& body_;
    Elasticity& bricks_;
    Elasticity& shell_;
    std::size_t first_;                          // slot of the sheets
    std::vector<std::uint32_t> corner_of_slot_;  // K
    mutable Own<double> high_;
    mutable Own<float> low_;
};

}  // namespace physics

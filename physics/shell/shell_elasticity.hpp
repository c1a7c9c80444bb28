#pragma once

// The elastic forces of a shell as the implicit time step asks for them. The matrix of their
// derivative is kept as rows of 3 x 3 blocks.

#include "physics/bricks/elasticity.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/shell/shell_body.hpp"
#include "physics/state/loads.hpp"

namespace physics {

class ShellElasticity final : public Elasticity {
public:
    // The body must outlive it. `pins` make clamps (shell_body.hpp).
    ShellElasticity(const ShellBody& body, const Pins& pins);

    std::size_t room() const override { return body_.base.numbers; }
    void forces(const double* x, double* f) override;
    double energy(const double* x) override;
    double largest_rate(const double* w) const override;
    void weigh(double stiffness, double damping) override;
    bool use_hessian(bool on) override;  // at once, at the x of the last forces()
    bool uses_hessian() const override { return hessian_ && stiffness_weight_ > 0; }
    void multiply(const float* p, float* y) const override;
    void multiply(const double* p, double* y) const override;
    void add_diagonal(double* d) const override;
    bool cube_matrices(std::vector<BrickMatrix>& out) const override;
    void add_contact(const PointContact& contact, const geometry::Mat3& block,
                     std::span<BrickMatrix> to) const override;
    ElementsOfMethod elements(const double*) const override { return {body_.elements.corners, {}}; }
    std::size_t cube_count() const override { return body_.element.size(); }
    std::shared_ptr<const Dissection>
    dissection(const std::vector<std::uint32_t>& held) const override;
    std::shared_ptr<const Dissection>
    dissection_with(const std::vector<std::uint32_t>& held,
                    const std::vector<std::array<std::uint32_t, 8>>& more,
                    const double* x) const override;
    bool look_back(const double* came, double tau) override;

private:
    AcrossStiffness across(std::size_t c, const double* came, double tau) const;
    using CornerForces = std::array<Vec3, 4>;
    using CornerBlocks = std::array<Eigen::Matrix3d, 16>;  // (i, j) at 4 i + j

    void evaluate_cells();
    void evaluate_cell(std::size_t c);
    Vec3 force_on(std::size_t k) const;
    void element_matrix(std::size_t e, BrickMatrix& to) const;
    double weight_of_cell(std::size_t c) const;
    double bend_energy(std::uint32_t k, const double* x) const;
    void assemble();
    void add_bends(std::uint32_t k, double stiffness, double damping);
    template <class T> void multiply_any(const Aligned<T>& matrix, const T* p, T* y) const;

    const ShellBody& body_;
    std::vector<ShellPoint> point_;  // K, as pins make them
    double stiffness_weight_ = 1, damping_weight_ = 0;
    bool hessian_ = false;
    bool even_ = true;              // the damping is the same in all cells
    Aligned<double> at_;            // m, where forces were asked for last; empty: nowhere
    Aligned<double> came_;          // m, of look_back() since then; empty: none
    Aligned<CornerForces> pull_;    // C, N, on the corners
    Aligned<CornerBlocks> blocks_;  // C, N/m, of the derivative
    std::vector<std::array<Vec3, 2>> moment_;  // K, N: uu su + uv sv, uv su + vv sv
    // Entries of body.column: K as it is weighed, but for scale_ where the damping is even.
    double scale_ = 1;
    Aligned<double> matrix_;     // 9 an entry
    Aligned<float> matrix_low_;  // likewise
};

}  // namespace physics

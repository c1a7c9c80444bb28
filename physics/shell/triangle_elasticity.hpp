#pragma once

// The elastic forces of a shell of triangles (triangle_shell.hpp) as the implicit time step asks
// for them. With places x, slopes g and the energy's matrix between them (of Gauss and Newton, as
// far as the sheet is curved at rest)
//   ( Kxx  Kxg )
//   ( Kgx  Kgg )
// the matrix of the places alone is Kxx - Kxg Kgg^-1 Kgx: a product takes one solve for slopes
// (slope_factor.hpp), and a factor of it has the slopes as inner corners (direct_factor.hpp).

#include "physics/bricks/dissection.hpp"
#include "physics/bricks/elasticity.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/shell/shell_body.hpp"
#include "physics/shell/slope_factor.hpp"
#include "physics/shell/triangle_flow.hpp"
#include "physics/state/loads.hpp"

namespace physics {

class TriangleElasticity final : public Elasticity {
public:
    // The body must outlive it, and has triangles. `pins` make clamps.
    TriangleElasticity(const ShellBody& body, const Pins& pins);

    std::size_t room() const override { return body_.base.numbers; }
    void forces(const double* x, double* f) override;
    double energy(const double* x) override;
    double largest_rate(const double* w) const override;
    void weigh(double stiffness, double damping) override;
    bool use_hessian(bool on) override;  // of the stretch; at once, at the x of the last forces()
    bool uses_hessian() const override { return hessian_ && stiffness_weight_ > 0; }
    void multiply(const float* p, float* y) const override;
    void multiply(const double* p, double* y) const override;
    double product_work() const override { return 12; }  // measured
    void add_diagonal(double* d) const override;
    bool cube_matrices(std::vector<BrickMatrix>& out) const override;
    void add_contact(const PointContact& contact, const geometry::Mat3& block,
                     std::span<BrickMatrix> to) const override;
    ElementsOfMethod elements(const double* x) const override;
    std::size_t cube_count() const override { return shell_.triangle.size(); }

    // Numbers a triangle of State::plastic: those of TriangleStrain. Others are not taken.
    void load_plastic(const std::vector<float>& from);
    std::vector<float> plastic() const;  // empty: nothing has flowed
    // Of each cell, the larger of its halves; empty: none may flow or did.
    std::vector<float> plastic_strain() const;
    bool may_flow() const override { return body_.options.plastic.yield > 0; }
    double flow(const double* x, double dt, Flow how) override;
    bool look_back(const double* came, double tau) override;

    std::shared_ptr<const Dissection>
    dissection(const std::vector<std::uint32_t>& held) const override;
    std::shared_ptr<const Dissection> dissection_with(const std::vector<std::uint32_t>& held,
                                                      const ElementCorners& more,
                                                      const double* x) const override;

private:
    AcrossStiffness across(std::size_t t, const double* came, double tau) const;
    // How a triangle stands: its normal, where that turns to as each corner moves along it, and
    // what it bends by, a column each.
    struct Pose {
        Vec3 normal;
        Eigen::Matrix3d turn;   // 1/m, minus the change of the normal; of corners, by column
        Eigen::Matrix3d bends;  // e_11, e_22, 2 e_12
    };
    using Blocks = std::array<Eigen::Matrix3d, 9>;  // (i, j) at 3 i + j

    Pose pose_without_slopes(std::size_t t, const double* x) const;
    void add_slopes(std::size_t t, const SideVectors& slopes, Pose& pose) const;
    SideVectors pulls_at(const std::vector<Pose>& poses) const;
    std::vector<Pose> poses_at(const double* x) const;
    void evaluate();
    void evaluate_triangle(std::size_t t, const Pose& pose);
    void assemble();
    double flow_triangle(std::size_t t, const double* x, const Eigen::Matrix3d& bends, double dt,
                         Flow how);
    // Of the matrices of a triangle; 1 where the damping is even, and the weight is scale_.
    double weight_of(std::size_t t) const;
    double damping_of(std::size_t t) const;
    std::shared_ptr<const SlopeFactor> factor_for(double stiffness, double damping) const;
    template <class T> void multiply_any(const Aligned<T>& matrix, const T* p, T* y) const;
    template <class T> SideVectors slopes_that_answer(const T* p) const;
    void element_matrix(std::size_t t, BrickMatrix& to) const;
    std::shared_ptr<const Dissection> dissected(const std::vector<std::uint32_t>& held,
                                                const ElementCorners& more, const double* x) const;

    const ShellBody& body_;
    const TriangleShell& shell_;
    std::vector<TriangleRest> rest_;       // T
    std::vector<TriangleStrain> plastic_;  // T; empty: nothing has flowed
    std::vector<double> clamp_;            // T, how much stiffer pins make each to bend
    std::vector<std::uint32_t> clamps_;    // triangles that are, ascending
    std::shared_ptr<const SlopeFactor> at_rest_, weighed_;
    mutable Aligned<double> slope_work_;
    double stiffness_weight_ = 1, damping_weight_ = 0;
    bool hessian_ = false;
    Aligned<double> at_;                 // m, where forces were asked for last; empty: nowhere
    Aligned<double> came_;               // m, of look_back() since then; empty: none
    std::vector<Pose> pose_;             // T, there
    Aligned<std::array<Vec3, 3>> pull_;  // T, N, on the corners
    Aligned<Blocks> blocks_;             // T, N/m, of the derivative, between corners
    // Entries of the shell's column: K as it is weighed, but for scale_ where the damping is even.
    double scale_ = 1;
    Aligned<double> matrix_;     // 9 an entry
    Aligned<float> matrix_low_;  // likewise
};

}  // namespace physics

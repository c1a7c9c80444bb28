#pragma once

// What a method on cubes tells the implicit time step of itself: its elastic forces, and how they
// change where corners move. Bricks and springs are two of these.

#include "physics/bricks/brick_element.hpp"
#include "physics/bricks/held_corners.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace physics {

struct Dissection;
struct PointContact;

// The elements of cube_matrices(): their corners, numbered as the method's models have them, and
// behind these inner ones, with where they are (m).
struct ElementsOfMethod {
    std::vector<std::array<std::uint32_t, 8>> corners;
    std::vector<geometry::Vec3> inner;
};

// What is lumped on corners: their mass, or their damping with it.
enum class Lumped { mass, damping };

// Vectors hold four numbers a slot, the fourth 0.
class Elasticity {
public:
    virtual ~Elasticity() = default;

    // Numbers in a vector that forces are added up in.
    virtual std::size_t room() const = 0;
    // f = the elastic forces at x, of which the derivative is kept.
    virtual void forces(const double* x, double* f) = 0;
    // The elastic energy at x, J. What was kept of a derivative is lost.
    virtual double energy(const double* x) = 0;
    // The largest difference of a field (m/s) between two corners that the method ties together,
    // about, in edges of their cube: 1/s.
    virtual double largest_rate(const double* w) const = 0;
    // From here on K stands for stiffness * K + damping * (Rayleigh's part of) K.
    virtual void weigh(double stiffness, double damping) = 0;
    // Whether K is all of the second derivative of the energy at the x of the next forces(), which
    // may have negative directions, or only what is never negative of it. Returns whether the
    // method knows the difference.
    virtual bool use_hessian(bool) { return false; }
    virtual void multiply(const float* p, float* y) const = 0;  // y = K p
    // What that takes, in those of as many bricks.
    virtual double product_work() const { return 1; }
    virtual void multiply(const double* p, double* y) const = 0;
    virtual void add_diagonal(double* d) const = 0;  // of K, about

    // Masses that are not lumped on corners: M = the lumped ones - N, and damping with the mass
    // likewise. y = N v; false, and y as it was, where the method has lumped masses.
    virtual bool excess(Lumped, const double*, double*) const { return false; }
    // From here on K holds - (mass N + damping N of the damping) as well, for the sum with the
    // lumped ones. 0, 0 ends it.
    virtual void couple(double, double) {}

    // A as a sum: K as it is weighed, coupled and linearised, one matrix a cube. False: the method
    // has none.
    virtual bool cube_matrices(std::vector<BrickMatrix>&) const { return false; }
    virtual ElementsOfMethod elements(const double*) const { return {}; }  // with corners at x
    virtual bool uses_hessian() const { return false; }  // in products and in these matrices
    virtual std::size_t cube_count() const { return 0; }
    // How such a sum is factored without the corners that are held wholly (sorted); null where that
    // would take longer than any other way.
    virtual std::shared_ptr<const Dissection> dissection(const std::vector<std::uint32_t>&) const
    {
        return nullptr;
    }

    // The same with elements of up to eight corners (slots) added, that join any corners where they
    // are at x (a contact between sheets, or of one with a solid); null where the method cannot
    // tell.
    virtual std::shared_ptr<const Dissection>
    dissection_with(const std::vector<std::uint32_t>&,
                    const std::vector<std::array<std::uint32_t, 8>>&, const double*) const
    {
        return nullptr;
    }

    // Whether rest shapes may give way at all.
    virtual bool may_flow() const { return false; }
    // The end of a step of dt seconds, at x: rest shapes give way, or would. Returns by which
    // strain at most. Where any did, f is another one from here on.
    enum class Flow { taken, told };
    virtual double flow(const double*, double, Flow) { return 0; }

    // Where what springs hold is to be, once a share of the frame has gone by; and whether that
    // changes within the frame.
    virtual void at_share(double) {}
    virtual bool targets_move() const { return false; }
    // Then, m: of each of HeldMatter::corner; empty where nothing is held.
    virtual std::vector<geometry::Vec3> targets(double) const { return {}; }
    // The forces on these then, N, as PinPaths tells them at the end of the frame.
    virtual std::vector<geometry::Vec3> at_end(std::vector<geometry::Vec3> forces, double) const
    {
        return forces;
    }

    // What a state keeps so that the next one starts from there: State::rotation.
    virtual std::vector<float> rotations() const { return {}; }

    // Makes ready an approximate inverse of stiffness * K + damping * (Rayleigh's) + mass (K by
    // slot) without what is `held`. Returns what it costs to apply, in products with K; infinity
    // when the method has none.
    virtual double prepare_inverse(double stiffness, double damping,
                                   const std::vector<double>& mass, const HeldCorners& held);
    // z = that inverse of r, 0 at corners that are held wholly; symmetric and positive. Of held
    // axes of others, r must be 0, and what z has there is to be left out.
    virtual void apply_inverse(const float* r, float* z);

    // Makes ready coarse grids for the same matrix. Returns the largest eigenvalue that D^-1 times
    // the matrix can have, D its diagonal; 0 when the method has no coarse grids.
    virtual double prepare_coarse(double stiffness, double damping, const std::vector<double>& mass,
                                  const HeldCorners& held);
    // z += the coarse grids' answer to r; likewise.
    virtual void add_coarse(const float* r, float* z);

    // Adds what a contact adds to A, `block` (kg) between its corners by their weights, to the
    // matrix that has these corners. Does nothing where the method cannot tell which that is.
    virtual void add_contact(const PointContact&, const geometry::Mat3&,
                             std::span<BrickMatrix>) const
    {}

    // From here to the next forces(), K stiffens sheets by the pull without what a linear step that
    // corners `came` by (m) lengthened them by, where that is a large part of it beside what masses
    // over tau^2 hold. Returns whether it is anywhere.
    virtual bool look_back(const double*, double) { return false; }
};

}  // namespace physics

#pragma once

// Corotational brick finite elements on the cubes of a model, stepped implicitly. The element's
// equations stand in brick_kernels.hpp, the steps' in implicit_step.hpp.
// Squashing cubes: James, Barbic, Twigg, SIGGRAPH 2004 sketches. Bricks as the deformable method on
// embedding cubes: Nesme, Kry, Jerabkova, Faure. Preserving topology and elasticity for embedded
// deformable models. SIGGRAPH 2009.

#include "physics/brick_element.hpp"
#include "physics/brick_layout.hpp"
#include "physics/corner_body.hpp"
#include "physics/factor_cache.hpp"
#include "physics/implicit_step.hpp"

namespace physics {

struct BrickOptions {
    BrickElement element = BrickElement::incompatible;
    Weighting weighting = Weighting::filled;
};

// All that depends on the cubes alone.
struct BricksBody {
    CornerBody base;
    BrickLayout layout;
    BrickElement element = BrickElement::incompatible;
    std::size_t cubes = 0;  // C

    // Rows of 16 lanes a block; lanes without a cube hold 0.
    Aligned<double> stiffness;          // B x 3 x 16: mu, lambda, lambda' times share times h / 16
    Aligned<double> material;           // B x 2 x 16: mu, lambda, Pa
    Aligned<double> stiffness_damping;  // B x 16, s
    std::vector<double> diagonal;       // K by slot, N/m, of the stiffness
    std::vector<double> damping_diagonal;  // K by slot, N s/m

    std::vector<std::uint32_t> turns_with;  // K by slot, where the rotation of a cube at it starts

    // For the preconditioner. The cache only remembers what is a function of the rest.
    std::shared_ptr<const geometry::Cubes> rest;
    std::shared_ptr<FactorCache> factors;

    std::size_t bytes() const;
};

// Contact and wind act on `surface`, or on the outside of the cubes when it is null. Throws
// std::invalid_argument when the cubes are no body.
BricksBody make_bricks(const geometry::Cubes& cubes, const BrickOptions& options = {},
                       const geometry::TriMesh* surface = nullptr);

// The body at rest.
State rest_state(const BricksBody& body);

// The state dt seconds later. Throws std::invalid_argument when state, loads or dt do not fit or
// are not finite; any finite state is accepted, and what goes wrong is told in its report.
State advance(const BricksBody& body, State state, const Loads& loads, double dt,
              const StepOptions& options = {});

// Its forces, for steps of another kind; the body must outlive them. `rotation` is a state's.
std::unique_ptr<Elasticity> elasticity_of(const BricksBody& body,
                                          const std::vector<float>& rotation);

// What a body at x holds: its elastic energy (J), the forces on its corners (N, K) and the von
// Mises stress of its cubes (Pa, C).
struct Strained {
    double energy = 0;
    std::vector<Vec3> force;
    std::vector<float> stress;
};
Strained strain(const BricksBody& body, const std::vector<Vec3>& x);

}  // namespace physics

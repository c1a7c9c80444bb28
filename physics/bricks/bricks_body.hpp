#pragma once

// A body of brick finite elements: what is made once from the cubes of a model and then stepped by
// bricks.hpp.

#include "physics/body/corner_body.hpp"
#include "physics/body/stiffness.hpp"
#include "physics/bricks/brick_element.hpp"
#include "physics/bricks/brick_layout.hpp"
#include "physics/bricks/own_bricks.hpp"
#include "physics/bricks/rotation_knots.hpp"
#include "physics/math/aligned_memory.hpp"
#include "physics/state/plastic.hpp"
#include "physics/state/state.hpp"

#include <memory>
#include <vector>

namespace physics {

class FactorCache;
class MultigridCache;
class DissectionCache;

// How a cube answers to its mean deformation: linearly in the strain that turns with it, or as
// rubber does (mean_law.hpp).
enum class BrickLaw { corotated, neo_hookean };

struct BrickOptions {
    BrickElement element = BrickElement::incompatible;
    BrickLaw law = BrickLaw::corotated;
    Weighting weighting = Weighting::filled;
    PartContactOptions contact = {.on = false};
    PlasticOptions plastic = {};
    std::vector<std::uint8_t> rigid = {};  // of each model, whether it keeps its shape; empty: none
};

// All that depends on the cubes alone.
struct BricksBody {
    CornerBody base;
    BrickLayout layout;
    BrickElement element = BrickElement::incompatible;
    BrickLaw law = BrickLaw::corotated;
    PlasticOptions plastic;
    std::size_t cubes = 0;           // C
    std::vector<double> block_edge;  // B, m, edge of the cubes of each block

    // Rows of 16 lanes a block; lanes without a cube hold 0.
    Aligned<double> stiffness;  // B x 3 x 16: mu, lambda, third_modulus(), times share times h / 16
    OwnBricks own;              // in place of that
    Aligned<double> material;   // B x 2 x 16: mu, lambda, Pa
    Aligned<double> stiffness_damping;  // B x 16, s
    Aligned<double> excess;             // B x 16: mass / 64, kg; empty: lumped mass
    Aligned<double> damped_excess;      // B x 16: that times the mass damping, kg/s; empty: none
    std::vector<double> excess_diagonal, damped_excess_diagonal;  // K by slot, of N, kg and kg/s
    std::vector<double> diagonal;          // K by slot, N/m, of the stiffness
    std::vector<double> damping_diagonal;  // K by slot, N s/m

    CubeNeighbours neighbours;

    std::vector<std::uint32_t> turns_with;  // K by slot, where the rotation of a cube at it starts

    // For the preconditioner. The caches only remember what is a function of the rest.
    std::shared_ptr<const geometry::Cubes> rest;  // of several models: as BodyModels::all()
    std::shared_ptr<FactorCache> factors;
    std::shared_ptr<MultigridCache> multigrids;    // null: no multigrid, to compare
    std::shared_ptr<DissectionCache> dissections;  // null: no factors of steps, to compare
    double largest_eigenvalue = 0;  // of D^-1 A, A a sum of K and M, D its diagonal: at most this

    // Whether its mass is that of bricks (cube_mass.hpp), and not lumped.
    bool has_brick_mass() const { return element != BrickElement::one_point; }
    std::size_t bytes() const;
};

// Throws std::invalid_argument when the cubes are no body.
BricksBody make_bricks(const BodyModels& models, const BrickOptions& options = {});

// Of one model. Contact and wind act on `surface`, or on the outside of the cubes when it is null.
BricksBody make_bricks(const geometry::Cubes& cubes, const BrickOptions& options = {},
                       const geometry::TriMesh* surface = nullptr);

// The body at rest.
State rest_state(const BricksBody& body);

}  // namespace physics

#include "physics/bricks/bricks_body.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/plane.hpp"
#include "physics/body/shapes_on_demand.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/bricks/own_bricks.hpp"
#include "physics/bricks/rigid_mass.hpp"
#include "physics/bricks/time_step.hpp"
#include "physics/state/cube_mass.hpp"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <stdexcept>

namespace physics {

using geometry::no_index;

namespace {

// Of D^-1 A, A a sum of K and M, D its diagonal: no sum over cubes has more than one of its cubes
// alone has (Wathen. Realistic eigenvalue bounds for the Galerkin mass matrix. IMA J. Numer. Anal.
// 7, 1987). A cube's depends on its Poisson ratio alone, and that of M is the same for all.
double largest_of_bricks(const geometry::Cubes& cubes, BrickElement element)
{
    std::vector<double> ratios = cubes.poisson;
    std::sort(ratios.begin(), ratios.end());
    ratios.erase(std::unique(ratios.begin(), ratios.end()), ratios.end());
    // It grows with the ratio where that is large, and falls where it is small: the ends bound it.
    double most = 1 / cube_mass_matrix()[0][0] / 8;
    for (const double poisson : {ratios.front(), ratios.back()}) {
        const BrickMatrix k = brick_stiffness(1, lame(1, poisson), element);
        const Eigen::SelfAdjointEigenSolver<BrickMatrix> eigen(k, Eigen::EigenvaluesOnly);
        most = std::max(most, eigen.eigenvalues()[23] / k(0, 0));
    }
    return most;
}

void check_law(const geometry::Cubes& cubes, const BrickOptions& options)
{
    if (options.law == BrickLaw::corotated) return;
    if (options.plastic.yield > 0) {
        throw std::invalid_argument(
            "bricks: law = neo_hookean is elastic, and plastic.yield is above 0. Set plastic.yield "
            "to 0, or law to corotated");
    }
    if (!cubes.own.empty()) {
        throw std::invalid_argument(
            "bricks: law = neo_hookean needs cubes of one material each, and some of these have a "
            "stiffness matrix of their own. Set Voxelize stiffness to filled, or law to corotated");
    }
}

// What the mass matrix of bricks lacks of the lumped one; that of one-point bricks is lumped.
void add_excess(const geometry::Cubes& cubes, BricksBody& body)
{
    if (body.element == BrickElement::one_point) return;
    const std::size_t lanes = body.layout.cube.size();
    const CubeMass usual = cube_mass_matrix();
    const bool damped = !body.base.mass_damping.empty();
    body.excess.assign(lanes, 0);
    body.excess_diagonal.assign(cubes.corner_count(), 0);
    if (damped) {
        body.damped_excess.assign(lanes, 0);
        body.damped_excess_diagonal.assign(cubes.corner_count(), 0);
    }
    for (std::size_t i = 0; i < lanes; ++i) {
        const std::uint32_t c = body.layout.cube[i];
        if (c == no_index) continue;
        body.excess[i] = cubes.mass[c] / 64;
        if (damped) body.damped_excess[i] = cubes.mass_damping[c] * body.excess[i];
        const CubeMass mass = mass_of_cube(cubes, c, usual);
        const auto share = geometry::corner_shares(cubes, c);
        for (std::size_t a = 0; a < 8; ++a) {
            const std::size_t at = body.base.slot_of(cubes.corners[c][a]);
            const double lacks = (share[a] - mass[a][a]) * cubes.mass[c];
            body.excess_diagonal[at] += lacks;
            if (damped) body.damped_excess_diagonal[at] += lacks * cubes.mass_damping[c];
        }
    }
}

// The force on one corner moved along one axis, over h / 16: each monomial of the transform has 1
// there.
double on_one_corner(Lame material, BrickElement element)
{
    const auto [lambda, mu] = material;
    const double third = third_modulus(material, element), middle = (2 * mu + lambda) + 2 * mu;
    if (element == BrickElement::one_point) return middle + (2 * third + mu) / 3 + 4 * mu / 9;
    const double plain = element == BrickElement::trilinear ? 1 : 0;
    return middle + (2 * (2 + plain) * mu + 2 * third + 2 * mu) / 3 +
           (4 * mu + (element == BrickElement::relaxed ? third : lambda)) / 9;
}

// Adds numbers (N/m) at the corners of cube `c` to the stiffness' diagonal.
void add_diagonal(const geometry::Cubes& cubes, std::size_t c, const std::array<double, 8>& numbers,
                  BricksBody& body)
{
    for (std::size_t a = 0; a < 8; ++a) {
        const std::size_t at = body.base.slot[cubes.corners[c][a]];
        body.diagonal[at] += numbers[a];
        body.damping_diagonal[at] += numbers[a] * cubes.stiffness_damping[c];
    }
}

// In place of what they had, cubes get a stiffness of their own where they have one.
void add_own(const BodyModels& models, const BrickOptions& options,
             const std::vector<std::uint8_t>& rigid, BricksBody& body)
{
    const geometry::Cubes& cubes = models.all();
    if (cubes.own.empty()) return;
    const CubeMass usual = cube_mass_matrix();
    body.own = make_own_bricks(cubes, body.layout, body.block_edge, body.element, options.weighting,
                               rigid);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (!cubes.is_own(c) || (!rigid.empty() && rigid[c] != 0)) continue;
        const BrickMatrix k = stiffness_of(cubes.elements[cubes.own[c]]);
        std::array<double, 8> numbers = corner_diagonal(k);
        for (double& number : numbers) number *= cubes.young[c] * models.edge_of(c);
        add_diagonal(cubes, c, numbers, body);
        const CubeMass mass = mass_of_cube(cubes, c, usual);
        body.largest_eigenvalue =
            std::max({body.largest_eigenvalue, largest_eigenvalue(k), largest_eigenvalue(mass)});
    }
}

// Of each cube, whether it keeps its shape; empty: none does. Marks their parts.
std::vector<std::uint8_t> mark_rigid(const BodyModels& models, const BrickOptions& options,
                                     CornerBody& body)
{
    const auto& rigid = options.rigid;
    if (std::all_of(rigid.begin(), rigid.end(), [](auto is) { return is == 0; })) return {};
    if (rigid.size() > models.count()) {
        throw std::invalid_argument("bricks: expected a mark of rigid for each of " +
                                    std::to_string(models.count()) + " models at most, found " +
                                    std::to_string(rigid.size()));
    }
    const geometry::Cubes& cubes = models.all();
    std::vector<std::uint8_t> out(cubes.count(), 0);
    body.rigid.assign(body.parts, 0);
    for (std::size_t m = 0; m < rigid.size(); ++m) {
        for (auto c = models.start(m).cube; rigid[m] != 0 && c < models.start(m + 1).cube; ++c) {
            out[c] = body.rigid[body.part_of(body.slot_of(cubes.corners[c][0]))] = 1;
        }
    }
    return out;
}

// The first cubes of models whose cubes have another size than those before.
std::vector<std::uint32_t> where_sizes_change(const BodyModels& models)
{
    std::vector<std::uint32_t> out;
    for (std::size_t m = 1; m < models.count(); ++m) {
        if (models.model(m).cubes->size == models.model(m - 1).cubes->size) continue;
        out.push_back(models.start(m).cube);
    }
    return out;
}

}  // namespace

BricksBody make_bricks(const geometry::Cubes& cubes, const BrickOptions& options,
                       const geometry::TriMesh* surface)
{
    return make_bricks(BodyModels(cubes, surface), options);
}

BricksBody make_bricks(const BodyModels& models, const BrickOptions& options)
{
    const geometry::Cubes& cubes = models.all();
    geometry::need_thickness(cubes, "method bricks");
    check_plastic(options.plastic);
    check_law(cubes, options);
    BricksBody body;
    body.law = options.law, body.plastic = options.plastic;
    body.layout = lay_out_bricks(cubes, 1024, where_sizes_change(models));
    body.base = make_corner_body(models, body.layout.slot);
    const auto rigid = mark_rigid(models, options, body.base);
    give_shapes(models, options.contact, body.base);
    body.element = element_of(cubes, options.element);
    weigh_rigid_parts(models, body.has_brick_mass() ? MassOf::bricks : MassOf::corners, body.base);
    body.cubes = cubes.count();
    body.neighbours = find_neighbours(cubes);
    body.rest = std::make_shared<const geometry::Cubes>(cubes);
    body.factors = std::make_shared<FactorCache>();
    body.multigrids = std::make_shared<MultigridCache>();
    body.dissections = std::make_shared<DissectionCache>();
    add_excess(cubes, body);
    body.largest_eigenvalue = largest_of_bricks(cubes, body.element);
    body.turns_with.assign(body.base.corners, 0);
    const std::size_t lanes = body.layout.cube.size();
    body.stiffness.assign(3 * lanes, 0);
    body.material.assign(2 * lanes, 0);
    body.stiffness_damping.assign(lanes, 0);
    body.block_edge.assign(body.layout.blocks(), 0);
    body.diagonal.assign(cubes.corner_count(), 0);
    body.damping_diagonal.assign(cubes.corner_count(), 0);
    for (std::size_t i = 0; i < lanes; ++i) {
        const std::uint32_t c = body.layout.cube[i];
        if (c == no_index) continue;
        const auto [lambda, mu] = lame(cubes.young[c], cubes.poisson[c]);
        const double third = third_modulus({lambda, mu}, body.element);
        const double edge = models.edge_of(c);
        const bool bends = rigid.empty() || rigid[c] == 0;  // nothing asks what rigid ones resist
        const double share = bends ? stiffness_share(cubes, c, options.weighting) * edge / 16 : 0;
        const std::size_t block = i / block_lanes, lane = i % block_lanes;
        body.block_edge[block] = edge;
        double* k = &body.stiffness[block * 3 * block_lanes + lane];
        k[0] = share * mu;
        k[block_lanes] = share * lambda;
        k[2 * block_lanes] = share * third;
        double* m = &body.material[block * 2 * block_lanes + lane];
        m[0] = mu;
        m[block_lanes] = lambda;
        body.stiffness_damping[i] = cubes.stiffness_damping[c];
        const double one = share * on_one_corner({lambda, mu}, body.element);
        for (const auto corner : cubes.corners[c]) {
            body.turns_with[body.base.slot[corner]] =
                static_cast<std::uint32_t>(block * 9 * block_lanes + lane);
        }
        std::array<double, 8> at_corners;
        at_corners.fill(cubes.is_own(c) ? 0 : one);
        add_diagonal(cubes, c, at_corners, body);
    }
    add_own(models, options, rigid, body);
    return body;
}

std::size_t BricksBody::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return sizeof *this - sizeof base + base.bytes() +
           of(block_edge, layout.slot, layout.cube, layout.gather, layout.scatter, layout.copy_at,
              layout.copy, layout.pieces, stiffness, material, stiffness_damping, diagonal,
              damping_diagonal, neighbours, excess, damped_excess, excess_diagonal,
              damped_excess_diagonal, own.at, own.matrices, own.matrices_low, own.mass,
              own.mass_low);
}

State rest_state(const BricksBody& body)
{
    State state = rest_state(body.base);
    state.brick_mass = body.has_brick_mass();
    state.stress.assign(body.cubes, 0.0f);
    state.energy.assign(body.cubes, 0.0f);
    if (body.plastic.yield > 0) state.plastic_strain.assign(body.cubes, 0.0f);
    return state;
}

}  // namespace physics

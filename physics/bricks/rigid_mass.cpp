#include "physics/bricks/rigid_mass.hpp"

#include "physics/body/make_part_shapes.hpp"
#include "physics/state/cube_mass.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::MassProperties;
using geometry::Mat3;

using Ten = Eigen::Matrix<double, 10, 1>;

// What mass, centre and second moments are linear in: of a place in units of `size` about `origin`.
Ten moments_of(const Vec3& place, const Vec3& origin, double size)
{
    const Vec3 p = (place - origin) / size;
    Ten out;
    out << 1, p, p.x() * p.x(), p.y() * p.y(), p.z() * p.z(), p.x() * p.y(), p.y() * p.z(),
        p.z() * p.x();
    return out;
}

Ten second_moments(const Mat3& m)
{
    Ten out = Ten::Zero();
    out.tail<6>() << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(2, 0);
    return out;
}

struct Part {
    std::vector<std::uint32_t> slots;
    double mass = 0, volume = 0;  // kg, m^3, of its cubes
    double least = 0, most = 0;   // kg/m^3
    Mat3 between = Mat3::Zero();  // kg m^2: by which the lumped second moments exceed bricks'
};

// What the cubes of rigid parts hold.
std::vector<Part> parts_of(const BodyModels& models, const CornerBody& body, MassOf mass_of)
{
    constexpr double thin = 0.1;  // a fill below says little of the density
    const Cubes& cubes = models.all();
    const CubeMass usual = cube_mass_matrix();
    std::vector<Part> out(body.parts);
    for (std::uint32_t k = 0; k < body.corners; ++k) {
        const auto p = body.part_of(k);
        if (body.rigid[p] != 0) out[p].slots.push_back(k);
    }
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const auto p = body.part_of(body.slot_of(cubes.corners[c][0]));
        if (body.rigid[p] == 0) continue;
        Part& part = out[p];
        const double edge = models.edge_of(c), volume = cubes.fill[c] * edge * edge * edge;
        part.mass += cubes.mass[c], part.volume += volume;
        if (cubes.fill[c] > thin) {
            const double density = cubes.mass[c] / volume;
            part.least = part.most == 0 ? density : std::min(part.least, density);
            part.most = std::max(part.most, density);
        }
        if (mass_of == MassOf::corners) continue;
        const CubeMass mass = mass_of_cube(cubes, c, usual);
        const auto share = geometry::corner_shares(cubes, c);
        const auto at = [&](std::size_t a) {
            return Vec3(Eigen::Map<const Vec3>(&body.rest[4 * body.slot_of(cubes.corners[c][a])]));
        };
        const Vec3 middle = at(0);
        for (std::size_t a = 0; a < 8; ++a) {
            const Vec3 p_a = at(a) - middle;
            part.between += cubes.mass[c] * share[a] * p_a * p_a.transpose();
            for (std::size_t b = 0; b < 8; ++b) {
                part.between -= cubes.mass[c] * mass[a][b] * p_a * (at(b) - middle).transpose();
            }
        }
    }
    return out;
}

// Factors exp(l . phi) of some masses with which the sums of their moments phi (columns) are what
// is `wanted`: of all that have these sums, those nearest to 1 by relative entropy. They are where
//   sum_k m_k exp(l . phi_k) - l . wanted
// is lowest, which is convex in l; by Newton's method. Empty: none were found.
Eigen::VectorXd factors_of(const Eigen::VectorXd& masses, const Eigen::MatrixXd& phi,
                           const Eigen::VectorXd& wanted)
{
    constexpr int most = 100;
    const double close = 1e-12 * wanted.cwiseAbs().maxCoeff();
    Eigen::VectorXd l = Eigen::VectorXd::Zero(phi.rows());
    const auto at = [&](const Eigen::VectorXd& place) {
        return Eigen::VectorXd((phi.transpose() * place).array().exp());
    };
    const auto value = [&](const Eigen::VectorXd& place) {
        return masses.dot(at(place)) - place.dot(wanted);
    };
    for (int i = 0; i < most; ++i) {
        const Eigen::VectorXd factors = at(l), mass = masses.cwiseProduct(factors);
        const Eigen::VectorXd slope = phi * mass - wanted;
        if (slope.cwiseAbs().maxCoeff() <= close) return factors;
        const Eigen::MatrixXd curve = phi * mass.asDiagonal() * phi.transpose();
        const Eigen::VectorXd step = curve.completeOrthogonalDecomposition().solve(-slope);
        double share = 1;
        const double now = value(l);
        while (share > 1e-6 && !(value(l + share * step) <= now + 1e-4 * share * slope.dot(step))) {
            share /= 2;
        }
        if (!(share > 1e-6)) {
            return slope.cwiseAbs().maxCoeff() <= 1e3 * close ? factors : Eigen::VectorXd();
        }
        l += share * step;
    }
    return {};
}

// Gives a part's corners the moments of a solid.
void weigh(const Part& part, const MassProperties& solid, CornerBody& body)
{
    constexpr double same = 0.01, least = 1e-4;
    if (!(part.volume > 0 && part.most - part.least <= same * part.most)) return;
    if (!(solid.mass > 0.8 * part.volume && solid.mass < 1.25 * part.volume)) return;
    const double density = part.mass / solid.mass, size = std::cbrt(part.volume);
    // Of inertia I = tr(S) - S: S = tr(I) / 2 - I.
    const Mat3 second = density * (0.5 * solid.inertia.trace() * Mat3::Identity() - solid.inertia);
    Ten wanted = second_moments((second + part.between) / (size * size));
    wanted[0] = part.mass;
    const auto n = static_cast<Eigen::Index>(part.slots.size());
    Eigen::VectorXd masses(n);
    Eigen::MatrixXd moments(10, n);
    for (Eigen::Index i = 0; i < n; ++i) {
        const std::size_t slot = part.slots[static_cast<std::size_t>(i)];
        masses[i] = body.mass[slot];
        moments.col(i) =
            moments_of(Eigen::Map<const Vec3>(&body.rest[4 * slot]), solid.centre, size);
    }
    // All, or mass and centre.
    for (const Eigen::Index some : {10, 4}) {
        const auto factors = factors_of(masses, moments.topRows(some), wanted.head(some));
        if (factors.size() == 0 || !(factors.minCoeff() > least)) continue;
        for (Eigen::Index i = 0; i < n; ++i) {
            const auto slot = part.slots[static_cast<std::size_t>(i)];
            body.mass[slot] *= factors[i];
            if (!body.mass_damping.empty()) body.mass_damping[slot] *= factors[i];
        }
        return;
    }
}

}  // namespace

void weigh_rigid_parts(const BodyModels& models, MassOf mass_of, CornerBody& body)
{
    if (body.rigid.empty()) return;
    const auto parts = parts_of(models, body, mass_of);
    const auto solids = solids_of_rigid_parts(models, body);
    for (std::size_t p = 0; p < body.parts; ++p) {
        if (body.rigid[p] != 0) weigh(parts[p], solids[p], body);
    }
}

}  // namespace physics

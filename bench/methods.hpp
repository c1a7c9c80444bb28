#pragma once

// The methods on cubes, and Bullet's soft bodies, as things that begin and go on.

#include "physics/bricks/bricks.hpp"
#include "physics/bricks/springs.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/state/choose_corners.hpp"

#include <BulletSoftBody/btSoftBody.h>

#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

namespace bench {

using namespace physics;
using geometry::Cubes;
using geometry::Vec3i;

constexpr double pi = std::numbers::pi;

// A method on some cubes: how to begin, how to go on.
struct Mover {
    std::string kind, setting;
    std::function<State()> begin;
    std::function<State(State, const Loads&, double dt, int substeps)> step;
    int substeps = 1;  // that its frame of 1/24 s takes
};

inline std::string name_of(BrickElement element)
{
    if (element == BrickElement::trilinear) return "bricks, trilinear";
    return element == BrickElement::one_point ? "finite differences" : "bricks";
}

// A body that is stepped implicitly, `rounds` of Newton's method a step.
template <class Body>
Mover stepped(const std::string& kind, Body made, const std::string& setting, int substeps,
              Integrator integrator, int rounds)
{
    auto body = std::make_shared<Body>(std::move(made));
    return {kind, setting, [=] { return rest_state(*body); },
            [=](State s, const Loads& loads, double dt, int n) {
                return advance(*body, std::move(s), loads, dt,
                               {.integrator = integrator,
                                .substeps = n,
                                .newton_iterations = rounds,
                                .tolerance = 1e-7});
            },
            substeps};
}

inline Mover bricks(const Cubes& cubes, const std::string& setting, int substeps,
                    Integrator integrator = Integrator::implicit_midpoint,
                    BrickElement element = BrickElement::incompatible)
{
    return stepped(name_of(element), make_bricks(cubes, {element}), setting, substeps, integrator,
                   2);
}

inline Mover springs(const Cubes& cubes, const std::string& setting, int substeps)
{
    return stepped("springs", make_springs(cubes), setting, substeps, Integrator::implicit_midpoint,
                   3);
}

// Solids are calibrated for bends, which most cases are.
inline LatticeOptions for_bends(int half_width)
{
    return {.half_width = half_width, .calibrate = Calibration::bending};
}

// As few substeps as make it as stiff as its material, times `more`.
inline Mover lattice(const Cubes& cubes, const std::string& setting, const LatticeOptions& options,
                     double more = 1)
{
    auto body = std::make_shared<LatticeBody>(make_lattice(cubes, options));
    const int substeps = int(std::ceil(more * least_substeps(*body, 1.0 / 24)));
    const bool flat = body->flat_axis >= 0;
    return {flat                                        ? "plane lattice"
            : options.calibrate == Calibration::stretch ? "lattice, calibrated by stretch"
                                                        : "lattice",
            setting, [=] { return rest_state(*body); },
            [=](State s, const Loads& loads, double dt, int n) {
                LatticeOptions o = options;
                o.substeps = n;
                return advance(*body, std::move(s), loads, dt, o);
            },
            substeps};
}

struct Beam {
    double length, edge;
    int across;  // cubes
    geometry::Matter matter;

    double size() const { return edge / across; }
    Cubes cubes() const
    {
        const int along = int(std::lround(length / size()));
        std::vector<Vec3i> cells;
        for (int z = 0; z < across; ++z) {
            for (int y = 0; y < across; ++y) {
                for (int x = 0; x < along; ++x) cells.emplace_back(x, y, z);
            }
        }
        return geometry::solid_cubes(std::move(cells), size(), matter);
    }
    double inertia() const { return std::pow(edge, 4) / 12; }
    double shear_share() const  // of the deflection, beyond bending
    {
        const double nu = matter.poisson, kappa = 10 * (1 + nu) / (12 + 11 * nu);
        const double g = matter.young / (2 * (1 + nu));
        return 3 * matter.young * inertia() / (length * length * kappa * g * edge * edge);
    }
    double tip(double load) const
    {
        return load * std::pow(length, 3) / (3 * matter.young * inertia()) * (1 + shear_share());
    }
    double frequency() const
    {
        return std::pow(1.875104, 2) / (2 * pi * length * length) *
               std::sqrt(matter.young * inertia() / (matter.density * edge * edge)) *
               (1 - shear_share() / 2);
    }
};

inline Loads held_root(const Cubes& cubes)
{
    Loads loads;
    loads.pins =
        pins_at(cubes, corners_at_end(cubes, 0, End::low, 0), geometry::Transform::Identity());
    return loads;
}

inline std::vector<std::uint32_t> tip_corners(const Cubes& cubes)
{
    return corners_at_end(cubes, 0, End::high, 0);
}

inline double mean_y(const State& state, const std::vector<std::uint32_t>& corners)
{
    double sum = 0;
    for (const auto k : corners) sum += state.x[k].y();
    return sum / double(corners.size());
}

// A force on the whole end face: small point forces on its corners would dent it.
inline void load_tip(Loads& loads, const Beam& beam, double load)
{
    Force f;
    f.kind = Force::Kind::point;
    f.force = Vec3(0, -load, 0);
    f.position = Vec3(beam.length, beam.edge / 2, beam.edge / 2);
    f.radius = 0.75 * beam.edge;
    loads.forces.push_back(f);
}

// How Bullet's soft body is set: it has no Young's modulus to give it.
struct BulletTerms {
    double pose = 0;       // how much its pose matching pulls
    double stiffness = 1;  // of its springs, 0 to 1: 1 is as stiff as its solver makes them
    double dt = 1.0 / 240;
};

// Bullet's soft body on the same lattice: springs along edges and diagonals, and pose matching.
class BulletBody {
public:
    BulletBody(const Cubes& cubes, const std::vector<std::uint32_t>& held, const BulletTerms& terms,
               double damping)
    {
        world_->m_gravity = btVector3(0, 0, 0);
        btAlignedObjectArray<btVector3> points;
        btAlignedObjectArray<btScalar> masses;
        const auto mass = geometry::corner_masses(cubes);
        for (std::size_t i = 0; i < cubes.corner_count(); ++i) {
            const Vec3 p = cubes.corner_position(i);
            points.push_back({btScalar(p[0]), btScalar(p[1]), btScalar(p[2])});
            masses.push_back(btScalar(mass[i]));
        }
        for (const auto k : held) masses[int(k)] = 0;
        body_ = std::make_unique<btSoftBody>(world_.get(), points.size(), &points[0], &masses[0]);
        std::vector<std::pair<std::uint32_t, std::uint32_t>> links;
        for (const auto& corners : cubes.corners) {
            for (const auto a : corners) {
                for (const auto b : corners) {
                    if (a < b) links.emplace_back(a, b);
                }
            }
        }
        std::sort(links.begin(), links.end());
        links.erase(std::unique(links.begin(), links.end()), links.end());
        body_->m_materials[0]->m_kLST = btScalar(terms.stiffness);
        for (const auto& [a, b] : links) body_->appendLink(int(a), int(b));
        body_->m_cfg.kDP = btScalar(damping);
        body_->m_cfg.piterations = 4;
        if (terms.pose > 0) {
            body_->m_cfg.kMT = btScalar(terms.pose);
            body_->setPose(false, true);
        }
    }
    void step(double dt)
    {
        body_->predictMotion(btScalar(dt));
        body_->solveConstraints();
        body_->integrateMotion();
    }
    btSoftBody& body() { return *body_; }
    const btSoftBody::tNodeArray& nodes() const { return body_->m_nodes; }
    void fall() { world_->m_gravity = btVector3(0, btScalar(-9.81), 0); }

private:
    std::unique_ptr<btSoftBodyWorldInfo> world_ = std::make_unique<btSoftBodyWorldInfo>();
    std::unique_ptr<btSoftBody> body_;
};

}  // namespace bench

#pragma once

// Cases of the page that engineers know: a body that tumbles, torsion, the elastica, and a thin
// strip that lies askew in the grid; beside bars of CalculiX on meshes that fit.

#include "bench/calculix.hpp"
#include "bench/error_page.hpp"
#include "bench/methods.hpp"
#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "geometry/mesh/transform.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/modal/calibrate.hpp"
#include "physics/modal/modes.hpp"
#include "physics/state/measure.hpp"

#include <iostream>
#include <map>

namespace bench {

inline Cubes block_of(const Vec3i& cells, double size, const geometry::Matter& matter)
{
    std::vector<Vec3i> all;
    for (int z = 0; z < cells.z(); ++z) {
        for (int y = 0; y < cells.y(); ++y) {
            for (int x = 0; x < cells.x(); ++x) all.emplace_back(x, y, z);
        }
    }
    return geometry::solid_cubes(std::move(all), size, matter);
}

inline void tell(const std::string& what, const Result& r)
{
    std::cerr << fmt::format("{} {:34} {:16} {:+.4g} %  {:.3g} ms\n", what, r.kind, r.setting,
                             100 * r.error, r.ms);
}

struct Turning {
    double energy = 0;
    Vec3 angular = Vec3::Zero();
};

inline Turning turning_of(const State& state, const Cubes& cubes)
{
    return {kinetic_energy(state, cubes), mass_moments(state, cubes).angular};
}

// A body that turns freely: how far its kinetic energy and its angular momentum leave what they
// were, at most, of themselves.
inline void tumbling_case(Page& page)
{
    const geometry::Matter rubber{"rubber", 1000, 1e6, 0.3, 0, 0};
    constexpr int frames = 240;
    constexpr double frame = 1.0 / 24;
    const Vec3 spin = Vec3(1, 0.2, 4).normalized() * (300 * pi / 180);
    const Cubes cubes = block_of({8, 4, 2}, 0.05, rubber);
    const auto places = geometry::corner_positions(cubes);
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : places) middle += p / double(places.size());
    std::vector<Result> energies, momenta;
    const auto keep = [&](const std::string& kind, const std::string& setting, double energy,
                          double angular, double ms) {
        energies.push_back({kind, setting, energy, ms});
        momenta.push_back({kind, setting, angular, ms});
        tell("tumbling, energy", energies.back());
        tell("tumbling, angular momentum", momenta.back());
    };
    const auto measure = [&](const Mover& mover) {
        State state = mover.begin();
        for (std::size_t k = 0; k < state.v.size(); ++k) {
            state.v[k] = spin.cross(places[k] - middle);
        }
        const Turning first = turning_of(state, cubes);
        double energy = 0, angular = 0;
        const double before = seconds();
        for (int f = 0; f < frames; ++f) {
            state = mover.step(std::move(state), {}, frame, mover.substeps);
            const Turning now = turning_of(state, cubes);
            const double off = now.energy / first.energy - 1;
            if (std::abs(off) > std::abs(energy)) energy = off;
            angular =
                std::max(angular, (now.angular - first.angular).norm() / first.angular.norm());
        }
        keep(mover.kind, mover.setting, energy, angular, 1e3 * (seconds() - before) / frames);
    };
    const std::map<Integrator, std::string> named{
        {Integrator::implicit_euler, "bricks, implicit Euler"},
        {Integrator::implicit_midpoint, "bricks, midpoint"},
        {Integrator::sdirk2, "bricks, SDIRK 2"}};
    for (const int steps : {1, 4}) {
        const std::string name = fmt::format("{} steps", steps);
        for (const auto& [integrator, kind] : named) {
            Mover mover = bricks(cubes, name, steps, integrator);
            mover.kind = kind;
            measure(mover);
        }
        measure(bricks(cubes, name, steps, Integrator::implicit_euler, BrickElement::one_point));
        Mover net = springs(cubes, name, steps);
        net.kind = "springs, midpoint";
        measure(net);
    }
    for (const int w : {1, 2}) {
        Mover mover = lattice(cubes, "", for_bends(w));
        mover.setting = fmt::format("w={} {} steps", w, mover.substeps);
        measure(mover);
    }
    for (const double pose : {0.0, 0.05}) {
        BulletBody body(cubes, {}, {.pose = pose}, 0);
        for (int k = 0; k < body.nodes().size(); ++k) {
            const Vec3 v = spin.cross(places[std::size_t(k)] - middle);
            body.body().m_nodes[k].m_v =
                btVector3(btScalar(v.x()), btScalar(v.y()), btScalar(v.z()));
        }
        const auto now = [&] {
            Turning out;
            for (int k = 0; k < body.nodes().size(); ++k) {
                const auto& node = body.nodes()[k];
                const Vec3 x(double(node.m_x.x()), double(node.m_x.y()), double(node.m_x.z()));
                const Vec3 v(double(node.m_v.x()), double(node.m_v.y()), double(node.m_v.z()));
                const double mass = 1 / double(node.m_im);
                out.energy += 0.5 * mass * v.squaredNorm();
                out.angular += mass * (x - middle).cross(v);
            }
            return out;
        };
        const Turning first = now();
        double energy = 0, angular = 0;
        const double before = seconds();
        for (int f = 0; f < frames; ++f) {
            for (int s = 0; s < 10; ++s) body.step(frame / 10);
            const Turning then = now();
            const double off = then.energy / first.energy - 1;
            if (std::abs(off) > std::abs(energy)) energy = off;
            angular =
                std::max(angular, (then.angular - first.angular).norm() / first.angular.norm());
        }
        keep(pose > 0 ? "Bullet pose matching" : "Bullet springs", "10 steps", energy, angular,
             1e3 * (seconds() - before) / frames);
    }
    const std::string what = fmt::format(
        "A block of 8 x 4 x 2 cubes (0.4 m x 0.2 m x 0.1 m, E = 1 MPa, no damping) is let go at "
        "300 degrees/s about an axis that is none of its own, and tumbles for {} frames of 1/24 s. "
        "Nothing acts on it.",
        frames);
    page.plot("speed-tumbling", "A body that tumbles: its energy", "ms a frame of 1/24 s",
              what + " The error is the largest change of its kinetic energy, of what it was.",
              energies);
    page.plot("speed-tumbling-angular", "A body that tumbles: its angular momentum",
              "ms a frame of 1/24 s",
              what + " The error is the largest change of its angular momentum, as a vector; the "
                     "plot draws what is below 1e-5 at 1e-5.",
              momenta);
}

// How much a motion twists a bar about x: 0 for what bends or stretches it, about 1 for torsion.
// `at` and `move` are the same number of places and displacements.
inline double twist_of(const std::vector<Vec3>& at, const std::vector<Vec3>& move)
{
    Vec3 middle = Vec3::Zero();
    for (const Vec3& p : at) middle += p / double(at.size());
    std::map<long, double> section;
    double arms = 0, size = 0;
    for (std::size_t k = 0; k < at.size(); ++k) {
        const Vec3 r = at[k] - middle;
        section[std::lround(1e6 * r.x())] += r.y() * move[k].z() - r.z() * move[k].y();
        arms += r.y() * r.y() + r.z() * r.z();
        size += move[k].squaredNorm();
    }
    double sum = 0;
    for (const auto& [x, twist] : section) sum += twist * twist;
    return std::sqrt(sum * double(section.size()) / (arms * size));
}

// The first vibration that twists a free square bar.
inline void torsion_case(Page& page)
{
    const geometry::Matter rubber{"rubber", 1000, 1e6, 0.3, 0, 0};
    const double edge = 0.1, length = 0.8, j = 0.140577 * std::pow(edge, 4);
    const double polar = std::pow(edge, 4) / 6, shear = rubber.young / (2 * (1 + rubber.poisson));
    const double expected = std::sqrt(shear * j / (rubber.density * polar)) / (2 * length);
    std::vector<Result> results;
    const auto keep = [&](const std::string& kind, int n, double frequency, double ms) {
        results.push_back({kind, fmt::format("n={}", n), frequency / expected - 1, ms});
        tell("torsion", results.back());
    };
    for (const auto element :
         {BrickElement::incompatible, BrickElement::trilinear, BrickElement::one_point}) {
        for (const int n : {1, 2, 4, 8}) {
            const Cubes cubes = block_of({8 * n, n, n}, edge / n, rubber);
            const double before = seconds();
            const Modes modes = lowest_modes(cubes, {}, {.count = 5, .element = element});
            const double ms = 1e3 * (seconds() - before);
            std::size_t best = 0;
            double most = 0;
            const auto places = geometry::corner_positions(cubes);
            for (std::size_t m = 0; m < modes.shape.size(); ++m) {
                const double twist = twist_of(places, modes.shape[m]);
                if (twist > most) most = twist, best = m;
            }
            keep(name_of(element), n, std::sqrt(modes.omega_sq[best]) / (2 * pi), ms);
        }
    }
    for (const std::string element : {"C3D8", "C3D8I"}) {
        for (const int n : {1, 2, 4, 8}) {
            const calculix::Bar bar{
                {length, edge, edge}, {8 * n, n, n}, rubber.young, rubber.poisson, rubber.density};
            const double before = calculix::child_seconds();
            const auto modes = calculix::vibrations(bar, element, 11, 0.5, page.folder);
            const double ms = 1e3 * (calculix::child_seconds() - before);
            if (modes.empty()) continue;
            std::vector<Vec3> places;
            bar.each_node([&](int a, int b, int c) { places.push_back(bar.at(a, b, c)); });
            double most = 0, frequency = 0;
            for (const auto& mode : modes) {
                const double twist = twist_of(places, mode.shape);
                if (twist > most) most = twist, frequency = mode.frequency;
            }
            keep("CalculiX " + element, n, frequency, ms);
        }
    }
    page.plot("speed-torsion", "Torsion of a bar", "ms to find its 5 lowest vibrations",
              fmt::format(
                  "A free bar, 0.8 m long, square of 0.1 m with n cubes or elements across, E = 1 "
                  "MPa, nu = 0.3: the first vibration that twists it, {:.5g} Hz by Saint-Venant "
                  "(1 / 2 L sqrt(G J / rho I_p), J = 0.140577 a^4).",
                  expected),
              results);
}

// A strip that a dead load bends far, at rest.
inline void elastica_case(Page& page)
{
    const Beam wide{1, 0.025, 1, {"strip", 1000, 1e6, 0, 0, 0}};
    const double load = 10 * wide.matter.young * wide.inertia();
    const Vec3 expected(wide.length * (1 - 0.5549956), -wide.length * 0.8106090, 0);
    std::vector<Result> results;
    const auto keep = [&](const std::string& kind, const std::string& setting, const Vec3& end,
                          double ms) {
        results.push_back({kind, setting, (end - expected).norm() / expected.norm(), ms});
        tell("elastica", results.back());
    };
    for (const auto element :
         {BrickElement::incompatible, BrickElement::trilinear, BrickElement::one_point}) {
        for (const int n : {1, 2, 4}) {
            Beam beam = wide;
            beam.across = n;
            const Cubes cubes = beam.cubes();
            const BricksBody body = make_bricks(cubes, {element});
            Loads loads = held_root(cubes);
            load_tip(loads, beam, load);
            const double before = seconds();
            State state =
                settle(body, rest_state(body), loads, {.newton_iterations = 30, .tolerance = 1e-6});
            const double ms = 1e3 * (seconds() - before);
            const auto tip = tip_corners(cubes);
            Vec3 end = Vec3::Zero();
            for (const auto k : tip) end += state.x[k] / double(tip.size());
            keep(name_of(element), fmt::format("n={}", n),
                 end - Vec3(0, beam.edge / 2, beam.edge / 2), ms);
        }
    }
    for (const std::string element : {"C3D8", "C3D8I"}) {
        for (const int n : {1, 2, 4}) {
            const calculix::Bar bar{{wide.length, wide.edge, wide.edge},
                                    {40 * n, n, n},
                                    wide.matter.young,
                                    0,
                                    wide.matter.density,
                                    true};
            const double before = calculix::child_seconds();
            const Vec3 end = calculix::pulled_end(bar, element, {0, -load, 0}, 0.1, page.folder);
            if (!end.allFinite()) continue;
            keep("CalculiX " + element, fmt::format("n={}", n), end,
                 1e3 * (calculix::child_seconds() - before));
        }
    }
    page.plot("speed-elastica", "A strip bent far, at rest", "ms to solve",
              "Length 1 m, square of 1/40 m with n cubes or elements across, nu = 0, held at one "
              "end, with a dead load P across the other: P L^2 / E I = 10, at which the elastica's "
              "end lies at (0.4450044, -0.8106090) m. The error is the distance from there, of its "
              "own. Bricks find the shape as `initial_shape` = equilibrium does.",
              results);
}

// A thin strip askew in the grid: old and new ways to make its cubes.
inline void tilted_case(Page& page)
{
    const double length = 0.5, width = 0.04, thick = 0.02;
    const geometry::Matter matter{"strip", 1000, 1e9, 0.3, 0, 0};
    // By C3D8I of CalculiX on 200 x 16 x 8 elements.
    constexpr double expected = 81.781;
    geometry::TriMesh mesh = geometry::box({length, width, thick}, {25, 2, 1});
    geometry::move(mesh, geometry::placement({0, 0, 0}, {20, 20, 20}, {1, 1, 1}, {0, 0, 0}));
    const geometry::FaceMatter faces{{}, {matter}, {}};
    const auto voxelized = [&](const geometry::VoxelGrid& grid, double min_fill) {
        geometry::VoxelOptions options;
        options.min_fill = min_fill;
        return geometry::voxelize_solid(mesh, faces, geometry::Inside::winding, 0, grid, options);
    };
    std::vector<Result> results;
    const auto keep = [&](const std::string& kind, const std::string& setting, double frequency,
                          double ms) {
        results.push_back({kind, setting, frequency / expected - 1, ms});
        tell("tilted strip", results.back());
    };
    const auto measure = [&](const std::string& kind, double cube,
                             const std::function<Cubes(const geometry::VoxelGrid&)>& make,
                             BrickElement element) {
        const double before = seconds();
        const auto grid = geometry::fit_grid(geometry::triangle_bounds(mesh), cube * thick);
        const Modes modes = lowest_modes(make(grid), {}, {.count = 1, .element = element});
        keep(kind, fmt::format("h={:g}", cube), std::sqrt(modes.omega_sq[0]) / (2 * pi),
             1e3 * (seconds() - before));
    };
    const auto filled = [&](const geometry::VoxelGrid& grid) { return voxelized(grid, 0.02); };
    const auto calibrated_cubes = [&](const geometry::VoxelGrid& grid) {
        const int ratio = int(std::lround(4 * grid.size / thick));
        const Cubes fine = voxelized({grid.size / ratio, grid.origin, ratio * grid.cells}, 1e-3);
        Report report;
        return calibrated(voxelized(grid, 0.02), {fine, ratio}, {12}, report);
    };
    for (const double cube : {2.0, 1.0, 0.5, 0.25}) {
        measure("bricks, filled", cube, filled, BrickElement::incompatible);
        measure("trilinear, filled", cube, filled, BrickElement::trilinear);
        measure("finite differences, filled", cube, filled, BrickElement::one_point);
    }
    for (const double cube : {4.0, 2.0, 1.0}) {
        measure("bricks, calibrated", cube, calibrated_cubes, BrickElement::incompatible);
    }
    for (const std::string element : {"C3D8", "C3D8I"}) {
        for (const int n : {1, 2, 4}) {
            const calculix::Bar bar{{length, width, thick},
                                    {25 * n, 2 * n, n},
                                    matter.young,
                                    matter.poisson,
                                    matter.density};
            const double before = calculix::child_seconds();
            const auto modes = calculix::vibrations(bar, element, 7, 1, page.folder);
            if (modes.empty()) continue;
            keep("CalculiX " + element, fmt::format("n={}", n), modes[0].frequency,
                 1e3 * (calculix::child_seconds() - before));
        }
    }
    page.plot("speed-tilted", "A thin strip askew in the grid",
              "ms to make the cubes and find the vibration",
              fmt::format(
                  "A free strip of 0.5 m x 0.04 m x 0.02 m, turned by 20 degrees about three axes: "
                  "its first vibration, {:.5g} Hz by C3D8I of CalculiX on 200 x 16 x 8 elements. "
                  "Cubes of edge h thicknesses, filled as far as the strip covers them, or "
                  "calibrated (`Voxelize.stiffness`); the elements of CalculiX, n through the "
                  "thickness, are on a mesh that fits.",
                  expected),
              results);
}

}  // namespace bench

// Speed against error: every method on the same reference cases, in one run, as a page with plots.
//   speed_against_error_bench FOLDER    writes speed-against-error.md, and for each plot a table
//                                       (.csv) and a gnuplot program (.gp) that draws an .svg
//   speed_against_error_bench FOLDER CASE    of one case alone
// bench/speed_against_error builds it, runs it, draws the plots and puts all into docs/.
//
// Cases (the formulas are those of beam and plate theory):
//   beam       sag: cantilever, L/h = 20, square, tip load P: d = P L^3/(3EI) + P L/(kappa G A)
//              vibration: the same let go: f = (1.875104)^2/(2 pi L^2) sqrt(EI/(rho A)), less a
//              half of what shear adds to the deflection
//   plate      circular, clamped, load P in its middle: w = P a^2/(16 pi D), D = E t^3/(12(1-nu^2))
//   swing      a soft beam falls from level and swings: distance from the finest bricks at all
//              frames, over how far those went
//   tumbling, torsion, elastica, tilted    solid_cases.hpp
//   incompressible    Cook's membrane, and a thick cylinder under inner pressure
//              (nearly_incompressible.hpp): the equations of the elements alone

#include "bench/nearly_incompressible.hpp"
#include "bench/solid_cases.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/shell/shell.hpp"

#include <tbb/global_control.h>

#include <BulletSoftBody/btSoftBody.h>

#include <limits>

namespace {

using namespace bench;

std::string processor()
{
    std::ifstream info("/proc/cpuinfo");
    for (std::string line; std::getline(info, line);) {
        const auto colon = line.find(": ");
        if (line.starts_with("model name") && colon != line.npos) return line.substr(colon + 2);
    }
    return "an unknown processor";
}

// Deflection under the load, found by letting it settle; then the frequency of the free beam.
// `settled` starts a damped copy of the method, `free` the undamped one.
struct BeamFigures {
    double tip = 0;
    double frequency = std::numeric_limits<double>::quiet_NaN();  // unless it swings
    double sag_ms = 0;                                            // until settled
    double frame_ms = 0;                                          // of 1/24 s, swinging
};
BeamFigures measure_beam(const Beam& beam, const Mover& settled, const Mover& free, double load)
{
    const Cubes cubes = beam.cubes();
    const auto tip = tip_corners(cubes);
    Loads loads = held_root(cubes);
    load_tip(loads, beam, load);
    BeamFigures out;
    const double omega = 2 * pi * beam.frequency(), frame = 1.0 / 24;
    State state = settled.begin();
    const double start = mean_y(state, tip);
    double before = seconds();
    // Critically damped: e^-11 of the sag is left after 14 / omega or so.
    const int frames = int(std::ceil(14 / omega / frame));
    for (int f = 0; f < frames; ++f) {
        state = settled.step(std::move(state), loads, frame, settled.substeps);
    }
    out.sag_ms = 1e3 * (seconds() - before);
    out.tip = start - mean_y(state, tip);

    loads.forces.clear();
    for (Vec3& v : state.v) v.setZero();
    State swinging = free.begin();
    swinging.x = state.x;
    std::vector<double> crossings;
    double y = mean_y(swinging, tip) - start, time = 0;
    const double dt = 1 / beam.frequency() / 240;
    const int substeps = std::max(1, int(std::ceil(free.substeps * dt / frame)));
    before = seconds();
    int steps = 0;
    while (crossings.size() < 3 && steps < 1000) {
        swinging = free.step(std::move(swinging), loads, dt, substeps);
        ++steps;
        const double next = mean_y(swinging, tip) - start;
        if ((y < 0) != (next < 0)) crossings.push_back(time + dt * y / (y - next));
        y = next;
        time += dt;
    }
    out.frame_ms = 1e3 * (seconds() - before) / (steps * dt) * frame;
    if (crossings.size() == 3) out.frequency = 1 / (crossings[2] - crossings[0]);
    return out;
}

double mean_height(const BulletBody& body, const std::vector<std::uint32_t>& corners)
{
    double sum = 0;
    for (const auto k : corners) sum += double(body.nodes()[int(k)].m_x.y());
    return sum / double(corners.size());
}

// The body under a load at its tip, critically damped, as long as the other methods settle.
BulletBody settled_bullet(const Beam& beam, double load, const BulletTerms& terms)
{
    const Cubes cubes = beam.cubes();
    const auto tip = tip_corners(cubes);
    const double omega = 2 * pi * beam.frequency();
    BulletBody out(cubes, corners_at_end(cubes, 0, End::low, 0), terms,
                   std::min(1.0, 2 * omega * terms.dt));
    for (int s = 0; s < int(std::ceil(14 / omega / terms.dt)); ++s) {
        for (const auto k : tip) {
            out.body().addForce(btVector3(0, btScalar(-load / double(tip.size())), 0), int(k));
        }
        out.step(terms.dt);
    }
    return out;
}

// Bullet's terms with springs of the stiffness that sags as the beam does, by bisection.
BulletTerms tuned_bullet(const Beam& beam, double load, BulletTerms terms)
{
    const auto tip = tip_corners(beam.cubes());
    const double start = 0.5 * beam.edge;
    double low = 1e-4, high = 1;
    for (int i = 0; i < 14; ++i) {
        terms.stiffness = std::sqrt(low * high);
        const double sag = start - mean_height(settled_bullet(beam, load, terms), tip);
        (sag > beam.tip(load) ? low : high) = terms.stiffness;
    }
    return terms;
}

BeamFigures measure_bullet(const Beam& beam, double load, const BulletTerms& terms)
{
    const Cubes cubes = beam.cubes();
    const auto tip = tip_corners(cubes), held = corners_at_end(cubes, 0, End::low, 0);
    const auto mean = [&](const BulletBody& b) { return mean_height(b, tip); };
    const double dt = terms.dt;
    BeamFigures out;
    const double start = mean(BulletBody(cubes, held, terms, 0));
    double before = seconds();
    BulletBody settled = settled_bullet(beam, load, terms);
    out.sag_ms = 1e3 * (seconds() - before);
    out.tip = start - mean(settled);
    BulletBody free(cubes, held, terms, 0);
    for (int i = 0; i < free.body().m_nodes.size(); ++i) {
        free.body().m_nodes[i].m_x = settled.body().m_nodes[i].m_x;
    }
    std::vector<double> crossings;
    double y = mean(free) - start, time = 0;
    before = seconds();
    int steps = 0;
    while (crossings.size() < 3 && steps < int(4 / beam.frequency() / dt)) {
        free.step(dt);
        ++steps;
        const double next = mean(free) - start;
        if ((y < 0) != (next < 0)) crossings.push_back(time + dt * y / (y - next));
        y = next;
        time += dt;
    }
    out.frame_ms = 1e3 * (seconds() - before) / steps * 10;
    if (crossings.size() == 3) out.frequency = 1 / (crossings[2] - crossings[0]);
    return out;
}

// Bullet's soft body held at its root and let go, ten steps a frame. It is made anew by begin().
Mover bullet_fall(const Cubes& cubes, const std::string& kind, const std::string& setting,
                  const BulletTerms& terms)
{
    auto body = std::make_shared<std::unique_ptr<BulletBody>>();
    const auto held = corners_at_end(cubes, 0, End::low, 0);
    return {kind, setting,
            [=] {
                *body = std::make_unique<BulletBody>(cubes, held, terms, 0);
                (*body)->fall();
                State state;
                state.x = geometry::corner_positions(cubes);
                return state;
            },
            [=](State state, const Loads&, double dt, int n) {
                for (int i = 0; i < n; ++i) (*body)->step(dt / n);
                for (std::size_t k = 0; k < state.x.size(); ++k) {
                    const btVector3& x = (*body)->body().m_nodes[int(k)].m_x;
                    state.x[k] = Vec3(double(x.x()), double(x.y()), double(x.z()));
                }
                return state;
            },
            10};
}

// Static deflection and frequency from the lowest modes; the cost is that of stepping them.
BeamFigures measure_modes(const Beam& beam, double load, int count)
{
    const Cubes cubes = beam.cubes();
    const auto tip = tip_corners(cubes);
    BeamFigures out;
    double before = seconds();
    const Modes modes =
        lowest_modes(cubes, corners_at_end(cubes, 0, End::low, 0), {.count = count});
    out.sag_ms = 1e3 * (seconds() - before);
    for (std::size_t m = 0; m < modes.omega_sq.size(); ++m) {
        double push = 0;
        for (const auto k : tip) push += load / double(tip.size()) * modes.shape[m][k].y();
        out.tip += push * push / load / modes.omega_sq[m];
    }
    out.frequency = std::sqrt(modes.omega_sq[0]) / (2 * pi);
    // A frame: the sum of modes at every corner.
    std::vector<Vec3> x(cubes.corner_count());
    before = seconds();
    constexpr int rounds = 50;
    for (int r = 0; r < rounds; ++r) {
        for (std::size_t k = 0; k < x.size(); ++k) {
            x[k].setZero();
            for (std::size_t m = 0; m < modes.shape.size(); ++m) {
                x[k] += 1e-3 * r * modes.shape[m][k];
            }
        }
    }
    out.frame_ms = 1e3 * (seconds() - before) / rounds + 1e-9 * x[0].x();
    return out;
}

// The lowest modes let go under gravity: each swings about where it would hang,
//   q = p / omega^2 (1 - e^(-c t / 2) (cos w t + c / (2 w) sin w t)),   w^2 = omega^2 - c^2 / 4.
Mover modal_fall(const Cubes& cubes, const std::string& setting, int count)
{
    auto modes = std::make_shared<Modes>(
        lowest_modes(cubes, corners_at_end(cubes, 0, End::low, 0), {.count = count}));
    const auto rest = geometry::corner_positions(cubes);
    const auto mass = geometry::corner_masses(cubes);
    std::vector<double> push(modes->shape.size(), 0);
    for (std::size_t m = 0; m < push.size(); ++m) {
        for (std::size_t k = 0; k < rest.size(); ++k) {
            push[m] -= 9.81 * mass[k] * modes->shape[m][k].y();
        }
    }
    return {"modal", setting,
            [=] {
                State state;
                state.x = rest;
                return state;
            },
            [=](State state, const Loads&, double dt, int) {
                state.time += dt;
                state.x = rest;
                for (std::size_t m = 0; m < push.size(); ++m) {
                    const double omega_sq = modes->omega_sq[m], c = modes->damping[m];
                    const double w = std::sqrt(std::max(1e-12, omega_sq - c * c / 4));
                    const double q = push[m] / omega_sq *
                                     (1 - std::exp(-c * state.time / 2) *
                                              (std::cos(w * state.time) +
                                               c / (2 * w) * std::sin(w * state.time)));
                    for (std::size_t k = 0; k < rest.size(); ++k) {
                        state.x[k] += q * modes->shape[m][k];
                    }
                }
                return state;
            },
            1};
}

geometry::Matter damped(geometry::Matter matter, double mass_damping)
{
    matter.mass_damping = mass_damping;
    return matter;
}

void beam_cases(Page& page)
{
    const geometry::Matter rubber{"rubber", 1000, 1e6, 0.3, 0, 0};
    const double load = 0.02;
    std::vector<Result> sags, rings;
    const auto keep = [&](const Beam& beam, const std::string& kind, const std::string& setting,
                          const BeamFigures& f) {
        sags.push_back({kind, setting, f.tip / beam.tip(load) - 1, f.sag_ms});
        rings.push_back({kind, setting, f.frequency / beam.frequency() - 1, f.frame_ms});
        std::cerr << fmt::format("{:32} {:12} sag {:+.3f} %, frequency {:+.3f} %, {:.3g} ms\n",
                                 kind, setting, 100 * sags.back().error, 100 * rings.back().error,
                                 f.frame_ms);
    };
    for (const int n : {1, 2, 4}) {
        const Beam free{2, 0.1, n, rubber};
        const Beam slow{2, 0.1, n, damped(rubber, 4 * pi * free.frequency())};
        const Cubes f = free.cubes(), s = slow.cubes();
        const std::string name = fmt::format("n={}", n);
        const auto both = [&](const Mover& settled, const Mover& swinging) {
            keep(free, swinging.kind, swinging.setting,
                 measure_beam(free, settled, swinging, load));
        };
        both(bricks(s, name, 1), bricks(f, name, 1));
        for (const auto element : {BrickElement::trilinear, BrickElement::one_point}) {
            if (n == 4 && element == BrickElement::trilinear) continue;
            both(bricks(s, name, 1, Integrator::implicit_midpoint, element),
                 bricks(f, name, 1, Integrator::implicit_midpoint, element));
        }
        both(springs(s, name, 1), springs(f, name, 1));
        for (const int w : {1, 2, 3}) {
            if (n == 4 && w == 3) continue;
            const std::string with = fmt::format("n={} w={}", n, w);
            const LatticeOptions options = for_bends(w);
            both(lattice(s, with, options), lattice(f, with, options));
        }
        if (n < 4) {
            const LatticeOptions options{.half_width = 1, .calibrate = Calibration::stretch};
            both(lattice(s, name + " w=1", options), lattice(f, name + " w=1", options));
        }
        keep(free, "modal", name + ", 8 modes", measure_modes(free, load, 8));
        if (n < 4) {
            keep(free, "Bullet springs", name, measure_bullet(free, load, {}));
            // Its sag is right because it was tuned to be.
            const BeamFigures tuned = measure_bullet(free, load, tuned_bullet(free, load, {}));
            rings.push_back({"Bullet springs, tuned", name, tuned.frequency / free.frequency() - 1,
                             tuned.frame_ms});
            keep(free, "Bullet pose matching", name, measure_bullet(free, load, {.pose = 0.05}));
        }
    }
    const Beam beam{2, 0.1, 1, rubber};
    page.plot(
        "speed-sag", "A cantilever's sag", "ms until settled",
        fmt::format(
            "Length 2 m, square of 0.1 m with n cubes across, E = 1 MPa, nu = 0.3, {} N at "
            "its tip: Timoshenko's beam sags {:.6g} m. The beam is critically damped until "
            "it stands still, for 14 / omega seconds with any method. The cost of `modal` is that "
            "of computing its modes. Bullet's soft body has no Young's modulus: its springs "
            "are as stiff as its solver makes them (linear stiffness 1, 4 rounds, steps of "
            "1/240 s), and its pose matching pulls by 0.05. In the tables below its springs are "
            "also tuned, to the stiffness whose sag is right.",
            load, beam.tip(load)),
        sags);
    page.plot("speed-vibration", "Its first frequency", "ms a frame of 1/24 s",
              fmt::format("Released from there, without damping: {:.5g} Hz.", beam.frequency()),
              rings);
}

// Corners at the rim of a round plate, and the top one in its middle.
std::pair<std::vector<std::uint32_t>, std::uint32_t> rim_and_middle(const Cubes& cubes, double a)
{
    std::vector<std::uint32_t> rim;
    double best = 1e9;
    std::uint32_t middle = 0;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        const Vec3 p = cubes.corner_position(k);
        const double r = std::hypot(p.x(), p.z());
        if (r > a - 0.25 * cubes.size) rim.push_back(k);
        if (r - 1e-6 * p.y() < best) best = r - 1e-6 * p.y(), middle = k;
    }
    return {rim, middle};
}

// A load P at the middle pushes each mode by P phi there; the cost is that of finding them.
Result modal_plate(const Cubes& cubes, double a, double load, double expected)
{
    constexpr int count = 40;
    const auto [rim, middle] = rim_and_middle(cubes, a);
    const double before = seconds();
    const Modes modes = lowest_modes(cubes, rim, {.count = count});
    double sag = 0;
    for (std::size_t m = 0; m < modes.shape.size(); ++m) {
        const double phi = modes.shape[m][middle].y();
        sag += load * phi * phi / modes.omega_sq[m];
    }
    return {"modal", fmt::format("h={:g}, {} modes", cubes.size, count), sag / expected - 1,
            1e3 * (seconds() - before)};
}

void plate_case(Page& page)
{
    const double a = 1, t = 0.05, nu = 0.3, young = 1e6, density = 1000, load = 0.02, wide = 0.2;
    const double d = young * t * t * t / (12 * (1 - nu * nu));
    const double expected = load * a * a / (16 * pi * d);
    // omega = 10.2158 / a^2 sqrt(D / (rho t)), for the damping
    const double omega = 10.2158 / (a * a) * std::sqrt(d / (density * t));
    const geometry::Matter matter{"rubber", density, young, nu, 2 * omega, 0};
    std::vector<Result> results, broad;
    // P at the middle, or evenly over a disc of radius `over` there, whose plate sags
    //   w = P / (64 pi D) (4 a^2 - 4 c^2 ln(a / c) - 3 c^2).
    const auto measure = [&](const Cubes& cubes, const Mover& mover, double over = 0) {
        Loads loads;
        const auto [rim, middle] = rim_and_middle(cubes, a);
        loads.pins = pins_at(cubes, rim, geometry::Transform::Identity());
        Force f;
        f.kind = Force::Kind::point;
        f.force = Vec3(0, -load, 0);
        f.position = cubes.corner_position(middle);
        f.radius = 0.05;
        std::vector<std::uint32_t> disc;
        const auto mass = geometry::corner_masses(cubes);
        for (std::uint32_t k = 0; over > 0 && k < cubes.corner_count(); ++k) {
            const Vec3 p = cubes.corner_position(k);
            if (std::hypot(p.x(), p.z()) < over + 1e-6) disc.push_back(k);
        }
        if (disc.empty()) loads.forces.push_back(f);
        const auto columns = std::count_if(disc.begin(), disc.end(), [&, top = middle](auto k) {
            return cubes.corner[k].y() == cubes.corner[top].y();
        });
        const double c = std::sqrt(double(columns) * cubes.size * cubes.size / pi);
        const double sag = disc.empty() ? expected
                                        : load / (64 * pi * d) *
                                              (4 * a * a - 4 * c * c * std::log(a / c) - 3 * c * c);
        State state = mover.begin();
        const double start = state.x[middle].y(), before = seconds(), frame = 1.0 / 24;
        const int frames = int(std::ceil(14 / omega / frame));
        for (int i = 0; i < frames; ++i) {
            for (const auto k : disc) {
                state.v[k].y() -= load / double(disc.size()) / mass[k] * frame;
            }
            state = mover.step(std::move(state), loads, frame, mover.substeps);
        }
        auto& into = disc.empty() ? results : broad;
        into.push_back({mover.kind, mover.setting, (start - state.x[middle].y()) / sag - 1,
                        1e3 * (seconds() - before)});
        std::cerr << fmt::format("plate {:28} {:14} {:+.3f} %\n", mover.kind, mover.setting,
                                 100 * into.back().error);
    };
    for (const int layers : {1, 2}) {
        const double h = t / layers;
        const int n = int(std::ceil(a / h)) + 2;
        std::vector<Vec3i> cells;
        for (const auto& [i, j] : geometry::ellipse_cells(2 * n, 2 * n)) {
            for (int y = 0; y < layers; ++y) cells.emplace_back(i - n, y, j - n);
        }
        const Cubes cubes = geometry::solid_cubes(std::move(cells), h, matter);
        const std::string name = fmt::format("h={:g}", h);
        const Mover differences =
            bricks(cubes, name, 1, Integrator::implicit_midpoint, BrickElement::one_point);
        for (const Mover& mover : {bricks(cubes, name, 1), differences}) {
            measure(cubes, mover);
            if (layers == 1) measure(cubes, mover, wide);
        }
        if (layers > 1) continue;
        results.push_back(modal_plate(cubes, a, load, expected));
        measure(cubes, springs(cubes, name, 1));
        for (const int w : {1, 2}) {
            const Mover mover = lattice(cubes, fmt::format("h={:g} w={}", h, w), for_bends(w));
            measure(cubes, mover);
            measure(cubes, mover, wide);
        }
    }
    for (const double h : {0.1, 0.05}) {
        for (const int w : {1, 2, 3}) {
            // What is clamped is a ring as wide as regions reach.
            const int n = int(std::ceil(a / h)) + 2 * w + 1;
            const Cubes cubes = geometry::plane_cubes(geometry::ellipse_cells(2 * n, 2 * n),
                                                      {1, h, Vec3(-n * h, 0, -n * h)}, t, matter);
            const Mover mover = lattice(cubes, fmt::format("h={:g} w={}", h, w), for_bends(w));
            measure(cubes, mover);
            measure(cubes, mover, wide);
            if (w > 1) continue;
            const Mover thin = stepped("shell", make_shell(cubes), fmt::format("h={:g}", h), 1,
                                       Integrator::implicit_midpoint, 2);
            measure(cubes, thin);
            measure(cubes, thin, wide);
        }
    }
    page.plot(
        "speed-plate", "A clamped circular plate", "ms until settled",
        fmt::format(
            "Radius 1 m, thickness 0.05 m, E = 1 MPa, nu = 0.3, {} N in its middle: the thin plate "
            "sags {:.5g} m. Its rim is stepped, of cubes or cells of edge h, which alone changes "
            "the sag by about h / a. Regions of a plane blur curvature over their width, and the "
            "wider they are, the less they resist the motion of a single "
            "corner out of the sheet: a point load makes a dimple of w cells.",
            load, expected),
        results);
    page.plot(
        "speed-plate-broad", "The same plate under a broad load", "ms until settled",
        fmt::format("The same {} N evenly over a disc of radius c = {:g} m: no dimple. w = P / "
                    "(64 pi D) (4 a^2 - 4 c^2 ln(a / c) - 3 c^2), c that of the corners' "
                    "area.",
                    load, wide),
        broad);
}

void swing_case(Page& page)
{
    const geometry::Matter jelly{"jelly", 1000, 3e5, 0.3, 0, 0.002};
    constexpr int frames = 48;
    const double frame = 1.0 / 24;
    using Film = std::vector<std::vector<Vec3>>;
    // The corners of the coarsest beam, which all share, at every frame.
    const Cubes coarse = Beam{1.2, 0.1, 1, jelly}.cubes();
    const auto film = [&](const Cubes& cubes, const Mover& mover, double& ms) {
        std::vector<std::uint32_t> shared;
        const int ratio = int(std::lround(coarse.size / cubes.size));
        for (const Vec3i& at : coarse.corner) {
            for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
                if (cubes.corner[k] == ratio * at) shared.push_back(k);
            }
        }
        Loads loads = held_root(cubes);
        loads.forces.push_back({});
        Film out;
        State state = mover.begin();
        const double before = seconds();
        for (int f = 0; f < frames; ++f) {
            state = mover.step(std::move(state), loads, frame, mover.substeps);
            auto& shot = out.emplace_back();
            for (const auto k : shared) shot.push_back(state.x[k]);
        }
        ms = 1e3 * (seconds() - before) / frames;
        return out;
    };
    double unused = 0;
    const Cubes fine = Beam{1.2, 0.1, 3, jelly}.cubes();
    const Film reference = film(fine, bricks(fine, "", 24), unused);
    std::vector<Result> results;
    const auto measure = [&](const Cubes& cubes, const Mover& mover) {
        double ms = 0;
        const Film shots = film(cubes, mover, ms);
        double error = 0, size = 0;
        for (std::size_t f = 0; f < shots.size(); ++f) {
            for (std::size_t k = 0; k < shots[f].size(); ++k) {
                error += (shots[f][k] - reference[f][k]).squaredNorm();
                size += (reference[f][k] - coarse.corner_position(k)).squaredNorm();
            }
        }
        results.push_back({mover.kind, mover.setting, std::sqrt(error / size), ms});
        std::cerr << fmt::format("swing {:28} {:14} {:.3f} %\n", mover.kind, mover.setting,
                                 100 * results.back().error);
    };
    for (const int n : {1, 2}) {
        const Cubes cubes = Beam{1.2, 0.1, n, jelly}.cubes();
        for (const int substeps : {1, 2, 4, 8}) {
            const std::string name = fmt::format("n={} {} steps", n, substeps);
            measure(cubes, bricks(cubes, name, substeps));
            measure(cubes, bricks(cubes, name, substeps, Integrator::implicit_midpoint,
                                  BrickElement::one_point));
            if (n > 1) continue;
            Mover euler = bricks(cubes, name, substeps, Integrator::implicit_euler);
            euler.kind = "bricks, implicit Euler";
            measure(cubes, euler);
            measure(cubes, springs(cubes, name, substeps));
        }
        measure(cubes, modal_fall(cubes, fmt::format("n={} 8 modes", n), 8));
        const std::string name = fmt::format("n={} 10 steps", n);
        measure(cubes, bullet_fall(cubes, "Bullet springs", name, {}));
        const BulletTerms tuned = tuned_bullet(Beam{1.2, 0.1, n, jelly}, 0.02, {});
        measure(cubes, bullet_fall(cubes, "Bullet springs, tuned", name, tuned));
        measure(cubes, bullet_fall(cubes, "Bullet pose matching", name, {.pose = 0.05}));
        for (const int w : {1, 2, 3}) {
            for (const double more : {1.0, 2.0}) {
                Mover mover = lattice(cubes, "", for_bends(w), more);
                mover.setting = fmt::format("n={} w={} {} steps", n, w, mover.substeps);
                measure(cubes, mover);
            }
        }
    }
    page.plot(
        "speed-swing", "A soft beam falls and swings", "ms a frame of 1/24 s",
        "1.2 m x 0.1 m x 0.1 m, E = 0.3 MPa, held level at one end and released under gravity: two "
        "seconds of large motion. Modes move along straight lines and cannot represent its "
        "rotation. The reference is a model of bricks of a third of the edge, with 24 steps a "
        "frame. The error "
        "is the distance from it of the corners that all models share, root mean square over these "
        "corners and 48 frames, divided by how far the reference moved.",
        results);
}

// A plane problem by bricks on cubes of several sizes and by CalculiX on meshes that fit.
std::vector<Result>
measure_plane(const incompressible::Problem& problem, const std::vector<double>& sizes,
              double expected, const std::function<double(int n, const std::string& element)>& ccx,
              const std::vector<int>& meshes)
{
    std::vector<Result> out;
    const auto keep = [&](const std::string& kind, const std::string& setting, double u,
                          double ms) {
        out.push_back({kind, setting, u / expected - 1, ms});
        std::cerr << fmt::format("{:32} {:12} {:+.3f} %\n", kind, setting, 100 * out.back().error);
    };
    for (const auto element :
         {BrickElement::incompatible, BrickElement::trilinear, BrickElement::one_point}) {
        for (const double h : sizes) {
            const double before = seconds();
            const double u = incompressible::solve_cubes(problem, h, element);
            keep(name_of(element), fmt::format("h={:g}", h), u, 1e3 * (seconds() - before));
        }
    }
    for (const std::string element : {"C3D8", "C3D8I"}) {
        for (const int n : meshes) {
            const double before = calculix::child_seconds();
            const double u = ccx(n, element);
            if (!std::isfinite(u)) continue;
            keep("CalculiX " + element, fmt::format("n={}", n), u,
                 1e3 * (calculix::child_seconds() - before));
        }
    }
    return out;
}

void incompressible_cases(Page& page)
{
    const auto& folder = page.folder;
    page.plot(
        "speed-membrane", "Cook's membrane, nearly incompressible", "ms to solve",
        "A tapered panel, 48 wide, 44 high at its clamped and 16 at its loaded end, in plane "
        "strain: E = 70, nu = 0.4999, a load of 100 on its end. Its upper corner rises by "
        "27.75: C3D8I and C3D8R of CalculiX on up to 96 x 96 elements, extrapolated. Bricks are "
        "cubes of edge h that are filled as far as the panel covers them, so that its sloping "
        "rims are stairs. The elements of CalculiX are n x n, on a mesh that fits. Bricks, "
        "finite differences and C3D8I do not lock; trilinear bricks and C3D8 do.",
        measure_plane(incompressible::cook(), {4, 2, 1, 0.5}, 27.75,
                      [&](int n, const std::string& element) {
                          return incompressible::run_calculix(incompressible::cook_grid(n), element,
                                                              n, n, 1, folder);
                      },
                      {12, 24, 48, 96}));
    page.plot(
        "speed-cylinder", "A thick cylinder under inner pressure, nearly incompressible",
        "ms to solve",
        "Radii 3 and 9, a quarter in plane strain: E = 1000, nu = 0.4999, pressure 1. The inner "
        "radius grows by 5.06227e-3 (Lame). Bricks are cubes of edge h that are filled as far "
        "as the wall covers them, under the pressure of the true circle; what is measured is "
        "the mean along that. The elements of CalculiX are n x 2 n, on a mesh that fits.",
        measure_plane(incompressible::cylinder(), {1, 0.5, 0.25, 0.125}, 5.06227e-3,
                      [&](int n, const std::string& element) {
                          return incompressible::run_calculix(incompressible::cylinder_grid(n),
                                                              element, 0, 0, 0, folder);
                      },
                      {6, 12, 24, 48}));
}

}  // namespace

int main(int argc, char** argv)
{
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    Page page;
    page.folder =
        argc > 1 ? argv[1] : std::filesystem::temp_directory_path() / "speed-against-error";
    std::filesystem::create_directories(page.folder);
    page.text = fmt::format(
        "# Speed against error\n\nEvery method on the same reference cases, in one run; times are "
        "processor time on one thread ({}). `bench/speed_against_error` writes this page. A "
        "positive error of a sag means that the model is too soft; a positive error of a "
        "frequency, that it is too high. An error may cross zero as the grid is refined: a setting "
        "is called fastest, and is bold, by the worst error of its own and of all finer grids of "
        "the same method. Lattices of solids are calibrated for bends (`lattice.calibrate` = "
        "bending) where nothing else is said; [lattice-error.md](lattice-error.md) has the errors "
        "of all calibrations, and why `both` is the default. `aspic study` makes such a plot of "
        "any scene.\n\n",
        processor());
    const std::string only = argc > 2 ? argv[2] : "";
    const std::pair<const char*, void (*)(Page&)> cases[] = {
        {"beam", beam_cases},      {"plate", plate_case},
        {"swing", swing_case},     {"tumbling", tumbling_case},
        {"torsion", torsion_case}, {"elastica", elastica_case},
        {"tilted", tilted_case},   {"incompressible", incompressible_cases},
    };
    for (const auto& [name, measure] : cases) {
        if (only.empty() || only == name) measure(page);
    }
    std::ofstream(page.folder / "speed-against-error.md") << page.text;
    std::cout << (page.folder / "speed-against-error.md").string() << "\n";
}

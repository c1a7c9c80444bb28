// How far lattices are from their material, shape by shape, for each calibration and half width:
// what the default of `lattice.calibrate` of Simulate is chosen by.
//   lattice_error_bench > docs/lattice-error.md    writes the page
//   lattice_error_bench NAME                       tables of the shapes whose name has NAME in it
//
// Loads are small, and steps as short as the material needs (enough_substeps()). A lattice comes to
// rest as its velocities are taken off whenever its kinetic energy falls.

#include "geometry/cubes/plane.hpp"
#include "physics/bricks/settle.hpp"
#include "physics/lattice/lattice.hpp"
#include "physics/state/choose_corners.hpp"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <iostream>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

namespace {

using namespace physics;
using geometry::Cubes;
using geometry::Vec3i;

constexpr double edge = 0.1, young = 1e6, density = 1000;

struct Box {
    Vec3i low, high;  // in cubes
};

using Where = std::function<bool(const Vec3&)>;  // of places in cubes

// A body, where it is held, along what its weight pulls, and what is measured: the mean
// displacement along the weight of the corners at `seen`.
struct Case {
    std::string name;
    std::vector<Box> boxes;
    Vec3 pull;  // N/kg
    Where held, seen;
    double poisson = 0.3;
    bool swings = false;                  // its lowest frequency is measured then
    double plane = 0;                     // m, thickness of a plane; 0: a solid
    std::optional<double> expected = {};  // m, or Hz; without: by bricks
};

bool at(double v, double place)
{
    return std::abs(v - place) < 1e-6;
}

geometry::Matter matter_of(const Case& c)
{
    return {"matter", density, young, c.poisson, 0, 0};
}

// `finer`: cubes along the edge of one of the case's.
Cubes cubes_of(const Case& c, int finer)
{
    if (c.plane > 0) {
        geometry::Cells2 cells;
        for (int u = c.boxes[0].low.x(); u < c.boxes[0].high.x(); ++u) {
            for (int v = c.boxes[0].low.y(); v < c.boxes[0].high.y(); ++v) cells.push_back({u, v});
        }
        return geometry::plane_cubes(cells, {2, edge, {0, 0, 0}}, c.plane, matter_of(c));
    }
    std::vector<Vec3i> cells;
    for (const Box& box : c.boxes) {
        const Vec3i low = finer * box.low, high = finer * box.high;
        for (int z = low.z(); z < high.z(); ++z) {
            for (int y = low.y(); y < high.y(); ++y) {
                for (int x = low.x(); x < high.x(); ++x) cells.emplace_back(x, y, z);
            }
        }
    }
    return geometry::solid_cubes(std::move(cells), edge / finer, matter_of(c));
}

std::vector<std::uint32_t> corners_where(const Cubes& cubes, const Where& where)
{
    std::vector<std::uint32_t> out;
    for (std::uint32_t k = 0; k < cubes.corner_count(); ++k) {
        if (where(cubes.corner_position(k) / edge)) out.push_back(k);
    }
    return out;
}

double moved(const Case& c, const Cubes& cubes, const State& state)
{
    double sum = 0;
    const auto corners = corners_where(cubes, c.seen);
    for (const auto k : corners) {
        sum += (state.x[k] - cubes.corner_position(k)).dot(c.pull.normalized());
    }
    return sum / double(corners.size());
}

Loads loads_of(const Case& c, const Cubes& cubes)
{
    Loads loads;
    loads.pins = pins_at(cubes, corners_where(cubes, c.held), geometry::Transform::Identity());
    Force weight;
    weight.acceleration = c.pull;
    loads.forces.push_back(weight);
    return loads;
}

double by_bricks(const Case& c)
{
    const Cubes cubes = cubes_of(c, 2);
    const BricksBody body = make_bricks(cubes);
    const State state = settle(body, rest_state(body), loads_of(c, cubes),
                               {.newton_iterations = 20, .tolerance = 1e-6});
    return moved(c, cubes, state);
}

double kinetic(const LatticeBody& body, const State& state)
{
    double sum = 0;
    for (std::size_t k = 0; k < state.v.size(); ++k) {
        sum += body.base.mass[k] * state.v[k].squaredNorm();
    }
    return sum;
}

// A lattice under its loads, in short steps.
struct Motion {
    Motion(const Case& c, const LatticeOptions& with)
        : cubes(cubes_of(c, 1)), options(with), body(make_lattice(cubes, with)),
          loads(loads_of(c, cubes)), state(rest_state(body))
    {
        options.substeps = 10;
        constexpr double trial = 0.01;  // s
        dt = trial / enough_substeps(body, trial);
    }
    void go_on() { state = advance(body, std::move(state), loads, options.substeps * dt, options); }

    Cubes cubes;
    LatticeOptions options;
    LatticeBody body;
    Loads loads;
    State state;
    double dt = 0;  // s, of a substep
};

// Velocities are taken off at each peak of the kinetic energy, until the mean displacement of two
// peaks has stayed for a third of the time. Returns it.
double settle_lattice(const Case& c, Motion& motion)
{
    double before = 0, last = 0, mean = 0;
    int since = 0;  // frame from which on the mean is within 1e-3
    for (int frame = 1; frame <= 30000; ++frame) {
        motion.go_on();
        const double energy = kinetic(motion.body, motion.state);
        if (energy >= before) {
            before = energy;
            continue;
        }
        for (Vec3& v : motion.state.v) v.setZero();
        before = 0;
        const double now = moved(c, motion.cubes, motion.state), next = (now + last) / 2;
        last = now;
        if (std::abs(next - mean) > 1e-3 * std::abs(next)) {
            mean = next;
            since = frame;
        } else if (frame > 100 && 3 * since < 2 * frame) {
            return next;
        }
    }
    return mean;
}

// Hz, of the swing when the load that it rests under is let go.
double swing(const Case& c, Motion& motion)
{
    motion.loads.forces.clear();
    motion.options.substeps = 1;
    for (Vec3& v : motion.state.v) v.setZero();
    std::vector<double> crossings;
    double before = moved(c, motion.cubes, motion.state), time = 0;
    for (int step = 0; step < 200000 && crossings.size() < 3; ++step) {
        motion.go_on();
        time += motion.dt;
        const double now = moved(c, motion.cubes, motion.state);
        if ((now < 0) != (before < 0)) {
            crossings.push_back(time - motion.dt * now / (now - before));
        }
        before = now;
    }
    return 1 / (crossings.at(2) - crossings.at(0));
}

double by_lattice(const Case& c, const LatticeOptions& options)
{
    Motion motion(c, options);
    motion.options.damping = 0.2 * motion.dt;  // ends what is faster than peaks show
    const double rest = settle_lattice(c, motion);
    motion.options.damping = 0;
    return c.swings ? swing(c, motion) : rest;
}

// A column that hangs from its top, n x n cubes across.
Case column(int n, int length, double poisson = 0.3)
{
    return {fmt::format("column {0} x {0} x {1}, hanging", n, length),
            {{{0, 0, 0}, {n, length, n}}},
            {0, -1, 0},
            [=](const Vec3& p) { return at(p.y(), length); },
            [](const Vec3& p) { return at(p.y(), 0); },
            poisson};
}

// A beam that is held at x = 0, `thick` cubes high and `wide` across.
Case beam(int thick, int wide, int length)
{
    return {fmt::format("cantilever {} x {} x {}", thick, wide, length),
            {{{0, 0, 0}, {length, thick, wide}}},
            {0, -0.02 * thick * thick / length, 0},
            [](const Vec3& p) { return at(p.x(), 0); },
            [=](const Vec3& p) { return at(p.x(), length); }};
}

Case block(const std::string& name, const Vec3i& size, double poisson, int held_along)
{
    return {name,
            {{{0, 0, 0}, size}},
            {0, -2, 0},
            [=](const Vec3& p) { return at(p[held_along], 0); },
            [=](const Vec3& p) { return at(p[held_along], size[held_along]); },
            poisson};
}

Case plate(int thick, int side)
{
    return {fmt::format("plate {} x {} x {}, clamped", thick, side, side),
            {{{0, 0, 0}, {side, thick, side}}},
            {0, -0.1, 0},
            [=](const Vec3& p) {
                return at(p.x(), 0) || at(p.z(), 0) || at(p.x(), side) || at(p.z(), side);
            },
            [=](const Vec3& p) { return at(p.x(), side / 2) && at(p.z(), side / 2); }};
}

// An arm on a post whose foot is held.
Case gallows(int thick)
{
    const int high = 8 * thick, out = 6 * thick;
    return {fmt::format("post and arm, {} thick", thick),
            {{{0, 0, 0}, {thick, high, thick}}, {{thick, high - thick, 0}, {out, high, thick}}},
            {0, -0.02 * thick, 0},
            [](const Vec3& p) { return at(p.y(), 0); },
            [=](const Vec3& p) { return at(p.x(), out); }};
}

// A slab on four legs whose feet are held.
Case table(const std::string& name, const Vec3& pull)
{
    std::vector<Box> boxes = {{{0, 6, 0}, {8, 7, 8}}};
    for (const int x : {0, 7}) {
        for (const int z : {0, 7}) boxes.push_back({{x, 0, z}, {x + 1, 6, z + 1}});
    }
    return {name, boxes, pull, [](const Vec3& p) { return at(p.y(), 0); },
            [](const Vec3& p) { return at(p.x(), 4) && at(p.z(), 4) && p.y() > 5; }};
}

Case swinging(Case c)
{
    c.name += ", frequency";
    c.swings = true;
    return c;
}

Case plane_of(const std::string& name, int length, double thickness, const Vec3& pull)
{
    Case c{name,
           {{{-3, 0, 0}, {length, 8, 1}}},
           pull,
           [](const Vec3& p) { return p.x() < 1e-6; },
           [=](const Vec3& p) { return at(p.x(), length); }};
    c.poisson = 0;
    c.plane = thickness;
    return c;
}

// Closed forms of slender columns and beams, those of Timoshenko for the latter.
double hanging(double length)
{
    return density * length * length / (2 * young);
}
double hanging_frequency(double length)
{
    return std::sqrt(young / density) / (4 * length);
}
double shear_factor(double nu)
{
    return 10 * (1 + nu) / (12 + 11 * nu);
}
double beam_tip(double length, double thick, double pull, double nu)
{
    const double bend = 12 * density * pull * std::pow(length, 4) / (8 * young * thick * thick);
    const double shear = young / (2 * (1 + nu));
    return bend + density * pull * length * length / (2 * shear_factor(nu) * shear);
}
double beam_frequency(double length, double thick)
{
    return std::pow(1.875104 / length, 2) * std::sqrt(young / density / 12) * thick /
           (2 * std::numbers::pi);
}

std::vector<Case> solids()
{
    std::vector<Case> all = {column(1, 10), column(1, 20), column(2, 10), column(4, 12)};
    all[0].expected = hanging(10 * edge);
    all[1].expected = hanging(20 * edge);
    all.push_back(block("cube of 6, hanging", {6, 6, 6}, 0.3, 1));
    all.push_back(block("cube of 6, hanging, nu 0.45", {6, 6, 6}, 0.45, 1));
    all.push_back(block("slab 8 x 3 x 8, standing", {8, 3, 8}, 0.3, 1));
    all.push_back(block("cube of 6, held at a side", {6, 6, 6}, 0.3, 0));
    for (const auto& [thick, length] : {std::pair{1, 20}, {1, 10}, {2, 20}, {2, 10}, {4, 16}}) {
        all.push_back(beam(thick, thick, length));
        all.back().expected =
            beam_tip(length * edge, thick * edge, all.back().pull.norm(), all.back().poisson);
    }
    all.push_back(beam(1, 4, 16));
    all.push_back(plate(1, 16));
    all.push_back(plate(2, 24));
    all.push_back(block("plate 12 x 12 x 1, hanging", {12, 12, 1}, 0.3, 1));
    all.push_back(gallows(1));
    all.push_back(gallows(2));
    all.push_back(table("table, weighed down", {0, -0.5, 0}));
    all.push_back(table("table, pushed", {0.05, 0, 0}));
    all.push_back(swinging(beam(1, 1, 20)));
    all.back().expected = beam_frequency(20 * edge, edge);
    all.push_back(swinging(beam(2, 2, 20)));
    all.back().expected = beam_frequency(20 * edge, 2 * edge);
    all.push_back(swinging(column(1, 10)));
    all.back().expected = hanging_frequency(10 * edge);
    return all;
}

std::vector<Case> planes()
{
    const double length = 16 * edge, thickness = 0.2 * edge;
    std::vector<Case> all = {plane_of("plane, hanging", 16, thickness, {1, 0, 0}),
                             plane_of("plane, cantilever", 16, thickness, {0, 0, -0.0005})};
    all[0].expected = hanging(length);
    all[1].expected =
        12 * density * 0.0005 * std::pow(length, 4) / (8 * young * thickness * thickness);
    return all;
}

struct Setting {
    std::string name;
    Calibration calibrate;
    int half_width;
    double worst = 1, logs = 0;
};

void table_of(const std::vector<Case>& cases, std::vector<Setting> settings,
              const std::string& only)
{
    std::string titles = "| shape |", line = "|---|";
    for (const Setting& s : settings) {
        titles += fmt::format(" {} w={} |", s.name, s.half_width);
        line += "---:|";
    }
    std::cout << titles << "\n" << line << "\n";
    int count = 0;
    for (const Case& c : cases) {
        if (c.name.find(only) == std::string::npos) continue;
        ++count;
        const double expected = c.expected ? *c.expected : by_bricks(c);
        std::cout << "| " << c.name << " |";
        for (Setting& s : settings) {
            const double ratio =
                by_lattice(c, {.half_width = s.half_width, .calibrate = s.calibrate}) / expected;
            const double factor = std::max(ratio, 1 / ratio);
            s.worst = std::max(s.worst, factor);
            s.logs += std::log(factor);
            std::cout << fmt::format(" {:.2f} |", ratio) << std::flush;
        }
        std::cout << "\n";
    }
    if (count == 0) return;
    std::string mean = "| **off by, geometric mean** |", worst = "| **off by, worst** |";
    for (const Setting& s : settings) {
        mean += fmt::format(" **{:.2f}** |", std::exp(s.logs / count));
        worst += fmt::format(" **{:.2f}** |", s.worst);
    }
    std::cout << mean << "\n" << worst << "\n";
}

constexpr auto head =
    R"(# How far lattices are from their material

Written by `lattice_error_bench > docs/lattice-error.md`. Each number is what method `lattice` gives
over what the material gives: a displacement under the body's own weight, or a lowest frequency. 1 is
right; of displacements, 2 is twice too far. The material is a closed form (columns and cantilevers
one cube thick, square cantilevers, frequencies, planes) or bricks on cubes of half the edge. Sizes
are in cubes: a "cantilever 2 x 2 x 20" is 2 cubes thick, 2 wide and 20 long. Cubes of 0.1 m, E = 1
MPa, Poisson's ratio 0.3 where nothing else is said; as many substeps as the material needs
(`step.substeps` = 0). `w` is `lattice.half_width`.

The last rows are by how much a setting is off: the geometric mean over all shapes, of the number or
1 over it, whichever is larger, and the worst shape. `lattice.calibrate` = both has the least of each
at every half width, so it is the default. `bending` is right for a bend of the whole body only, and
`stretch` is not right for bends of what is one or two cubes thick.

## Solids

)";
constexpr auto head_of_planes = R"(
## Planes

A plane (node Plane) stretches and bends by a membrane and its regions, whatever `lattice.calibrate`
is. Cells of 0.1 m, 0.02 m thick, Poisson's ratio 0.

)";

}  // namespace

int main(int argc, char** argv)
{
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const std::string only = argc > 1 ? argv[1] : "";
    std::vector<Setting> all, of_planes;
    for (const int w : {1, 2, 3}) {
        all.push_back({"both", Calibration::both, w});
        all.push_back({"bending", Calibration::bending, w});
        all.push_back({"stretch", Calibration::stretch, w});
        of_planes.push_back({"plane", Calibration::both, w});
    }
    if (only.empty()) std::cout << head;
    table_of(solids(), all, only);
    if (only.empty()) std::cout << head_of_planes;
    table_of(planes(), of_planes, only);
}

#include "physics/body/corner_body.hpp"

#include "geometry/cubes/components.hpp"
#include "physics/math/for_numbers.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

namespace physics {
namespace {

void need(bool good, const std::string& what)
{
    if (!good) throw std::invalid_argument("the cubes cannot be simulated: " + what);
}

void check_cube(const geometry::Cubes& cubes, std::size_t c)
{
    // Each sentence is only put together for the number that needs it.
    const auto expect = [&](bool good, const char* what, double value) {
        if (good) return;
        need(false, "cube " + std::to_string(c) + ": expected " + what + ", found " +
                        std::to_string(value));
    };
    const auto sound = [](double v) { return std::isfinite(v) && v >= 0; };
    for (const auto k : cubes.corners[c]) {
        expect(k < cubes.corner_count(), "corners that exist", k);
    }
    expect(sound(cubes.mass[c]), "a mass of at least 0 kg", cubes.mass[c]);
    expect(sound(cubes.fill[c]), "a fill of at least 0", cubes.fill[c]);
    expect(sound(cubes.young[c]) && cubes.young[c] > 0, "a Young's modulus above 0 Pa",
           cubes.young[c]);
    expect(cubes.poisson[c] > -1 && cubes.poisson[c] < 0.5, "a Poisson ratio between -1 and 0.5",
           cubes.poisson[c]);
    expect(sound(cubes.mass_damping[c]), "a mass damping of at least 0", cubes.mass_damping[c]);
    expect(sound(cubes.stiffness_damping[c]), "a stiffness damping of at least 0",
           cubes.stiffness_damping[c]);
}

void check_grid(const geometry::Cubes& cubes)
{
    need(std::isfinite(cubes.size) && cubes.size > 0,
         "expected an edge above 0 m, found " + std::to_string(cubes.size));
    need(cubes.origin.allFinite(), "their origin is not finite");
}

void check(const geometry::Cubes& cubes)
{
    const std::size_t n = cubes.count();
    need(n > 0, "there are none. Is the model empty, or was every cube removed?");
    for (const std::size_t length :
         {cubes.corners.size(), cubes.mass.size(), cubes.fill.size(), cubes.young.size(),
          cubes.poisson.size(), cubes.mass_damping.size(), cubes.stiffness_damping.size()}) {
        need(length == n, "expected " + std::to_string(n) + " entries in every array, found " +
                              std::to_string(length));
    }
    geometry::check_elements(cubes);
    double total = 0;
    for (std::size_t c = 0; c < n; ++c) {
        check_cube(cubes, c);
        total += cubes.mass[c];
    }
    need(std::isfinite(total) && total > 0, "expected a total mass above 0 kg, found " +
                                                std::to_string(total) +
                                                ". Give the material a density");
}

// The edge of each part's cubes, where they differ.
std::vector<double> edges_of_parts(const BodyModels& models, const std::vector<std::uint32_t>& part,
                                   std::size_t parts)
{
    if (models.alike()) return {};
    std::vector<double> out(parts, 0);
    for (std::uint32_t c = 0; c < part.size(); ++c) out[part[c]] = models.edge_of(c);
    return out;
}

// A corner without mass has no equation of motion: it gets a millionth of the mean of its part, or
// of all where the part has none.
void raise_masses(CornerBody& body, double total)
{
    std::vector<double> mass(body.parts, 0), corners(body.parts, 0);
    for (std::size_t k = 0; k < body.corners; ++k) {
        mass[body.part_of(k)] += body.mass[k];
        corners[body.part_of(k)] += 1;
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const std::uint32_t p = body.part_of(k);
        const double mean =
            mass[p] > 0 ? mass[p] / corners[p] : total / static_cast<double>(body.corners);
        body.mass[k] = std::max(body.mass[k], 1e-6 * mean);
    }
}

CornerBody make_body(const BodyModels& models, std::vector<std::uint32_t> slot, bool tears)
{
    const geometry::Cubes& cubes = models.all();
    check(cubes);
    for (std::size_t m = 0; m < models.count(); ++m) check_grid(*models.model(m).cubes);
    CornerBody body;
    body.h = models.least_edge();
    body.models = models.count();
    for (std::size_t m = 0; m < models.count(); ++m) {
        body.greatest_edge = std::max(body.greatest_edge, models.model(m).cubes->size);
    }
    body.corners = cubes.corner_count();
    body.numbers = padded_numbers(body.corners);
    body.slot = std::move(slot);
    body.mass.assign(body.corners, 0);
    const auto damped = [](double rate) { return rate > 0; };
    if (std::any_of(cubes.mass_damping.begin(), cubes.mass_damping.end(), damped)) {
        body.mass_damping.assign(body.corners, 0);
    }
    const auto joined = geometry::find_components(cubes, geometry::Connectivity::corner);
    body.parts = joined.count();
    body.part_edge = edges_of_parts(models, joined.label, body.parts);
    if (body.parts > 1) body.part.assign(body.corners, 0);
    double total = 0;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        total += cubes.mass[c];
        const auto share = geometry::corner_shares(cubes, c);
        for (std::size_t a = 0; a < 8; ++a) {
            const std::size_t at = body.slot_of(cubes.corners[c][a]);
            body.mass[at] += cubes.mass[c] * share[a];
            if (!body.mass_damping.empty()) {
                body.mass_damping[at] += cubes.mass_damping[c] * cubes.mass[c] * share[a];
            }
            if (!body.part.empty()) body.part[at] = joined.label[c];
        }
    }
    raise_masses(body, total);
    body.rest.assign(body.numbers, 0);
    for (std::size_t m = 0; m < models.count(); ++m) {
        const geometry::Cubes& own = *models.model(m).cubes;
        body.on_lattice &= !own.is_sheet();
        for (std::size_t k = 0; k < own.corner_count(); ++k) {
            const Vec3 p = own.corner_position(k);
            const std::size_t at = 4 * body.slot_of(models.start(m).corner + k);
            for (std::size_t i = 0; i < 3; ++i) {
                body.rest[at + i] = p[static_cast<Eigen::Index>(i)];
            }
        }
    }
    body.skin = make_contact_surface(models, body.slot, tears);
    return body;
}

}  // namespace

CornerBody make_corner_body(const BodyModels& models, std::vector<std::uint32_t> slot)
{
    return make_body(models, std::move(slot), false);
}

CornerBody make_corner_body(const geometry::Cubes& cubes, std::vector<std::uint32_t> slot,
                            const geometry::TriMesh* surface, bool tears)
{
    return make_body({cubes, surface}, std::move(slot), tears);
}

Aligned<double> by_slot(const CornerBody& body, const std::vector<Vec3>& x)
{
    Aligned<double> out;
    fill_numbers(out, body.numbers, 0.0);
    for_numbers(body.corners, [&](std::size_t k) {
        for (std::size_t i = 0; i < 3; ++i) {
            out[4 * body.slot_of(k) + i] = x[k][static_cast<Eigen::Index>(i)];
        }
    });
    return out;
}

}  // namespace physics

#include "render/cube_quantity.hpp"

#include "geometry/cubes/local_matter.hpp"
#include "geometry/embed/carried_numbers.hpp"

#include <stdexcept>

namespace render {
namespace {

// A number for every vertex of the shell from its cube c and corner k.
template <class Number> std::vector<float> spread(const CubeShell& shell, const Number& number)
{
    std::vector<float> out;
    out.reserve(8 * shell.cube.size());
    for (std::size_t s = 0; s < shell.cube.size(); ++s) {
        for (const std::uint32_t k : shell.corner[s]) {
            out.push_back(static_cast<float>(number(shell.cube[s], k)));
        }
    }
    return out;
}

void need(bool there, const std::string& name, const char* what)
{
    if (!there) {
        throw std::invalid_argument("cubes cannot be coloured by `" + name + "`: " + what);
    }
}

}  // namespace

bool is_category(const std::string& name)
{
    return name == "component" || name == "matter";
}

geometry::Attribute cube_quantity(const std::string& name, const geometry::Cubes& cubes,
                                  const CubeShell& shell, const physics::State* state)
{
    const auto of_cubes = [&](const auto& values, const std::string& unit) {
        need(values.size() == cubes.count(), name, "the cubes do not have one number each");
        return geometry::Attribute{name, unit,
                                   spread(shell, [&](auto c, auto) { return values[c]; })};
    };
    if (name == "fill") return of_cubes(cubes.fill, "");
    if (name == "young") return of_cubes(cubes.young, "Pa");
    if (name == "matter") return of_cubes(cubes.matter, "");
    if (name == "component") return of_cubes(cubes.component, "");
    if (name == "density") {
        need(cubes.mass.size() == cubes.count() && cubes.fill.size() == cubes.count(), name,
             "the cubes do not have one mass and one fill each");
        return of_cubes(geometry::material_densities(cubes), "kg/m^3");
    }
    if (name == "stress") {
        if (!state) return {name, "Pa", spread(shell, [](auto, auto) { return 0.0; })};
        need(state->stress.size() == cubes.count(), name, "the state does not have it");
        return of_cubes(state->stress, "Pa");
    }
    if (name == "plastic_strain") {
        if (!state || state->plastic_strain.empty()) {
            return {name, "", spread(shell, [](auto, auto) { return 0.0; })};
        }
        return of_cubes(state->plastic_strain, "");
    }
    const std::size_t corners = cubes.corner_count();
    if (name == "displacement") {
        if (!state) return {name, "m", spread(shell, [](auto, auto) { return 0.0; })};
        need(state->x.size() == corners, name, "the state belongs to other cubes");
        const std::vector<double> far = geometry::displacements(cubes, state->x);
        return {name, "m", spread(shell, [&](auto, auto k) { return far[k]; })};
    }
    if (name == "speed") {
        if (!state) return {name, "m/s", spread(shell, [](auto, auto) { return 0.0; })};
        need(state->v.size() == corners, name, "the state has no velocities of these cubes");
        const std::vector<double> speed = geometry::speeds(state->v);
        return {name, "m/s", spread(shell, [&](auto, auto k) { return speed[k]; })};
    }
    std::string own;
    for (const geometry::CubeAttribute& a : cubes.attributes) {
        if (a.name == name) return of_cubes(a.values, a.unit);
        own += ", " + a.name;
    }
    throw std::invalid_argument("cubes cannot be coloured by `" + name +
                                "`: expected displacement, speed, stress, plastic_strain, fill, "
                                "young, density, component, matter" +
                                (own.empty() ? "" : ", or one of their own:" + own.substr(1)));
}

void colour_by_category(TriMesh& mesh, const geometry::Attribute& values)
{
    mesh.colours.resize(mesh.positions.size());
    for (std::size_t i = 0; i < mesh.colours.size(); ++i) {
        const auto category = static_cast<std::uint32_t>(std::max(0.0f, values.values[i]));
        mesh.colours[i] = linear_from_srgb(category_colour(category));
    }
}

}  // namespace render

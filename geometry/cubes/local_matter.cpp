#include "geometry/cubes/local_matter.hpp"

#include "geometry/base/stop.hpp"
#include "geometry/cells/sub_cells.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

constexpr std::array properties{"young",        "density",           "poisson",
                                "mass_damping", "stiffness_damping", "fill"};
// What CubeMesh, Embed and Render call other quantities.
constexpr std::array others{"thickness", "mass",         "matter", "component",
                            "stress",    "displacement", "speed",  "plastic_strain"};

bool positive(LocalProperty property)
{
    return property == LocalProperty::young || property == LocalProperty::density ||
           property == LocalProperty::thickness;
}

const char* expected(LocalProperty property)
{
    if (property == LocalProperty::own) return "a finite number";
    if (positive(property)) return "a value above 0";
    if (property == LocalProperty::poisson) return "a Poisson's ratio from 0 to below 0.5";
    return "a value of 0 or more";
}

bool possible(LocalProperty property, double value)
{
    if (!std::isfinite(value)) return false;
    if (property == LocalProperty::own) return true;
    if (positive(property)) return value > 0;
    return value >= 0 && (property != LocalProperty::poisson || value < 0.5);
}

void check_values(const Cubes& cubes, LocalProperty property, const std::vector<double>& values)
{
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        if (possible(property, values.at(c))) continue;
        const Vec3 cube =
            cubes.origin + cubes.size * (cubes.cell[c].cast<double>() + Vec3::Constant(0.5));
        const Vec3 at = cubes.is_sheet() ? cell_middle(cubes, c) : cube;
        throw std::invalid_argument(fmt::format(
            "expected {}, found {:.3g} in the {} at ({:.3g}, {:.3g}, {:.3g})", expected(property),
            values[c], cubes.is_sheet() ? "triangle" : "cube", at.x(), at.y(), at.z()));
    }
}

void set_thickness(Cubes& cubes, const std::vector<double>& values)
{
    if (flat_axis(cubes) < 0) {
        throw std::invalid_argument("only a Plane or a Sheet has a thickness, found cubes that are "
                                    "neither: change young or density");
    }
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const double fill = values[c] / cubes.size;
        cubes.mass[c] *= fill / cubes.fill[c];
        cubes.fill[c] = fill;
    }
}

// Of a cell that is full, m^3.
double whole_volume(const Cubes& cubes, std::size_t c)
{
    return cell_area(cubes, c) * cubes.size;
}

}  // namespace

PlacesInCell places_in_cell(const Cubes& cubes, std::size_t cube)
{
    PlacesInCell out;
    const SubCells held = cubes.part.empty() ? all_sub_cells : cubes.part[cube];
    if (held != all_sub_cells) {
        for (SubCells left = held; left != 0; left &= left - 1) {
            const auto bit = static_cast<unsigned>(std::countr_zero(left));
            const Vec3 lower(bit & 3, bit >> 2 & 3, bit >> 4);
            out.at[out.count++] = (lower + Vec3::Constant(0.5)) / across_cell;
        }
        return out;
    }
    const double off = 0.5 / std::sqrt(3.0);
    for (unsigned a = 0; a < 8; ++a) {
        const auto along = [&](unsigned axis) {
            return (a >> axis & 1) != 0 ? 0.5 + off : 0.5 - off;
        };
        out.at[out.count++] = {along(0), along(1), along(2)};
    }
    return out;
}

std::array<Vec3, 3> sheet_points(const Cubes& sheet, std::size_t cell)
{
    const auto [a, b, c] = sheet_triangle(sheet, cell);
    const Vec3 half = (sheet.place[a] + sheet.place[b] + sheet.place[c]) / 6;
    return {half + sheet.place[a] / 2, half + sheet.place[b] / 2, half + sheet.place[c] / 2};
}

std::vector<double> cube_means(const Cubes& cubes, const AtPlace& f)
{
    const int flat = flat_axis(cubes);
    std::vector<double> out(cubes.count(), 0.0);
    StopCheck check;
    for (std::size_t c = 0; c < out.size(); ++c) {
        check();
        if (cubes.is_sheet()) {
            for (const Vec3& p : sheet_points(cubes, c)) out[c] += f(p, c) / 3;
            continue;
        }
        const PlacesInCell places = places_in_cell(cubes, c);
        for (std::size_t i = 0; i < places.count; ++i) {
            Vec3 lattice = cubes.cell[c].cast<double>() + places.at[i];
            if (flat >= 0) lattice[flat] = cubes.corner[cubes.corners[c][0]][flat];
            out[c] += f(cubes.origin + cubes.size * lattice, c);
        }
        out[c] /= double(places.count);
    }
    return out;
}

Cubes with_local_values(Cubes cubes, LocalProperty property, const std::vector<double>& values)
{
    check_values(cubes, property, values);
    switch (property) {
    case LocalProperty::young:
        cubes.young = values;
        break;
    case LocalProperty::density:
        for (std::size_t c = 0; c < cubes.count(); ++c) {
            cubes.mass[c] = values[c] * cubes.fill[c] * whole_volume(cubes, c);
        }
        break;
    case LocalProperty::poisson:
        cubes.poisson = values;
        break;
    case LocalProperty::mass_damping:
        cubes.mass_damping = values;
        break;
    case LocalProperty::stiffness_damping:
        cubes.stiffness_damping = values;
        break;
    case LocalProperty::thickness:
        set_thickness(cubes, values);
        break;
    case LocalProperty::own:
        throw std::logic_error("an attribute without a name");
    }
    return cubes;
}

Cubes with_attribute(Cubes cubes, CubeAttribute attribute)
{
    check_own_name(attribute.name);
    check_values(cubes, LocalProperty::own, attribute.values);
    const auto same = [&](const CubeAttribute& a) { return a.name == attribute.name; };
    const auto found = std::find_if(cubes.attributes.begin(), cubes.attributes.end(), same);
    if (found == cubes.attributes.end()) {
        cubes.attributes.push_back(std::move(attribute));
    } else {
        *found = std::move(attribute);
    }
    return cubes;
}

bool is_own_name(std::string_view name)
{
    const auto in = [&](const auto& names) {
        return std::find(names.begin(), names.end(), name) != names.end();
    };
    return !in(properties) && !in(others);
}

void check_own_name(std::string_view name)
{
    if (std::find(properties.begin(), properties.end(), name) != properties.end()) {
        throw std::invalid_argument(
            fmt::format("all cubes have '{0}': set it as that property with LocalMatter, or give "
                        "it another name with Attributes, such as \"my_{0}\" with the value "
                        "\"{0}\"",
                        name));
    }
    if (!is_own_name(name)) {
        throw std::invalid_argument(fmt::format(
            "'{}' is a quantity of cubes or of their motion: choose another name for the attribute",
            name));
    }
}

std::vector<double> cube_values(const Cubes& cubes, std::string_view name)
{
    if (name == "young") return cubes.young;
    if (name == "density") return material_densities(cubes);
    if (name == "poisson") return cubes.poisson;
    if (name == "mass_damping") return cubes.mass_damping;
    if (name == "stiffness_damping") return cubes.stiffness_damping;
    if (name == "fill") return cubes.fill;
    if (name == "thickness" && flat_axis(cubes) >= 0) return thicknesses(cubes);
    for (const CubeAttribute& a : cubes.attributes) {
        if (a.name == name) return a.values;
    }
    throw std::invalid_argument(fmt::format("the cubes have no attribute '{}'; they have {}", name,
                                            fmt::join(value_names(cubes), ", ")));
}

std::string unit_of(const Cubes& cubes, std::string_view name)
{
    if (name == "young") return "Pa";
    if (name == "density") return "kg/m^3";
    if (name == "mass_damping") return "1/s";
    if (name == "stiffness_damping") return "s";
    if (name == "thickness") return "m";
    for (const CubeAttribute& a : cubes.attributes) {
        if (a.name == name) return a.unit;
    }
    return "";
}

std::vector<std::string> value_names(const Cubes& cubes)
{
    std::vector<std::string> names(properties.begin(), properties.end());
    if (flat_axis(cubes) >= 0) names.emplace_back("thickness");
    for (const CubeAttribute& a : cubes.attributes) names.push_back(a.name);
    return names;
}

Spread value_spread(const Cubes& cubes, std::string_view name)
{
    const std::vector<double> values = cube_values(cubes, name);
    Spread out;
    double filled = 0;
    for (std::size_t c = 0; c < values.size(); ++c) {
        if (c == 0 || values[c] > out.most) out.most = values[c];
        if (c == 0 || values[c] < out.least) out.least = values[c];
        const double weight = cubes.fill[c] * (cubes.is_sheet() ? cell_area(cubes, c) : 1.0);
        out.mean += weight * values[c];
        filled += weight;
    }
    if (filled > 0) out.mean /= filled;
    return out;
}

std::vector<double> thicknesses(const Cubes& cubes)
{
    std::vector<double> out = cubes.fill;
    for (double& v : out) v *= cubes.size;
    return out;
}

std::vector<double> material_densities(const Cubes& cubes)
{
    std::vector<double> out(cubes.count());
    for (std::size_t c = 0; c < out.size(); ++c) {
        const double filled = whole_volume(cubes, c) * cubes.fill[c];
        out[c] = filled > 0 ? cubes.mass[c] / filled : 0;
    }
    return out;
}

}  // namespace geometry

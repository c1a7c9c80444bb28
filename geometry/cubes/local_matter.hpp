#pragma once

// Material and numbers of the user's own that vary from cube to cube, by a function of place.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/measure.hpp"

#include <functional>
#include <string_view>

namespace geometry {

enum class LocalProperty {
    young,
    density,
    poisson,
    mass_damping,
    stiffness_damping,
    thickness,  // m, of a plane or a sheet
    own,        // an attribute
};

// A number at a place (m) in a cube.
using AtPlace = std::function<double(const Vec3& place, std::size_t cube)>;

// Places in a cell of size 1 whose mean stands for what is in it.
struct PlacesInCell {
    std::array<Vec3, 64> at;
    std::size_t count = 0;
};

// The 2 x 2 x 2 Gauss points; of a piece in a part of the cell (Cubes::part), the middles of its
// quarters, which are nearer to it than to others. Precondition: no sheet.
PlacesInCell places_in_cell(const Cubes& cubes, std::size_t cube);

// Three points within a cell of a sheet (m): the mean over them is that over the triangle where a
// function is a quadratic polynomial. None lies at a side, so each is in this triangle alone.
// Strang, Fix. An analysis of the finite element method. Prentice-Hall 1973.
std::array<Vec3, 3> sheet_points(const Cubes& sheet, std::size_t cell);

// The mean over each cube, by places_in_cell(): exact for cubic polynomials where a cube has all of
// its cell. The points of a plane's cells lie in it; those of a sheet's are sheet_points(). C. The
// function is called on one thread.
std::vector<double> cube_means(const Cubes& cubes, const AtPlace& f);

// The cubes with a property of these values, one for each; not for `own`. The density is that of
// the material: the mass becomes density * fill * size^3, of a sheet density * thickness * area.
// The thickness of a plane or a sheet changes fill and mass, and leaves the density. Throws
// std::invalid_argument naming the first cube whose value cannot be (not finite; density, stiffness
// or thickness not above 0; a Poisson ratio outside 0 <= nu < 0.5; a negative damping), and for the
// thickness of cubes that have their own.
Cubes with_local_values(Cubes cubes, LocalProperty property, const std::vector<double>& values);

// The cubes with an attribute of these values, in place of one of its name. Throws
// std::invalid_argument for a name that check_own_name() refuses, and naming the first cube whose
// value is not finite.
Cubes with_attribute(Cubes cubes, CubeAttribute attribute);

// Whether an attribute may have a name: none that a quantity of all cubes or of their motion has.
bool is_own_name(std::string_view name);
// Throws std::invalid_argument where it may not.
void check_own_name(std::string_view name);

// A property or an attribute of each cube, by name: young, density (of the material), poisson,
// mass_damping, stiffness_damping, fill, thickness (of a plane or a sheet), or one of the cubes'
// own. Throws std::invalid_argument that names those there are.
std::vector<double> cube_values(const Cubes& cubes, std::string_view name);

// The unit of such values: "Pa", or "".
std::string unit_of(const Cubes& cubes, std::string_view name);

// The names that cube_values() knows.
std::vector<std::string> value_names(const Cubes& cubes);

// Of such values over the cubes, the mean by the volume that fills them.
Spread value_spread(const Cubes& cubes, std::string_view name);

// Of a plane's or a sheet's cells. C, m.
std::vector<double> thicknesses(const Cubes& cubes);

// mass / (fill * size^3) of each cube. C, kg/m^3. Less than the density of the material where
// min_fill counts cubes as fuller than they are (fill_cubes.hpp).
std::vector<double> material_densities(const Cubes& cubes);

}  // namespace geometry

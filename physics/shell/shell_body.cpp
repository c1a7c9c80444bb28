#include "physics/shell/shell_body.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/plane.hpp"
#include "physics/body/make_sheet_cells.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/bricks/time_step.hpp"
#include "physics/shell/slope_factor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

// Map: cells and what they are made of; points that bend; rows of the matrix; elements of its
// factor.

namespace physics {
namespace {

using geometry::no_index;

void check(const BodyModels& models, const ShellOptions& options)
{
    for (std::size_t m = 0; m < models.count(); ++m) {
        if (geometry::flat_axis(*models.model(m).cubes) >= 0) continue;
        throw std::invalid_argument(
            "method shell needs a plane or a sheet, found cubes with a thickness: make the cubes "
            "with Plane or Sheet, or use method bricks");
    }
    check_plastic(options.plastic);
    const auto sound = [](double v) { return std::isfinite(v) && v >= 0; };
    if (sound(options.stretch) && options.stretch > 0 && sound(options.bend)) return;
    throw std::invalid_argument(
        fmt::format("shell: expected a stretch above 0 and a bend of at least 0, found {} and {}",
                    options.stretch, options.bend));
}

// Which corners of a cell lie along u and across it, of each model.
struct CellCorners {
    std::size_t along, across;
};
std::vector<CellCorners> corners_of_models(const BodyModels& models)
{
    std::vector<CellCorners> out;
    for (std::size_t m = 0; m < models.count(); ++m) {
        const auto [u, v] = geometry::plane_axes(geometry::flat_axis(*models.model(m).cubes));
        out.push_back({std::size_t{1} << u, std::size_t{1} << v});
    }
    return out;
}

// Cells, what they are made of, and which of them each point is a corner of.
void add_cells(const BodyModels& models, ShellBody& body)
{
    const geometry::Cubes& cubes = models.all();
    body.cells_of.assign(cubes.corner_count(), {no_index, no_index, no_index, no_index});
    const std::vector<CellCorners> corners = corners_of_models(models);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const std::size_t m = models.model_of(c);
        const double a = models.model(m).cubes->size;
        const auto [along, across] = corners[m];
        const auto& k = cubes.corners[c];
        body.cell.push_back({k[0], k[along], k[across], k[along | across]});
        const double h = cubes.fill[c] * a, nu = cubes.poisson[c];
        const double plane = cubes.young[c] / (1 - nu * nu);
        const double area = h * a * a * body.options.stretch;
        const double plate = body.options.bend * plane * h * h * h / 12;  // D
        body.matter.push_back({cubes.young[c] / (1 + nu) * area, plane * nu * area,
                               cubes.young[c] * area / 12, 2 * (1 - nu) * plate});
        body.plate.push_back(plate);
        body.poisson.push_back(nu);
        body.damping.push_back(cubes.stiffness_damping[c]);
        for (std::uint32_t i = 0; i < 4; ++i) {
            std::uint32_t& at = body.cells_of[body.cell[c][i]][i];
            if (at != no_index) {
                throw std::invalid_argument(
                    "method shell: expected a sheet of single cells, found two that share a corner "
                    "and lie on the same side of it");
            }
            at = 4 * c + i;
        }
    }
}

// The neighbours of a point, and along which axes its curvature is known: where cells lie on both
// sides of it that share a side.
ShellPoint neighbours_of(const ShellBody& body, std::uint32_t k)
{
    // The point is corner i of its cells; cells along u from one another are 0, 1 and 2, 3.
    ShellPoint out;
    out.beside.fill(no_index);
    const auto& cells = body.cells_of[k];
    for (std::uint32_t i = 0; i < 4; ++i) {
        if (cells[i] == no_index) continue;
        const auto& corners = body.cell[cells[i] / 4];
        out.beside[i & 1 ? ShellPoint::low_u : ShellPoint::high_u] = corners[i ^ 1];
        out.beside[i & 2 ? ShellPoint::low_v : ShellPoint::high_v] = corners[i ^ 2];
    }
    const auto both = [&](std::size_t i, std::size_t j) {
        return cells[i] != no_index && cells[j] != no_index;
    };
    out.along_u = both(0, 1) || both(2, 3);
    out.along_v = both(0, 2) || both(1, 3);
    return out;
}

void add_points(ShellBody& body)
{
    for (std::uint32_t k = 0; k < body.base.corners; ++k) {
        const double a = body.base.edge_at(k);
        const double quarter = 1 / (4 * a * a);  // of an area, over a^4
        ShellPoint point = neighbours_of(body, k);
        for (const std::uint32_t at : body.cells_of[k]) {
            if (at == no_index) continue;
            const std::uint32_t c = at / 4;
            const double nu = body.poisson[c], plate = quarter * body.plate[c];
            const double tau = body.damping[c];
            const bool both = point.along_u && point.along_v;
            const double own = both ? plate : (1 - nu * nu) * plate;
            if (point.along_u) point.uu += own, point.uu_damping += own * tau;
            if (point.along_v) point.vv += own, point.vv_damping += own * tau;
            if (both) point.uv += nu * plate, point.uv_damping += nu * plate * tau;
        }
        body.point.push_back(point);
    }
}

// The point itself and its neighbours that its curvatures are of.
std::vector<std::uint32_t> corners_of(const ShellBody& body, std::uint32_t k)
{
    const ShellPoint& point = body.point[k];
    std::vector<std::uint32_t> out{k};
    for (std::size_t i = 0; i < 4; ++i) {
        if (i < 2 ? point.along_u : point.along_v) out.push_back(point.beside[i]);
    }
    return out;
}

void add_rows(ShellBody& body)
{
    std::vector<std::vector<std::uint32_t>> rows(body.base.corners);
    const auto join = [&](const auto& corners) {
        for (const auto i : corners) rows[i].insert(rows[i].end(), corners.begin(), corners.end());
    };
    for (const auto& corners : body.cell) join(corners);
    for (std::uint32_t k = 0; k < rows.size(); ++k) join(corners_of(body, k));
    body.row.push_back(0);
    for (auto& columns : rows) {
        std::sort(columns.begin(), columns.end());
        columns.erase(std::unique(columns.begin(), columns.end()), columns.end());
        body.column.insert(body.column.end(), columns.begin(), columns.end());
        body.row.push_back(static_cast<std::uint32_t>(body.column.size()));
    }
    for (const auto& corners : body.cell) {
        auto& at = body.cell_at.emplace_back();
        for (std::size_t i = 0; i < 4; ++i) {
            for (std::size_t j = 0; j < 4; ++j) {
                at[4 * i + j] = entry_of(body, corners[i], corners[j]);
            }
        }
    }
}

void add_elements(const geometry::Cubes& cubes, ShellBody& body)
{
    // A point's neighbours are two points apart, and then lie on planes next to each other.
    body.elements.corner = cubes.corner;
    for (auto& at : body.elements.corner) {
        for (Eigen::Index i = 0; i < 3; ++i) at[i] = at[i] >> 1;
    }
    const auto add = [&](std::uint32_t cell, std::uint32_t point) {
        std::vector<std::uint32_t> corners;
        if (cell != no_index) corners.assign(body.cell[cell].begin(), body.cell[cell].end());
        if (point != no_index) {
            for (const auto k : corners_of(body, point)) {
                if (std::find(corners.begin(), corners.end(), k) == corners.end()) {
                    corners.push_back(k);
                }
            }
        }
        auto& to = body.elements.corners.emplace_back();
        to.fill(corners[0]);
        std::copy(corners.begin(), corners.end(), to.begin());
        body.elements.cell.push_back(body.elements.corner[corners[0]]);
        body.element.push_back({cell, point});
    };
    for (std::uint32_t c = 0; c < body.cell.size(); ++c) add(c, body.cell[c][0]);
    for (std::uint32_t k = 0; k < body.base.corners; ++k) {
        const ShellPoint& point = body.point[k];
        if (body.cells_of[k][0] == no_index && (point.along_u || point.along_v)) add(no_index, k);
    }
}

// The triangles of all cells.
TriangleShell triangles_of(const BodyModels& models, const ShellBody& body)
{
    const geometry::Cubes& cubes = models.all();
    std::vector<TrianglePlan> plans;
    const std::vector<CellCorners> corners = corners_of_models(models);
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        const std::size_t m = models.model_of(c);
        const geometry::Cubes& own = *models.model(m).cubes;
        const auto [along, across] = corners[m];
        const auto& k = cubes.corners[c];
        TrianglePlan plan{{k[0], k[along], k[along | across]},
                          cubes.young[c],
                          cubes.poisson[c],
                          cubes.fill[c] * own.size,
                          cubes.stiffness_damping[c]};
        if (!own.is_sheet()) plan.fourth = k[across];
        plans.push_back(plan);
        if (own.is_sheet()) continue;
        plan.corner = {k[0], k[along | across], k[across]};
        plan.fourth = k[along];
        plans.push_back(plan);
    }
    // Slopes are told by the energy of bending, and where it is 0 by nothing.
    constexpr double least_bend = 1e-9;
    TriangleShell out =
        make_triangle_shell(plans, body.base.rest.data(), body.base.corners, body.options.stretch,
                            std::max(body.options.bend, least_bend));
    out.slopes = std::make_shared<SlopeCache>();
    return out;
}

}  // namespace

std::uint32_t entry_of(const ShellBody& body, std::uint32_t row, std::uint32_t column)
{
    const auto first = body.column.begin() + body.row[row];
    const auto last = body.column.begin() + body.row[row + 1];
    return static_cast<std::uint32_t>(std::lower_bound(first, last, column) - body.column.begin());
}

ShellBody make_shell(const geometry::Cubes& cubes, const ShellOptions& options,
                     const geometry::TriMesh* surface)
{
    return make_shell(BodyModels(cubes, surface), options);
}

ShellBody make_shell(const BodyModels& models, const ShellOptions& options)
{
    check(models, options);
    const geometry::Cubes& cubes = models.all();
    ShellBody body;
    body.options = options;
    std::vector<std::uint32_t> slot(cubes.corner_count());
    std::iota(slot.begin(), slot.end(), 0u);
    body.base = make_corner_body(models, std::move(slot));
    body.base.sheets = sheets_that_touch(models, body.base, options.contact);
    body.dissections = std::make_shared<DissectionCache>();
    bool by_triangles = options.plastic.yield > 0;  // cells do not flow
    for (std::size_t m = 0; m < models.count(); ++m) {
        by_triangles |= models.model(m).cubes->is_sheet();
    }
    if (by_triangles) {
        body.triangles = std::make_shared<const TriangleShell>(triangles_of(models, body));
        return body;
    }
    add_cells(models, body);
    add_points(body);
    add_rows(body);
    add_elements(cubes, body);
    return body;
}

std::size_t ShellBody::bytes() const
{
    const auto of = [](const auto&... v) { return ((v.size() * sizeof(v[0])) + ...); };
    return sizeof *this - sizeof base + base.bytes() + (triangles ? triangles->bytes() : 0) +
           of(cell, matter, damping, point, plate, poisson, row, column, cell_at, cells_of, element,
              elements.corner, elements.corners, elements.cell);
}

State rest_state(const ShellBody& body)
{
    State state = rest_state(body.base);
    if (!(body.options.plastic.yield > 0) || !body.triangles) return state;
    const auto& triangles = body.triangles->triangle;
    const auto halves = std::count_if(triangles.begin(), triangles.end(),
                                      [](const ShellTriangle& t) { return t.fourth != no_index; });
    state.plastic_strain.assign(triangles.size() - std::size_t(halves) / 2, 0.0f);
    return state;
}

}  // namespace physics

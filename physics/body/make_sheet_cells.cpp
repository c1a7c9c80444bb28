#include "physics/body/make_sheet_cells.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/cubes/sheet.hpp"
#include "physics/body/contact_thickness.hpp"

#include <algorithm>
#include <utility>

namespace physics {
namespace {

// From there on, in cells and beyond the thickness, what comes near is kept apart.
constexpr double near_sheet = 0.1;

void add_sheet(const geometry::Cubes& cubes, const CornerBody& body, ModelStart start,
               std::uint32_t number, SheetCells& out)
{
    const auto [u, v] = geometry::plane_axes(geometry::flat_axis(cubes));
    const std::size_t along = std::size_t{1} << u, across = std::size_t{1} << v;
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const auto& corners = cubes.corners[c];
        const auto slot = [&](std::size_t a) {
            return static_cast<std::uint32_t>(body.slot_of(start.corner + corners[a]));
        };
        const std::array<std::uint32_t, 4> k{slot(0), slot(along), slot(across),
                                             slot(along | across)};
        out.cell.push_back(k);
        out.place.push_back(cubes.cell[c]);
        out.model.push_back(number);
        out.triangle.push_back({k[0], k[1], k[3]});
        out.triangle.push_back({k[0], k[3], k[2]});
    }
}

void add_sheet_edges(SheetCells& out, std::size_t slots)
{
    std::vector<std::uint8_t> taken(slots, 0);
    std::vector<std::pair<std::array<std::uint32_t, 2>, std::uint32_t>> all;  // with their cell
    for (std::uint32_t c = 0; c < out.cell.size(); ++c) {
        const auto& k = out.cell[c];
        out.point_at.push_back(static_cast<std::uint32_t>(out.point.size()));
        for (const auto p : k) {
            if (taken[p] == 0) out.point.push_back(p);
            taken[p] = 1;
        }
        for (const auto& [i, j] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}, {0, 3}}) {
            const auto a = k[std::size_t(i)], b = k[std::size_t(j)];
            if (a == b) continue;  // of a triangle
            all.push_back({{std::min(a, b), std::max(a, b)}, c});
        }
    }
    out.point_at.push_back(static_cast<std::uint32_t>(out.point.size()));
    std::sort(all.begin(), all.end());
    const auto same = [](const auto& a, const auto& b) { return a.first == b.first; };
    all.erase(std::unique(all.begin(), all.end(), same), all.end());
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.second < b.second; });
    for (std::uint32_t c = 0, e = 0; c <= out.cell.size(); ++c) {
        out.edge_at.push_back(e);
        for (; e < all.size() && all[e].second == c; ++e) out.edge.push_back(all[e].first);
    }
}

// The cells within two of each along triangles, by the corners that they share.
void add_beside(SheetCells& out, std::size_t slots)
{
    std::vector<std::vector<std::uint32_t>> at(slots);
    for (std::uint32_t c = 0; c < out.cell.size(); ++c) {
        for (const auto k : out.cell[c]) {
            if (at[k].empty() || at[k].back() != c) at[k].push_back(c);
        }
    }
    std::vector<std::uint32_t> near, further, of_cell(out.cell.size(), geometry::no_index),
        of_corner(slots, geometry::no_index);
    std::uint32_t search = 0;
    const auto spread = [&](const std::vector<std::uint32_t>& from) {
        std::vector<std::uint32_t> to;
        ++search;
        for (const auto c : from) {
            for (const auto k : out.cell[c]) {
                if (std::exchange(of_corner[k], search) == search) continue;
                for (const auto other : at[k]) {
                    if (std::exchange(of_cell[other], search) != search) to.push_back(other);
                }
            }
        }
        std::sort(to.begin(), to.end());
        return to;
    };
    for (std::uint32_t c = 0; c < out.cell.size(); ++c) {
        out.beside_at.push_back(static_cast<std::uint32_t>(out.beside.size()));
        near = spread({c});
        further = spread(near);
        out.beside.insert(out.beside.end(), further.begin(), further.end());
    }
    out.beside_at.push_back(static_cast<std::uint32_t>(out.beside.size()));
}

// A point is as thick and as firm as the mean of its cells.
void add_sheet_points(const BodyModels& models, const CornerBody& body, SheetCells& out)
{
    constexpr double layers = 100;  // that one point bears within its thickness
    const geometry::Cubes& cubes = models.all();
    std::vector<double> cells(body.corners, 0), thick(body.corners, 0), bears(body.corners, 0);
    for (std::size_t c = 0; c < out.cell.size(); ++c) {
        const auto number = static_cast<std::uint32_t>(c);
        const double edge = models.edge_of(number);
        const double thickness = contact_thickness(cubes.fill[c] * edge, edge);
        const bool is_triangle = out.cell[c][3] == out.cell[c][2];
        const std::size_t corners = is_triangle ? 3 : 4;
        const std::size_t model = models.model_of(number);
        const double area =
            geometry::cell_area(*models.model(model).cubes, number - models.start(model).cube);
        for (std::size_t i = 0; i < corners; ++i) {
            const auto k = out.cell[c][i];
            cells[k] += 1;
            thick[k] += thickness;
            bears[k] += 10 * cubes.young[c] * area / (double(corners) * thickness);
        }
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        const double h = thick[k] / cells[k];
        out.thickness.push_back(static_cast<float>(h));
        out.stiffness.push_back(
            static_cast<float>(std::min(bears[k], layers * body.mass[k] * 9.81 / h)));
    }
}

}  // namespace

std::shared_ptr<const SheetCells> sheets_that_touch(const BodyModels& models,
                                                    const CornerBody& body,
                                                    const PartContactOptions& options)
{
    if (!options.on || (models.count() < 2 && !options.self)) return nullptr;
    return make_sheet_cells(models, body, options);
}

std::shared_ptr<const SheetCells> make_sheet_cells(const BodyModels& models, const CornerBody& body,
                                                   const PartContactOptions& options)
{
    auto out = std::make_shared<SheetCells>();
    out->friction = options.friction;
    out->bounce = options.bounce;
    out->self = options.self;
    for (std::uint32_t m = 0; m < models.count(); ++m) {
        add_sheet(*models.model(m).cubes, body, models.start(m), m, *out);
    }
    add_sheet_edges(*out, body.corners);
    if (!body.on_lattice) add_beside(*out, body.corners);
    add_sheet_points(models, body, *out);
    const auto [thin, thick] = std::minmax_element(out->thickness.begin(), out->thickness.end());
    out->thinnest = double(*thin), out->thickest = double(*thick);
    out->reach = out->thickest + near_sheet * body.h;
    std::vector<geometry::Box3f> boxes;
    for (const auto& corners : out->cell) {
        geometry::Box3f& box = boxes.emplace_back();
        for (const auto k : corners) {
            box.add(Vec3f(Eigen::Map<const Vec3>(body.rest.data() + 4 * k).cast<float>()));
        }
    }
    out->tree = geometry::build_box_tree(boxes);
    return out;
}

}  // namespace physics

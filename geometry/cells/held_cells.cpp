#include "geometry/cells/held_cells.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/cells/cell_lines.hpp"
#include "geometry/cells/clip_to_cells.hpp"
#include "geometry/cells/surface_cells.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <tuple>

namespace geometry {
namespace {

// Which quarters of a cell triangles meet.
struct Met {
    SubCells touched = 0;               // by any of its points, CellShape::half_open
    SubCells entered = 0;               // inside, CellShape::interior
    std::array<SubCells, 3> beneath{};  // a piece lies in its lower face across each axis
};

void add_bits(SubCells& to, SubCells bits)
{
    std::atomic_ref<SubCells> shared(to);
    if ((shared.load(std::memory_order_relaxed) & bits) != bits) {
        shared.fetch_or(bits, std::memory_order_relaxed);
    }
}

// A polygon in a cell, in lattice coordinates.
Met met_by(Polygon piece, const Vec3i& cell)
{
    for (std::size_t i = 0; i < piece.n; ++i) {
        piece.p[i] = across_cell * (piece.p[i] - cell.cast<double>());
    }
    Met out;
    touch_cells(piece, [&](const Vec3i& at, const Polygon& part) {
        if (at.maxCoeff() >= across_cell || at.minCoeff() < 0) return;
        const SubCells bit = SubCells{1} << sub_cell_bit(at.x(), at.y(), at.z());
        out.touched |= bit;
        constexpr double least_area = 1e-12;  // of rounding, in faces of quarters
        if (part.n < 3 || part.area() <= least_area) return;
        bool flat = false;
        for (int k = 0; k < 3; ++k) {
            bool all = part.p[0][k] == std::floor(part.p[0][k]);
            for (std::size_t i = 1; i < part.n; ++i) all = all && part.p[i][k] == part.p[0][k];
            if (!all) continue;
            flat = true;
            if (part.p[0][k] == at[k]) out.beneath[static_cast<std::size_t>(k)] |= bit;
        }
        if (!flat) out.entered |= bit;
    });
    return out;
}

// What one triangle meets of a cell.
struct Visit {
    Vec3i cell;
    std::uint32_t border = 0;
    SubCells touched = 0;
};

bool before(const Vec3i& a, const Vec3i& b)
{
    return std::tuple(a.z(), a.y(), a.x()) < std::tuple(b.z(), b.y(), b.x());
}

// Of each neighbour 0..26, the quarters from which a step leads over into it.
constexpr std::array<SubCells, 27> on_the_way = [] {
    std::array<SubCells, 27> out{};
    for (std::size_t n = 0; n < 27; ++n) {
        const auto i = static_cast<int>(n);
        for (const Step& step : steps) {
            out[n] |= n == 13 ? 0 : move_of(step, {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1}).from;
        }
    }
    return out;
}();

// Links the quarters that one triangle meets; `visits` are sorted by their cells.
void link(const std::vector<Visit>& visits, std::vector<HeldCells::Links>& links)
{
    if (visits.size() == 1 && std::has_single_bit(visits[0].touched)) return;
    for (const Visit& from : visits) {
        for (std::size_t d = 0; d < steps.size(); ++d) {
            const SubCells ends = moves_on[d](from.touched) & from.touched;
            if (ends) add_bits(links[from.border][d], moves_back[d](ends));
        }
        if (visits.size() == 1) return;
        for (int n = 0; n < 27; ++n) {
            const Step over{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
            if ((from.touched & on_the_way[static_cast<std::size_t>(n)]) == 0) continue;
            const Vec3i next = from.cell + Vec3i(over[0], over[1], over[2]);
            const auto to =
                std::lower_bound(visits.begin(), visits.end(), next,
                                 [](const Visit& v, const Vec3i& c) { return before(v.cell, c); });
            if (to == visits.end() || to->cell != next) continue;
            for (std::size_t d = 0; d < steps.size(); ++d) {
                const SubCells ends = landed(from.touched, steps[d], over) & to->touched;
                if (ends == 0) continue;
                add_bits(links[from.border][d], landed(ends, backwards(steps[d]), backwards(over)));
            }
        }
    }
}

// What all triangles meet of the cells `border` (sorted), and the links that they make.
std::vector<Met> meet(const LatticeMesh& mesh, const CellIndex& border, std::size_t count,
                      std::vector<HeldCells::Links>& links)
{
    std::vector<Met> out(count);
    links.assign(count, {});
    const auto some = [&](std::size_t begin, std::size_t end) {
        std::vector<Visit> visits;
        StopCheck check;
        for (std::size_t t = begin; t < end; ++t) {
            check();
            visits.clear();
            const auto& [a, b, c] = mesh.triangles[t];
            Polygon triangle;
            for (const std::uint32_t v : {a, b, c}) triangle.add(mesh.positions[v]);
            touch_cells(triangle, [&](const Vec3i& cell, const Polygon& piece) {
                const auto found = border.find(cell);
                if (!found) return;
                const Met met = met_by(piece, cell);
                Met& all = out[found.begin];
                add_bits(all.touched, met.touched);
                add_bits(all.entered, met.entered);
                for (std::size_t k = 0; k < 3; ++k) add_bits(all.beneath[k], met.beneath[k]);
                if (met.touched) visits.push_back({cell, found.begin, met.touched});
            });
            link(visits, links);
        }
    };
    parallel_for(mesh.triangles.size(), 16, some);
    return out;
}

// A solid's quarters, and the links that go through its inside.
class SolidQuarters {
public:
    SolidQuarters(const LatticeMesh& mesh, Inside rule, HeldCells& out, std::vector<Vec3i> border)
        : mesh_(mesh), rule_(rule), out_(out), border_(std::move(border)), index_(out.cells)
    {
        const CellIndex border_index(border_);
        out_.links_of.assign(out_.cells.size(), no_index);
        for (std::uint32_t b = 0; b < border_.size(); ++b) {
            out_.links_of[index_.find(border_[b]).begin] = b;
        }
        met_ = meet(mesh_, border_index, border_.size(), out_.links);
        inside_ = cell_lines(mesh_, rule_, border_).inside;
    }

    void find()
    {
        hold();
        for (std::size_t k = 0; k < 3; ++k) link_along(k);
    }

private:
    // A cell and what is known of it.
    struct Quarters {
        SubCells held = 0, full = 0;
    };

    void hold()
    {
        out_.held.assign(out_.cells.size(), all_sub_cells);
        for (std::size_t c = 0; c < out_.cells.size(); ++c) {
            const std::uint32_t b = out_.links_of[c];
            if (b != no_index) out_.held[c] = met_[b].entered | inside_[b];
        }
        const std::vector<SubCells> held = out_.held;
        parallel_for(out_.cells.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                const std::uint32_t b = out_.links_of[c];
                if (b != no_index) hold_sheets(c, met_[b], held);
            }
        });
    }

    void hold_sheets(std::size_t c, const Met& met, const std::vector<SubCells>& held)
    {
        for (std::size_t k = 0; k < 3; ++k) {
            if (met.beneath[k] == 0) continue;
            SubCells below = landed(held[c], steps[k]);
            const auto next = index_.find(out_.cells[c] - unit(k));
            if (next) below |= landed(held[next.begin], steps[k], steps[k]);
            out_.held[c] |= met.beneath[k] & ~held[c] & ~below;
        }
        if (out_.held[c] == 0) out_.held[c] = met.touched;
        if (out_.held[c] != 0) return;
        // Known to be in the solid by its centre alone.
        out_.held[c] = all_sub_cells;
        inside_[out_.links_of[c]] = all_sub_cells;
    }

    static Vec3i unit(std::size_t axis) { return Vec3i::Unit(static_cast<Eigen::Index>(axis)); }

    Quarters quarters(std::size_t c) const
    {
        const std::uint32_t b = out_.links_of[c];
        if (b == no_index) return {all_sub_cells, all_sub_cells};
        return {out_.held[c], inside_[b] & ~met_[b].touched};
    }

    // Links across the faces across an axis.
    void link_along(std::size_t k)
    {
        const Crossings crossings = find_crossings(mesh_, Axes(static_cast<int>(k)), across_cell);
        parallel_for(out_.cells.size(), 1024, [&](std::size_t begin, std::size_t end) {
            for (std::size_t c = begin; c < end; ++c) {
                const std::uint32_t b = out_.links_of[c];
                if (b == no_index) continue;
                const Quarters here = quarters(c);
                SubCells pairs = here.held & landed(here.held, backwards(steps[k]));
                SubCells sure = here.full | landed(here.full, backwards(steps[k]));
                const auto next = index_.find(out_.cells[c] + unit(k));
                if (next) {
                    const Quarters there = quarters(next.begin);
                    const Step back = backwards(steps[k]);
                    pairs |= here.held & landed(there.held, back, back);
                    sure |= landed(there.full, back, back);
                }
                SubCells& linked = out_.links[b][k];
                linked |= pairs & sure;
                for (SubCells rest = pairs & ~linked; rest != 0; rest &= rest - 1) {
                    const auto bit = static_cast<unsigned>(std::countr_zero(rest));
                    if (face_inside(crossings, k, out_.cells[c], bit)) {
                        linked |= SubCells{1} << bit;
                    }
                }
            }
        });
    }

    // Whether the middle of a quarter's upper face is inside, as both rays of the axis say.
    bool face_inside(const Crossings& crossings, std::size_t k, const Vec3i& cell,
                     unsigned bit) const
    {
        const Vec3i at(static_cast<int>(bit & 3), static_cast<int>(bit >> 2 & 3),
                       static_cast<int>(bit >> 4));
        const Axes axes(static_cast<int>(k));
        const double u = cell[axes.u] + (at[axes.u] + 1.0) / across_cell;
        const auto layer = crossings.in_layer(across_cell * cell[axes.w] + at[axes.w]);
        const int row = across_cell * cell[axes.v] + at[axes.v];
        auto i = std::lower_bound(layer.begin(), layer.end(), row,
                                  [](const Crossing& c, int v) { return c.v < v; });
        int left = 0, total = 0;
        for (; i != layer.end() && i->v == row; ++i) {
            total += weight(rule_, *i);
            if (i->u < u) left += weight(rule_, *i);
        }
        return std::abs(two_votes(rule_, left, total)) == 2;
    }

    const LatticeMesh& mesh_;
    Inside rule_;
    HeldCells& out_;
    std::vector<Vec3i> border_;  // cells that the surface passes
    CellIndex index_;            // of all cells
    std::vector<Met> met_;       // of each border cell
    std::vector<SubCells> inside_;
};

}  // namespace

LatticeMesh snapped_to_quarters(LatticeMesh mesh, const VoxelGrid& grid)
{
    constexpr double snap = 4e-6, float_spacing = 0x1p-21;  // of a quarter
    parallel_for(mesh.positions.size(), 16384, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            for (int k = 0; k < 3; ++k) {
                double& x = mesh.positions[v][k];
                const double nearest = std::nearbyint(across_cell * x);
                const double rounding = float_spacing * std::abs(x + grid.origin[k] / grid.size);
                const double close = std::min(0.04, std::max(snap, rounding));
                // Faces of cells were snapped to before.
                if (std::fmod(nearest, across_cell) == 0) continue;
                if (std::abs(across_cell * x - nearest) <= close) x = nearest / across_cell;
            }
        }
    });
    return mesh;
}

HeldCells held_by_surface(const LatticeMesh& mesh, std::vector<Vec3i> cells)
{
    HeldCells out;
    out.cells = std::move(cells);
    const std::vector<Met> met = meet(mesh, CellIndex(out.cells), out.cells.size(), out.links);
    for (std::uint32_t c = 0; c < out.cells.size(); ++c) {
        const bool met_at_all = met[c].touched != 0;
        out.held.push_back(met_at_all ? met[c].touched : all_sub_cells);
        out.links_of.push_back(met_at_all ? c : no_index);
    }
    return out;
}

HeldCells held_by_solid(const LatticeMesh& mesh, Inside rule, std::vector<Vec3i> cells)
{
    HeldCells out;
    out.cells = std::move(cells);
    std::vector<Vec3i> border = surface_cells(mesh, CellShape::half_open).sorted();
    const CellIndex index(out.cells);
    std::erase_if(border, [&](const Vec3i& c) { return !index.find(c); });
    SolidQuarters(mesh, rule, out, std::move(border)).find();
    return out;
}

}  // namespace geometry

#include "geometry/fields/evaluate_points.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/fields/evaluate_block.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

namespace geometry {
namespace {

// One block: points[order[begin .. end)], or points[begin .. end) without an order.
struct BlockTask {
    const Field& field;
    std::span<const Vec3> points;
    std::span<const std::uint32_t> order;
    std::span<double> f;
    std::span<Vec3> gradient;

    std::size_t index(std::size_t i) const { return order.empty() ? i : order[i]; }

    void run(std::size_t begin, std::size_t end) const
    {
        thread_local FieldScratch scratch;
        thread_local FieldBlock block;
        thread_local BlockValues values;
        thread_local std::vector<std::uint32_t> near;
        block.count = 0;
        Box box;
        for (std::size_t i = begin; i < end && !order.empty(); ++i) {
            __builtin_prefetch(&points[order[i]]);
        }
        for (std::size_t i = begin; i < end; ++i) {
            const Vec3& p = points[index(i)];
            // Far outside stands for nowhere: its squared distances stay finite.
            block.add(p.allFinite() ? p : Vec3(Vec3::Constant(1e150)));
            if (p.allFinite()) box.add(p);
        }
        block.pad();
        if (box.empty()) {
            near.clear();
        } else {
            candidates(field, box, near);
        }
        evaluate(field, near, block, scratch, values);
        for (std::size_t i = begin; i < end; ++i) {
            f[index(i)] = values.f[i - begin];
            if (!gradient.empty()) gradient[index(i)] = values.gradient(i - begin);
        }
    }
};

// Whether consecutive points are near each other already: samples, grid blocks, mesh vertices.
bool coherent(const FieldGrid& grid, std::span<const Vec3> points)
{
    constexpr std::size_t block = FieldBlock::capacity, looks = 16;
    const std::size_t blocks = (points.size() + block - 1) / block;
    std::size_t narrow = 0;
    for (std::size_t look = 0; look < looks; ++look) {
        const std::size_t begin = look * blocks / looks * block;
        Box box;
        for (std::size_t i = begin; i < std::min(points.size(), begin + block); ++i) {
            box.add(points[i]);
        }
        narrow += box.diagonal() < 4 * grid.cell;
    }
    return narrow * 2 >= looks;
}

// Counting sort: order[start[c] .. start[c + 1]) are the points of cell c. Returns how many cells.
std::size_t sort_by_cell(const FieldGrid& grid, std::span<const Vec3> points,
                         std::span<std::uint32_t> cell, std::span<std::uint32_t> order,
                         std::vector<std::uint32_t>& start)
{
    // The field's own cells are as wide as an influence: points of a quarter of that share few
    // skeletons that reach some of them and not others.
    FieldGrid coarse;
    coarse.lo = grid.lo;
    coarse.dims = 4 * grid.dims;
    coarse.cell = 0.25 * grid.cell;
    const double most = static_cast<double>(points.size()) / 64 + 1;
    while (coarse.dims.cast<double>().prod() > most) {
        coarse.cell *= 1.1;
        coarse.dims = (grid.dims.cast<double>() * (grid.cell / coarse.cell))
                          .array()
                          .ceil()
                          .max(1.0)
                          .matrix()
                          .cast<int>();
    }
    const auto cells = static_cast<std::size_t>(coarse.dims.cast<double>().prod());
    parallel_for(points.size(), 8192, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            cell[i] =
                points[i].allFinite()
                    ? static_cast<std::uint32_t>(cell_index(coarse, cell_of(coarse, points[i])))
                    : 0;
        }
    });
    start.assign(cells + 1, 0);
    for (std::size_t i = 0; i < points.size(); ++i) ++start[cell[i] + 1];
    for (std::size_t c = 0; c < cells; ++c) start[c + 1] += start[c];
    for (std::uint32_t i = 0; i < points.size(); ++i) order[start[cell[i]]++] = i;
    for (std::size_t c = cells; c > 0; --c) start[c] = start[c - 1];
    start[0] = 0;
    return cells;
}

}  // namespace

void evaluate(const Field& field, std::span<const Vec3> points, std::span<double> f,
              std::span<Vec3> gradient)
{
    if (f.size() != points.size() || (!gradient.empty() && gradient.size() != points.size())) {
        throw std::invalid_argument(
            fmt::format("evaluating a field at {} points needs as many values and gradients (or no "
                        "gradients), got {} and {}",
                        points.size(), f.size(), gradient.size()));
    }
    if (points.size() > 0xffffffffu) {
        throw std::invalid_argument(
            "a field can be evaluated at no more than 2^32 points per call");
    }
    constexpr std::size_t capacity = FieldBlock::capacity;
    const FieldGrid& grid = field.grid;
    if (points.size() <= capacity || grid.cell_count() < 2 || coherent(grid, points)) {
        const BlockTask task{field, points, {}, f, gradient};
        const std::size_t blocks = (points.size() + capacity - 1) / capacity;
        parallel_for(blocks, 4, [&](std::size_t begin, std::size_t end) {
            for (std::size_t b = begin; b < end; ++b) {
                task.run(b * capacity, std::min(points.size(), (b + 1) * capacity));
            }
        });
        return;
    }

    // Scattered points: sorted into cells of some 64 points, then cell by cell; in tiles whose
    // points and results stay in cache.
    const std::size_t tile = std::clamp<std::size_t>(512 * field.count(), 1 << 18, 1 << 20);
    std::vector<std::uint32_t> cell(std::min(tile, points.size())), order(cell.size()), start;
    for (std::size_t begin = 0; begin < points.size(); begin += tile) {
        const std::size_t n = std::min(tile, points.size() - begin);
        const std::size_t cells = sort_by_cell(grid, points.subspan(begin, n), cell, order, start);
        const BlockTask task{field, points.subspan(begin, n), order, f.subspan(begin, n),
                             gradient.empty() ? gradient : gradient.subspan(begin, n)};
        parallel_for(cells, 8, [&](std::size_t from, std::size_t to) {
            for (std::size_t c = from; c < to; ++c) {
                for (std::size_t i = start[c]; i < start[c + 1]; i += capacity) {
                    task.run(i, std::min<std::size_t>(start[c + 1], i + capacity));
                }
            }
        });
    }
}

}  // namespace geometry

#include "geometry/cubes/pieces.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/base/union_find.hpp"

#include <algorithm>
#include <bit>
#include <tuple>

namespace geometry {
namespace {

// All that links join to `seed` within a cell.
SubCells grown(SubCells seed, SubCells held, const HeldCells::Links& links)
{
    for (SubCells now = seed;;) {
        SubCells next = now;
        for (std::size_t d = 0; d < steps.size(); ++d) {
            next |= landed(now & links[d], steps[d]) & held;
            next |= landed(now, backwards(steps[d])) & links[d] & held;
        }
        if (next == now) return now;
        now = next;
    }
}

// The pieces of all cells.
struct Pieces {
    std::vector<std::uint32_t> first;  // C + 1, into part
    std::vector<SubCells> part;
};

Pieces find_pieces(const HeldCells& cells)
{
    const std::size_t n = cells.cells.size();
    std::vector<SubCells> lowest(n);  // the piece with the first quarter
    parallel_for(n, 1024, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const SubCells held = cells.held[c];
            const std::uint32_t links = cells.links_of[c];
            lowest[c] =
                links == no_index ? held : grown(held & (~held + 1), held, cells.links[links]);
        }
    });
    Pieces out;
    out.first.reserve(n + 1);
    out.part.reserve(n + n / 16);
    for (std::size_t c = 0; c < n; ++c) {
        out.first.push_back(static_cast<std::uint32_t>(out.part.size()));
        out.part.push_back(lowest[c]);
        for (SubCells rest = cells.held[c] & ~lowest[c]; rest != 0; rest &= ~out.part.back()) {
            out.part.push_back(
                grown(rest & (~rest + 1), cells.held[c], cells.links[cells.links_of[c]]));
        }
    }
    out.first.push_back(static_cast<std::uint32_t>(out.part.size()));
    return out;
}

// Joins the corners that cube a and cube b, whose cell lies `over` further on, have in common.
void join_corners(std::uint32_t a, std::uint32_t b, const Step& over, UnionFind& corners)
{
    for (std::uint32_t i = 0; i < 8; ++i) {
        std::uint32_t other = i;
        bool common = true;
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (over[k] == 0) continue;
            common = common && (i >> k & 1) == (over[k] > 0 ? 1u : 0u);
            other ^= 1u << k;
        }
        if (common) corners.join(8 * a + i, 8 * b + other);
    }
}

class Joiner {
public:
    Joiner(const HeldCells& cells, const Pieces& pieces)
        : cells_(cells), pieces_(pieces), index_(cells.cells), corners_(8 * pieces.part.size())
    {}

    UnionFind& join()
    {
        for (std::uint32_t c = 0; c < cells_.cells.size(); ++c) {
            for (int n = 0; n < 27; ++n) {
                const Step over{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
                if (n != 13) join_over(c, over);
            }
        }
        return corners_;
    }

private:
    void join_over(std::uint32_t c, const Step& over)
    {
        const std::uint32_t links = cells_.links_of[c];
        SubCells landing = 0;  // quarters there that any link leads to
        if (links == no_index) {
            for (std::size_t d = 0; d < 3; ++d) landing |= landed(all_sub_cells, steps[d], over);
        } else {
            for (std::size_t d = 0; d < steps.size(); ++d) {
                landing |= landed(cells_.links[links][d] & cells_.held[c], steps[d], over);
            }
        }
        if (landing == 0) return;
        const auto found = index_.find(cells_.cells[c] + Vec3i(over[0], over[1], over[2]));
        if (!found || (landing & cells_.held[found.begin]) == 0) return;
        for (std::uint32_t a = pieces_.first[c]; a < pieces_.first[c + 1]; ++a) {
            for (std::uint32_t b = pieces_.first[found.begin]; b < pieces_.first[found.begin + 1];
                 ++b) {
                if (linked(c, a, b, over)) join_corners(a, b, over, corners_);
            }
        }
    }

    bool linked(std::uint32_t c, std::uint32_t a, std::uint32_t b, const Step& over) const
    {
        const std::uint32_t links = cells_.links_of[c];
        const std::size_t count = links == no_index ? 3 : steps.size();
        for (std::size_t d = 0; d < count; ++d) {
            const SubCells from = links == no_index ? all_sub_cells : cells_.links[links][d];
            if (landed(from & pieces_.part[a], steps[d], over) & pieces_.part[b]) return true;
        }
        return false;
    }

    const HeldCells& cells_;
    const Pieces& pieces_;
    CellIndex index_;
    UnionFind corners_;
};

void number_joined_corners(UnionFind& joined, Cubes& cubes)
{
    const auto place = [&](std::uint32_t i) {
        const auto at = [&](std::uint32_t k) { return static_cast<int>(i >> k & 1); };
        return Vec3i(cubes.cell[i / 8] + Vec3i(at(0), at(1), at(2)));
    };
    struct Corner {
        Vec3i place;
        std::uint32_t root;
    };
    const std::vector<std::uint32_t> root = joined.roots();
    std::vector<Corner> corners;
    for (std::uint32_t i = 0; i < root.size(); ++i) {
        if (root[i] == i) corners.push_back({place(i), i});
    }
    std::sort(corners.begin(), corners.end(), [](const Corner& a, const Corner& b) {
        return std::tuple(a.place.z(), a.place.y(), a.place.x(), a.root) <
               std::tuple(b.place.z(), b.place.y(), b.place.x(), b.root);
    });
    std::vector<std::uint32_t> number(root.size());
    cubes.corner.clear();
    for (const Corner& c : corners) {
        number[c.root] = static_cast<std::uint32_t>(cubes.corner.size());
        cubes.corner.push_back(c.place);
    }
    cubes.corners.resize(cubes.cell.size());
    for (std::size_t i = 0; i < root.size(); ++i) {
        cubes.corners[i / 8][i % 8] = number[root[i]];
    }
}

}  // namespace

Cubes cubes_of_pieces(const HeldCells& cells, double size, const Vec3& origin)
{
    Pieces pieces = find_pieces(cells);
    Cubes cubes;
    cubes.size = size;
    cubes.origin = origin;
    cubes.cell.reserve(pieces.part.size());
    for (std::size_t c = 0; c < cells.cells.size(); ++c) {
        cubes.cell.insert(cubes.cell.end(), pieces.first[c + 1] - pieces.first[c], cells.cells[c]);
    }
    Joiner joiner(cells, pieces);
    number_joined_corners(joiner.join(), cubes);
    const auto copy = std::adjacent_find(cubes.corner.begin(), cubes.corner.end());
    if (copy != cubes.corner.end()) cubes.part = std::move(pieces.part);
    return cubes;
}

}  // namespace geometry

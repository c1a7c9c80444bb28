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
            next |= moves_on[d](now & links[d]) & held;
            next |= moves_back[d](now) & links[d] & held;
        }
        if (next == now) return now;
        now = next;
    }
}

// The pieces of all cells.
struct PiecesOfCells {
    std::vector<std::uint32_t> first;  // C + 1, into part
    std::vector<SubCells> part;
};

// Whether quarters of a come within `join` (in quarters) of those of b, whose cell lies `over`
// further on.
bool near(SubCells a, SubCells b, const Step& over, double join)
{
    const auto place = [](SubCells bits) {
        const int bit = std::countr_zero(bits);
        return Vec3i(bit & 3, bit >> 2 & 3, bit >> 4);
    };
    const Vec3i shift = across_cell * Vec3i(over[0], over[1], over[2]);
    for (; a != 0; a &= a - 1) {
        const Vec3i from = place(a) - shift;
        for (SubCells rest = b; rest != 0; rest &= rest - 1) {
            const Vec3i gap = ((place(rest) - from).cwiseAbs() - Vec3i::Ones()).cwiseMax(0);
            if (gap.cast<double>().squaredNorm() <= join * join) return true;
        }
    }
    return false;
}

// Makes one of pieces of a cell, from `first` on, that are near to each other.
void unite_near(std::vector<SubCells>& part, std::size_t first, double join)
{
    for (bool changed = true; changed;) {
        changed = false;
        for (std::size_t a = first; a < part.size(); ++a) {
            for (std::size_t b = a + 1; b < part.size(); ++b) {
                if (!near(part[a], part[b], {0, 0, 0}, join)) continue;
                part[a] |= part[b];
                part.erase(part.begin() + static_cast<std::ptrdiff_t>(b--));
                changed = true;
            }
        }
    }
}

// `join` is in quarters here and below.
PiecesOfCells find_pieces(const HeldCells& cells, double join)
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
    PiecesOfCells out;
    out.first.reserve(n + 1);
    out.part.reserve(n + n / 16);
    for (std::size_t c = 0; c < n; ++c) {
        out.first.push_back(static_cast<std::uint32_t>(out.part.size()));
        out.part.push_back(lowest[c]);
        for (SubCells rest = cells.held[c] & ~lowest[c]; rest != 0; rest &= ~out.part.back()) {
            out.part.push_back(
                grown(rest & (~rest + 1), cells.held[c], cells.links[cells.links_of[c]]));
        }
        if (join > 0) unite_near(out.part, out.first.back(), join);
    }
    out.first.push_back(static_cast<std::uint32_t>(out.part.size()));
    return out;
}

// Calls visit(i, j) for the corners that cube a and cube b, whose cell lies `over` further on, have
// in common, numbered 8 cube + corner.
template <class Visit>
void common_corners(std::uint32_t a, std::uint32_t b, const Step& over, const Visit& visit)
{
    for (std::uint32_t i = 0; i < 8; ++i) {
        std::uint32_t other = i;
        bool common = true;
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (over[k] == 0) continue;
            common = common && (i >> k & 1) == (over[k] > 0 ? 1u : 0u);
            other ^= 1u << k;
        }
        if (common) visit(8 * a + i, 8 * b + other);
    }
}

// The steps that lead over into a neighbouring cell.
struct StepsOver {
    struct Way {
        std::size_t step;
        Move move;
    };
    Step over{};
    std::vector<Way> ways;
};

std::vector<StepsOver> steps_over()
{
    std::vector<StepsOver> out;
    for (int n = 0; n < 27; ++n) {
        StepsOver to{{n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1}, {}};
        for (std::size_t d = 0; d < steps.size() && n != 13; ++d) {
            const Move way = move_of(steps[d], to.over);
            if (way.from != 0) to.ways.push_back({d, way});
        }
        if (!to.ways.empty()) out.push_back(to);
    }
    return out;
}

class Joiner {
public:
    Joiner(const HeldCells& cells, const PiecesOfCells& pieces)
        : cells_(cells), pieces_(pieces), index_(cells.cells), corners_(8 * pieces.part.size())
    {}

    UnionFind& join(double gap)
    {
        const std::vector<StepsOver> all = steps_over();
        for (std::uint32_t c = 0; c < cells_.cells.size(); ++c) {
            for (const StepsOver& to : all) join_over(c, to);
        }
        for (std::uint32_t c = 0; c < cells_.cells.size() && gap > 0; ++c) {
            for (const Step& over : steps) join_near(c, over, gap);
        }
        return corners_;
    }

private:
    // Of the cell's quarters, those that a step leads on from.
    SubCells linked_by(std::uint32_t c, std::size_t step) const
    {
        const std::uint32_t links = cells_.links_of[c];
        if (links == no_index) return step < 3 ? all_sub_cells : 0;
        return cells_.links[links][step] & cells_.held[c];
    }

    void join_corners(std::uint32_t a, std::uint32_t b, const Step& over)
    {
        common_corners(a, b, over, [&](std::uint32_t i, std::uint32_t j) { corners_.join(i, j); });
    }

    bool are_joined(std::uint32_t a, std::uint32_t b, const Step& over)
    {
        bool all = true;
        common_corners(a, b, over, [&](std::uint32_t i, std::uint32_t j) {
            all = all && corners_.root(i) == corners_.root(j);
        });
        return all;
    }

    void join_near(std::uint32_t c, const Step& over, double gap)
    {
        const auto found = index_.find(cells_.cells[c] + Vec3i(over[0], over[1], over[2]));
        if (!found) return;
        const std::uint32_t b_end = pieces_.first[found.begin + 1];
        for (std::uint32_t a = pieces_.first[c]; a < pieces_.first[c + 1]; ++a) {
            for (std::uint32_t b = pieces_.first[found.begin]; b < b_end; ++b) {
                if (are_joined(a, b, over)) continue;
                if (near(pieces_.part[a], pieces_.part[b], over, gap)) join_corners(a, b, over);
            }
        }
    }

    void join_over(std::uint32_t c, const StepsOver& to)
    {
        SubCells landing = 0;  // quarters there that any link leads to
        for (const auto& way : to.ways) landing |= way.move(linked_by(c, way.step));
        if (landing == 0) return;
        const Step& over = to.over;
        const auto found = index_.find(cells_.cells[c] + Vec3i(over[0], over[1], over[2]));
        if (!found || (landing & cells_.held[found.begin]) == 0) return;
        const std::uint32_t b_end = pieces_.first[found.begin + 1];
        for (std::uint32_t a = pieces_.first[c]; a < pieces_.first[c + 1]; ++a) {
            SubCells from_a = 0;
            for (const auto& way : to.ways) {
                from_a |= way.move(linked_by(c, way.step) & pieces_.part[a]);
            }
            for (std::uint32_t b = pieces_.first[found.begin]; b < b_end; ++b) {
                if (from_a & pieces_.part[b]) join_corners(a, b, over);
            }
        }
    }

    const HeldCells& cells_;
    const PiecesOfCells& pieces_;
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

Cubes cubes_of_pieces(const HeldCells& cells, double size, const Vec3& origin, double join)
{
    const double gap = across_cell * join / size;
    PiecesOfCells pieces = find_pieces(cells, gap);
    Cubes cubes;
    cubes.size = size;
    cubes.origin = origin;
    cubes.cell.reserve(pieces.part.size());
    for (std::size_t c = 0; c < cells.cells.size(); ++c) {
        cubes.cell.insert(cubes.cell.end(), pieces.first[c + 1] - pieces.first[c], cells.cells[c]);
    }
    Joiner joiner(cells, pieces);
    number_joined_corners(joiner.join(gap), cubes);
    const auto copy = std::adjacent_find(cubes.corner.begin(), cubes.corner.end());
    if (copy != cubes.corner.end()) cubes.part = std::move(pieces.part);
    return cubes;
}

}  // namespace geometry

#include "geometry/base/parallel.hpp"
#include "physics/lattice/lattice_contact.hpp"
#include "physics/lattice/near_pairs.hpp"

#include <algorithm>

namespace physics {

namespace {

// Pairs whose pushes one thread finds.
constexpr std::size_t pairs_a_task = 512;

// Room for pairs in rows: groups of a colour, of which the larger ones come first, eight abreast.
// Returns which groups are in each bunch, bunches + 1.
std::vector<std::uint32_t> arrange(const NearPairs& near, PairPushes& out)
{
    std::vector<std::uint32_t> group_at{0};
    out.bunch_at.assign(1, 0);
    out.colour_at.assign(1, 0);
    out.last_alone = near.last_alone;
    const auto count = [&](std::uint32_t g) { return near.group_at[g + 1] - near.group_at[g]; };
    const std::size_t colours = std::max<std::size_t>(near.colour_at.size(), 1) - 1;
    for (std::size_t c = 0; c < colours; ++c) {
        const bool alone = near.last_alone && c + 1 == colours;
        const std::uint32_t abreast = alone ? 1 : PairsAbreast::most, end = near.colour_at[c + 1];
        for (std::uint32_t g = near.colour_at[c]; g < end; g = group_at.back()) {
            out.bunch_at.push_back(out.bunch_at.back() + count(g));
            group_at.push_back(std::min(end, g + abreast));
        }
        out.colour_at.push_back(std::uint32_t(out.bunch_at.size() - 1));
    }
    out.row.resize(out.bunch_at.back());
    return group_at;
}

}  // namespace

void find_pair_pushes(const ContactScene& scene, const std::vector<std::uint32_t>& side,
                      const std::vector<std::uint32_t>& piece, double distance, double friction,
                      PairPushes& out, const NearAlong* along)
{
    const std::vector<Vec3>& v = scene.state.v;
    std::vector<BodyPoint> points(side.size());
    geometry::parallel_for(side.size(), pairs_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::uint32_t k = side[i];
            points[i] = {scene.state.x[k] + scene.dt * v[k], k, piece[k],
                         scene.inverse_mass[k] == 0};
        }
    });
    NearAlongBody near_along;
    if (along) near_along = [along](std::uint32_t a, std::uint32_t b) { return along->has(a, b); };
    const NearPairs near = find_near_pairs(points, distance, near_along);
    const std::vector<std::uint32_t> group_at = arrange(near, out);
    out.friction = float(friction);
    const auto add = [&](NearPairs::Pair pair, PairsAbreast& row) {
        const auto [a, b] = pair;
        const Vec3 relative = v[a] - v[b];
        const Vec3 apart = scene.state.x[a] - scene.state.x[b] + scene.dt * relative;
        const double length = apart.norm();
        const Vec3 normal = length > 0 ? Vec3(apart / length) : Vec3(Vec3::UnitY());
        const std::size_t k = row.count++;
        row.a[k] = a;
        row.b[k] = b;
        row.mass[k] = float(1 / (scene.inverse_mass[a] + scene.inverse_mass[b]));
        for (int d = 0; d < 3; ++d) row.normal[d][k] = float(normal[d]);
        row.bias[k] = float(bias_of(length - distance, relative.dot(normal), scene.dt));
    };
    const std::size_t bunches = group_at.size() - 1;
    geometry::parallel_for(bunches, 1, [&](std::size_t begin, std::size_t end) {
        for (std::size_t bunch = begin; bunch < end; ++bunch) {
            PairsAbreast* const rows = out.row.data() + out.bunch_at[bunch];
            std::fill_n(rows, out.bunch_at[bunch + 1] - out.bunch_at[bunch], PairsAbreast{});
            for (auto g = group_at[bunch]; g < group_at[bunch + 1]; ++g) {
                const std::uint32_t first = near.group_at[g], last = near.group_at[g + 1];
                for (auto k = first; k < last; ++k) add(near.pair[k], rows[k - first]);
            }
        }
    });
}

}  // namespace physics

#include "geometry/cubes/fill_cubes.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/parallel.hpp"
#include "geometry/cells/cell_set.hpp"
#include "geometry/cubes/cube_finder.hpp"

#include <algorithm>
#include <stdexcept>

namespace geometry {
namespace {

constexpr std::size_t cells_a_task = 16384;

void resize(Cubes& cubes)
{
    const std::size_t n = cubes.count();
    cubes.mass.assign(n, 0.0);
    cubes.fill.assign(n, 0.0);
    for (auto* property :
         {&cubes.young, &cubes.poisson, &cubes.mass_damping, &cubes.stiffness_damping}) {
        property->resize(n);
    }
    cubes.matter.assign(n, 0);
}

void take_after(Cubes& cubes, std::size_t c, const Matter& m)
{
    cubes.young[c] = m.young;
    cubes.poisson[c] = m.poisson;
    cubes.mass_damping[c] = m.mass_damping;
    cubes.stiffness_damping[c] = m.stiffness_damping;
}

// One matter: volumes add up and nothing needs averaging. `fill` holds volumes for now.
void deposit_one(Cubes& cubes, std::span<const Deposit> deposits)
{
    for (const Deposit& d : deposits) cubes.fill[d.cube] += d.volume;
    parallel_for(cubes.count(), cells_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            cubes.mass[c] = cubes.matters[0].density * cubes.fill[c];
            take_after(cubes, c, cubes.matters[0]);
        }
    });
}

// Deposits by cube, in their order within each.
struct ByCube {
    std::vector<std::uint32_t> start;  // C + 1
    std::vector<std::uint32_t> deposit;
};

ByCube sort_by_cube(std::size_t count, std::span<const Deposit> deposits)
{
    ByCube out;
    out.start.assign(count + 1, 0);
    for (const Deposit& d : deposits) ++out.start[d.cube + 1];
    for (std::size_t c = 0; c < count; ++c) out.start[c + 1] += out.start[c];
    std::vector<std::uint32_t> next(out.start.begin(), out.start.end() - 1);
    out.deposit.resize(deposits.size());
    for (std::uint32_t i = 0; i < deposits.size(); ++i) out.deposit[next[deposits[i].cube]++] = i;
    return out;
}

void deposit_many(Cubes& cubes, std::span<const Deposit> deposits)
{
    const ByCube by_cube = sort_by_cube(cubes.count(), deposits);
    parallel_for(cubes.count(), 1024, [&](std::size_t begin, std::size_t end) {
        struct Share {
            std::uint16_t matter;
            double volume;
        };
        std::vector<Share> shares;
        for (std::size_t c = begin; c < end; ++c) {
            shares.clear();
            for (std::uint32_t i = by_cube.start[c]; i < by_cube.start[c + 1]; ++i) {
                const Deposit& d = deposits[by_cube.deposit[i]];
                cubes.fill[c] += d.volume;
                cubes.mass[c] += cubes.matters[d.matter].density * d.volume;
                const auto known = std::find_if(shares.begin(), shares.end(), [&](const Share& s) {
                    return s.matter == d.matter;
                });
                if (known != shares.end())
                    known->volume += d.volume;
                else
                    shares.push_back({d.matter, d.volume});
            }
            if (!(cubes.mass[c] > 0)) continue;
            std::sort(shares.begin(), shares.end(),
                      [](const Share& a, const Share& b) { return a.matter < b.matter; });
            Matter mean{.young = 0, .poisson = 0};
            double most = -1;
            for (const auto& [m, volume] : shares) {
                const Matter& matter = cubes.matters[m];
                const double mass = matter.density * volume, share = volume / cubes.fill[c];
                mean.young += share * matter.young;
                mean.poisson += share * matter.poisson;
                mean.mass_damping += mass / cubes.mass[c] * matter.mass_damping;
                mean.stiffness_damping += share * matter.young * matter.stiffness_damping;
                if (mass > most) most = mass, cubes.matter[c] = m;
            }
            mean.stiffness_damping /= mean.young;
            take_after(cubes, c, mean);
        }
    });
}

// A cube with mass in the cells around one without: of its own piece if there is one.
std::uint32_t model_of(const Cubes& cubes, const CellIndex& index, std::uint32_t bare)
{
    std::uint32_t other = no_index;
    for (int n = 0; n < 27; ++n) {
        const Vec3i step(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1);
        const auto found = index.find(cubes.cell[bare] + step);
        for (std::uint32_t c = found.begin; c < found.end; ++c) {
            if (!(cubes.mass[c] > 0)) continue;
            if (share_a_corner(cubes, bare, c)) return c;
            if (other == no_index) other = c;
        }
    }
    return other;
}

// Cubes that the model only touches, in a corner say.
void fill_untouched(Cubes& cubes)
{
    std::vector<std::uint32_t> bare;
    for (std::uint32_t c = 0; c < cubes.count(); ++c) {
        if (!(cubes.mass[c] > 0)) bare.push_back(c);
    }
    if (bare.empty()) return;
    if (cubes.matters.size() == 1) {
        for (const std::uint32_t c : bare) take_after(cubes, c, cubes.matters[0]);
        return;
    }
    const CellIndex index(cubes.cell);
    std::vector<std::uint32_t> model(bare.size(), no_index);
    for (std::size_t i = 0; i < bare.size(); ++i) model[i] = model_of(cubes, index, bare[i]);
    for (std::size_t i = 0; i < bare.size(); ++i) {
        const std::uint32_t c = bare[i];
        if (model[i] == no_index) {
            take_after(cubes, c, cubes.matters[0]);
            continue;
        }
        cubes.matter[c] = cubes.matter[model[i]];
        take_after(cubes, c, cubes.matters[cubes.matter[c]]);
    }
}

double sum(const std::vector<double>& values)
{
    return ordered_sum(values.size(), cells_a_task, 0.0, [&](std::size_t begin, std::size_t end) {
        double s = 0;
        for (std::size_t i = begin; i < end; ++i) s += values[i];
        return s;
    });
}

}  // namespace

void fill_cubes(Cubes& cubes, std::span<const Matter> matters, std::span<const Deposit> deposits,
                const VoxelOptions& options)
{
    cubes.matters.assign(matters.begin(), matters.end());
    resize(cubes);
    if (cubes.matters.size() == 1)
        deposit_one(cubes, deposits);
    else
        deposit_many(cubes, deposits);
    fill_untouched(cubes);

    const bool stated = options.total_mass > 0;
    const double intended = stated ? options.total_mass : sum(cubes.mass);
    const double whole = cubes.size * cubes.size * cubes.size;  // m^3
    const double least = std::clamp(options.min_fill, 1e-9, 1.0) * whole;
    parallel_for(cubes.count(), cells_a_task, [&](std::size_t begin, std::size_t end) {
        for (std::size_t c = begin; c < end; ++c) {
            const double volume = cubes.fill[c];
            if (volume < least) {
                const double density =
                    volume > 0 ? cubes.mass[c] / volume : cubes.matters[cubes.matter[c]].density;
                cubes.mass[c] = density * least;
            }
            cubes.fill[c] = std::clamp(volume, least, whole) / whole;
        }
    });
    const double now = sum(cubes.mass);
    // A model that only touches cubes (a point, a segment) keeps what min_fill gave it, where its
    // mass is not stated.
    const double scale = stated || intended > 1e-6 * now ? intended / now : 1;
    for (double& m : cubes.mass) m *= scale;
}

}  // namespace geometry

#include "physics/body/body_models.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/cubes/plane.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

namespace physics {
namespace {

using geometry::Cubes;
using geometry::Vec3i;

template <class T> void append(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

// How far the cells of `next` go up so that they begin two layers above all that came before, a
// multiple of what multigrid halves.
int lift_above(int top, const Cubes& next)
{
    constexpr std::int64_t coarsest = 64;
    std::int64_t lowest = std::numeric_limits<int>::max();
    for (const Vec3i& c : next.corner) lowest = std::min<std::int64_t>(lowest, c.z());
    const std::int64_t lift = std::int64_t{top} + 2 - lowest;
    const std::int64_t whole = (lift + coarsest - 1) / coarsest * coarsest;
    return static_cast<int>(whole);
}

// `all` has the cubes of `next` already.
void append_own(Cubes& all, const Cubes& next)
{
    if (all.own.empty() && next.own.empty()) return;
    const auto first = static_cast<std::uint32_t>(all.elements.size());
    all.own.resize(all.count() - next.count(), geometry::no_index);
    for (const auto own : next.own) {
        all.own.push_back(own == geometry::no_index ? own : first + own);
    }
    all.own.resize(all.count(), geometry::no_index);
    append(all.elements, next.elements);
}

void append(Cubes& all, const Cubes& next, int lift)
{
    const auto first = static_cast<std::uint32_t>(all.corner_count());
    const auto first_matter = static_cast<std::uint16_t>(all.matters.size());
    for (Vec3i c : next.cell) all.cell.push_back(c += Vec3i(0, 0, lift));
    for (Vec3i c : next.corner) all.corner.push_back(c += Vec3i(0, 0, lift));
    for (auto corners : next.corners) {
        for (auto& k : corners) k += first;
        all.corners.push_back(corners);
    }
    if (next.is_sheet() || all.is_sheet()) {
        // Corners of planes that came before rest on their lattices, which only they know.
        all.place.resize(all.corner.size() - next.corner_count(), geometry::Vec3::Zero());
        for (std::size_t k = 0; k < next.corner_count(); ++k) {
            all.place.push_back(next.corner_position(k));
        }
    }
    append(all.mass, next.mass);
    append(all.fill, next.fill);
    append(all.young, next.young);
    append(all.poisson, next.poisson);
    append(all.mass_damping, next.mass_damping);
    append(all.stiffness_damping, next.stiffness_damping);
    for (auto matter : next.matter) {
        all.matter.push_back(static_cast<std::uint16_t>(matter + first_matter));
    }
    append(all.matters, next.matters);
    append_own(all, next);
}

void need_cubes(const Cubes& cubes, std::size_t number)
{
    if (cubes.count() == 0) {
        throw std::invalid_argument("model " + std::to_string(number + 1) +
                                    " of the body has no cubes: unlink it, or check its mesh");
    }
    for (const auto& corners : cubes.corners) {
        for (const auto k : corners) {
            if (k < cubes.corner_count()) continue;
            throw std::invalid_argument("model " + std::to_string(number + 1) +
                                        " of the body: expected corners that exist, found " +
                                        std::to_string(k));
        }
    }
    geometry::check_elements(cubes);
    for (const std::size_t length :
         {cubes.corners.size(), cubes.mass.size(), cubes.fill.size(), cubes.young.size(),
          cubes.poisson.size(), cubes.mass_damping.size(), cubes.stiffness_damping.size()}) {
        if (length == cubes.count()) continue;
        throw std::invalid_argument("model " + std::to_string(number + 1) +
                                    " of the body: expected " + std::to_string(cubes.count()) +
                                    " entries in every array, found " + std::to_string(length));
    }
}

}  // namespace

BodyModels::BodyModels(std::span<const BodyModel> models, ModelKind kind)
    : models_(models.begin(), models.end())
{
    if (models_.empty()) throw std::invalid_argument("a body needs a model of cubes");
    place();
    if (models_.size() == 1) return;
    bool pieces = false;
    for (std::size_t m = 0; m < models_.size(); ++m) {
        const Cubes& cubes = *models_[m].cubes;
        need_cubes(cubes, m);
        const bool flat = geometry::flat_axis(cubes) >= 0;
        if (flat != (kind == ModelKind::plane)) {
            throw std::invalid_argument(
                "model " + std::to_string(m + 1) + " of " + std::to_string(models_.size()) +
                (flat ? " is a plane or a sheet: simulate these by method shell, apart from other "
                        "cubes"
                      : " has a thickness: method shell simulates planes and sheets alone"));
        }
        pieces |= !cubes.part.empty();
    }
    int top = std::numeric_limits<int>::min();
    for (const BodyModel& model : models_) {
        const Cubes& cubes = *model.cubes;
        append(joined_, cubes, joined_.cell.empty() ? 0 : lift_above(top, cubes));
        for (std::size_t k = joined_.corner.size() - cubes.corner_count();
             k < joined_.corner.size(); ++k) {
            top = std::max(top, joined_.corner[k].z());
        }
        if (!pieces) continue;
        append(joined_.part, cubes.part);
        joined_.part.resize(joined_.cell.size(), ~std::uint64_t{0});
    }
    joined_.size = models_[0].cubes->size;
    joined_.origin = models_[0].cubes->origin;
}

BodyModels::BodyModels(const Cubes& cubes, const geometry::TriMesh* surface)
    : models_{{&cubes, surface}}
{
    place();
}

void BodyModels::place()
{
    ModelStart at;
    for (const BodyModel& model : models_) {
        start_.push_back(at);
        at.cube += static_cast<std::uint32_t>(model.cubes->count());
        at.corner += static_cast<std::uint32_t>(model.cubes->corner_count());
    }
    start_.push_back(at);
}

std::size_t BodyModels::model_of(std::uint32_t cube) const
{
    if (models_.size() == 1) return 0;
    const auto next =
        std::upper_bound(start_.begin(), start_.end(), cube,
                         [](std::uint32_t c, const ModelStart& start) { return c < start.cube; });
    return static_cast<std::size_t>(next - start_.begin()) - 1;
}

double BodyModels::least_edge() const
{
    double least = models_[0].cubes->size;
    for (const BodyModel& model : models_) least = std::min(least, model.cubes->size);
    return least;
}

bool BodyModels::alike() const
{
    return std::all_of(models_.begin(), models_.end(), [&](const BodyModel& model) {
        return model.cubes->size == models_[0].cubes->size;
    });
}

}  // namespace physics

#include "physics/state/state_models.hpp"

#include "geometry/cubes/plane.hpp"
#include "physics/math/mark.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace physics {
namespace {

std::uint64_t word_of(int number)
{
    return static_cast<std::uint32_t>(number);
}

template <class T>
std::vector<T> part_of(const std::vector<T>& all, std::size_t begin, std::size_t count)
{
    if (begin + count > all.size()) return {};  // what a method does not compute is empty
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(begin);
    return {first, first + static_cast<std::ptrdiff_t>(count)};
}

// Of a model of which nothing is known, as of a sheet beside solids, it is empty too.
std::vector<float> known_part_of(const std::vector<float>& all, const StateModel& model)
{
    std::vector<float> out = part_of(all, model.cube, model.cubes);
    if (!out.empty() && std::isnan(out[0])) out.clear();
    return out;
}

bool has_corner(const StateModel& model, std::uint32_t corner)
{
    return corner >= model.corner && corner - model.corner < model.corners;
}

std::vector<Reaction> part_of(const std::vector<Reaction>& all, const StateModel& model)
{
    std::vector<Reaction> out;
    for (Reaction reaction : all) {
        if (!has_corner(model, reaction.corner)) continue;
        reaction.corner -= model.corner;
        out.push_back(reaction);
    }
    return out;
}

}  // namespace

std::uint64_t mark_of(const geometry::Cubes& cubes)
{
    Mark mark;
    mark.add(cubes.size);
    for (const double x : cubes.origin) mark.add(x);
    mark.add(std::uint64_t{cubes.corner_count()});
    for (std::size_t c = 0; c < cubes.count(); ++c) {
        const geometry::Vec3i& cell = cubes.cell[c];
        mark.add(word_of(cell.x()) << 32 | word_of(cell.y()));
        mark.add(word_of(cell.z()));
        mark.add(cubes.mass[c]);
    }
    for (const geometry::Vec3& place : cubes.place) {
        for (const double x : place) mark.add(x);
    }
    return mark.value();
}

std::vector<StateModel> number_models(ModelsOfState models)
{
    std::vector<StateModel> out;
    if (models.size() < 2) return out;
    std::uint32_t corner = 0, cube = 0;
    for (const auto& cubes : models) {
        const StateModel model{mark_of(*cubes), corner,
                               static_cast<std::uint32_t>(cubes->corner_count()), cube,
                               static_cast<std::uint32_t>(cubes->count())};
        for (std::size_t i = 0; i < out.size(); ++i) {
            if (out[i].mark != model.mark) continue;
            throw std::invalid_argument(
                fmt::format("cubes {} and {} of {} are the same, so that both bodies would lie in "
                            "one place: move one with Transform before Voxelize, or unlink it",
                            i + 1, out.size() + 1, models.size()));
        }
        out.push_back(model);
        corner += model.corners, cube += model.cubes;
    }
    return out;
}

const StateModel& model_of(const State& state, const geometry::Cubes& cubes)
{
    const std::uint64_t mark = mark_of(cubes);
    const auto found = std::find_if(state.models.begin(), state.models.end(),
                                    [&](const StateModel& model) { return model.mark == mark; });
    if (found == state.models.end()) {
        throw std::invalid_argument(
            fmt::format("the state is of {} bodies, and none has these cubes: link `cubes` to one "
                        "of the nodes that Simulate takes its cubes from",
                        state.models.size()));
    }
    return *found;
}

std::shared_ptr<const State> state_of(const std::shared_ptr<const State>& state,
                                      const geometry::Cubes& cubes)
{
    if (!state || state->models.empty()) return state;
    const StateModel* const found = &model_of(*state, cubes);
    State out;
    out.time = state->time;
    out.x = part_of(state->x, found->corner, found->corners);
    out.v = part_of(state->v, found->corner, found->corners);
    out.brick_mass = state->brick_mass && geometry::flat_axis(cubes) < 0;
    if (state->plastic_of == PlasticOf::bricks) {
        const StateModel& last = state->models.back();
        const std::size_t rows = state->plastic.size() / (last.cube + last.cubes);
        out.plastic = part_of(state->plastic, rows * found->cube, rows * found->cubes);
        out.plastic_of = PlasticOf::bricks;
    }
    out.plastic_strain = part_of(state->plastic_strain, found->cube, found->cubes);
    out.stress = known_part_of(state->stress, *found);
    out.energy = known_part_of(state->energy, *found);
    out.reactions = part_of(state->reactions, *found);
    out.held_forces = part_of(state->held_forces, *found);
    for (std::size_t i = 0; i < std::min(state->held.size(), state->held_forces.size()); ++i) {
        if (has_corner(*found, state->held_forces[i].corner)) out.held.push_back(state->held[i]);
    }
    out.report = state->report;
    return std::make_shared<const State>(std::move(out));
}

std::shared_ptr<const Pins> pins_of_all(const std::shared_ptr<const Pins>& pins,
                                        const std::vector<StateModel>& models)
{
    if (models.empty() || pins->empty()) return pins;
    const auto found = std::find_if(models.begin(), models.end(), [&](const StateModel& model) {
        return model.mark == pins->cubes;
    });
    if (found == models.end()) {
        throw std::invalid_argument(
            fmt::format("pins of corners of other cubes than the {} that are simulated: link Pin "
                        "to one of the nodes that Simulate takes its cubes from",
                        models.size()));
    }
    Pins out = *pins;
    for (auto& corner : out.corner) corner += found->corner;
    for (auto& corner : out.matter.corner) corner += found->corner;
    for (auto& cube : out.matter.cubes) cube.cube += found->cube;
    return std::make_shared<const Pins>(std::move(out));
}

}  // namespace physics

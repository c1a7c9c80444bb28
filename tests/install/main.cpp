// A box set in cubes falls freely for a tenth of a second, by g t^2 / 2. And a graph document is
// read, which is wrong.

#include "geometry/cubes/voxelize.hpp"
#include "geometry/mesh/mesh.hpp"
#include "geometry/mesh/primitive.hpp"
#include "graph/document/document.hpp"
#include "graph/types/node_type.hpp"
#include "physics/bricks/bricks.hpp"
#include "physics/state/loads.hpp"

#include <cmath>
#include <cstdio>

int main()
{
    const auto mesh = geometry::box({1, 1, 1}, {2, 2, 2});
    const auto cubes =
        geometry::voxelize_solid(mesh, geometry::assign_matter(mesh, {}, {}), {}, 0,
                                 geometry::fit_grid(geometry::bounds(mesh), 0.5), {});
    const auto body = physics::make_bricks(cubes);
    auto state = physics::rest_state(body);
    const double before = state.x[0].y(), dt = 0.01;
    physics::Loads loads;
    loads.forces = {physics::Force{}};
    for (int i = 0; i < 10; ++i) state = physics::advance(body, std::move(state), loads, dt);
    const double fallen = before - state.x[0].y(), expected = 9.81 * 0.1 * 0.1 / 2;
    std::printf("%zu cubes fell %.6f m\n", cubes.count(), fallen);

    const graph::Registry registry;
    const graph::Loaded loaded = graph::load_text("{}", "empty.json", registry);
    std::printf("%zu problems\n", loaded.problems.size());
    return std::abs(fallen - expected) < 1e-9 && !loaded.ok() ? 0 : 1;
}

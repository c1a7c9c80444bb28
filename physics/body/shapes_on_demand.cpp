#include "physics/body/shapes_on_demand.hpp"

#include "geometry/cubes/plane.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/body/make_part_shapes.hpp"

#include <tbb/collaborative_call_once.h>

#include <utility>

namespace physics {

// The models are copies, as those that a body is made of need not outlive it.
struct ShapesOnDemand::Made {
    std::vector<geometry::Cubes> cubes;
    std::vector<geometry::TriMesh> surfaces;
    std::vector<BodyModel> models;
    CornerBody body;  // as much of it as shapes need
    tbb::collaborative_once_flag once;
    std::shared_ptr<const PartShapes> shapes;
};

ShapesOnDemand::ShapesOnDemand(std::shared_ptr<const PartShapes> made)
    : made_(std::make_unique<Made>())
{
    made_->shapes = std::move(made);
}

ShapesOnDemand::ShapesOnDemand(const BodyModels& models, const CornerBody& body)
    : made_(std::make_unique<Made>())
{
    CornerBody& kept = made_->body;
    kept.h = body.h;
    kept.corners = body.corners;
    kept.slot = body.slot;
    kept.part = body.part;
    kept.parts = body.parts;
    made_->cubes.reserve(models.count());
    made_->surfaces.reserve(models.count());
    for (std::size_t m = 0; m < models.count(); ++m) {
        const auto [cubes, surface] = models.model(m);
        made_->cubes.push_back(*cubes);
        geometry::TriMesh& mesh = made_->surfaces.emplace_back();
        if (surface) mesh.topology = surface->topology, mesh.positions = surface->positions;
        made_->models.push_back({&made_->cubes.back(), surface ? &mesh : nullptr});
    }
}

ShapesOnDemand::~ShapesOnDemand() = default;

const PartShapes& ShapesOnDemand::get() const
{
    if (made_->models.empty()) return *made_->shapes;
    tbb::collaborative_call_once(made_->once, [&] {
        made_->shapes = std::make_shared<const PartShapes>(
            make_outlines(BodyModels(made_->models), made_->body));
    });
    return *made_->shapes;
}

std::size_t ShapesOnDemand::parts() const
{
    return made_->models.empty() ? made_->shapes->parts() : made_->body.parts;
}

std::size_t ShapesOnDemand::bytes() const
{
    std::size_t out = sizeof(Made);
    for (const geometry::Cubes& cubes : made_->cubes) {
        out += cubes.count() * (sizeof cubes.corners[0] + sizeof cubes.cell[0] + 48);
        out += cubes.corner_count() * sizeof cubes.corner[0];
    }
    for (const geometry::TriMesh& mesh : made_->surfaces) {
        out += mesh.positions.size() * sizeof mesh.positions[0];
    }
    return out;
}

void give_shapes(const BodyModels& models, const PartContactOptions& options, CornerBody& body)
{
    body.shapes = shapes_that_touch(models, body, options);
    if (geometry::flat_axis(models.all()) >= 0) return;
    body.outlines = body.shapes ? std::make_shared<const ShapesOnDemand>(body.shapes)
                                : std::make_shared<const ShapesOnDemand>(models, body);
}

}  // namespace physics

#pragma once

// The closed shapes of a body's parts, made when an edge of a collider comes near one of them for
// the first time: most bodies that touch nothing but grounds need none.

#include "physics/body/corner_body.hpp"
#include "physics/body/part_shapes.hpp"

#include <memory>

namespace physics {

class ShapesOnDemand {
public:
    explicit ShapesOnDemand(std::shared_ptr<const PartShapes> made);
    // Keeps copies of the models.
    ShapesOnDemand(const BodyModels& models, const CornerBody& body);
    ~ShapesOnDemand();
    ShapesOnDemand(const ShapesOnDemand&) = delete;
    ShapesOnDemand& operator=(const ShapesOnDemand&) = delete;

    // May be called from several threads. The shapes may lack points (make_outlines()).
    const PartShapes& get() const;
    std::size_t parts() const;
    std::size_t bytes() const;  // before it is asked for shapes

private:
    struct Made;
    std::unique_ptr<Made> made_;
};

// Gives a body of these solid models its `shapes` and `outlines`.
void give_shapes(const BodyModels& models, const PartContactOptions& options, CornerBody& body);

}  // namespace physics

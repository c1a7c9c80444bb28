#pragma once

// Several models of cubes that are simulated as one body: each with its own size, place and
// surface. What depends on which cubes share corners is asked of all of them together; what depends
// on where they lie, of each model alone.

#include "geometry/cubes/cubes.hpp"
#include "geometry/mesh/mesh_fwd.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace physics {

// A model, and the mesh that contact and wind act on; null: the outside of its cubes.
struct BodyModel {
    const geometry::Cubes* cubes = nullptr;
    const geometry::TriMesh* surface = nullptr;
};

// Whether cubes have a thickness (geometry/cubes/plane.hpp).
enum class ModelKind { solid, plane };

// Where a model's cubes and corners begin among those of all.
struct ModelStart {
    std::uint32_t cube = 0, corner = 0;
};

class BodyModels {
public:
    // The models must outlive this. Throws std::invalid_argument when there is none, or when one of
    // several is of another kind.
    explicit BodyModels(std::span<const BodyModel> models, ModelKind kind = ModelKind::solid);
    // Of one alone.
    BodyModels(const geometry::Cubes& cubes, const geometry::TriMesh* surface);

    // All models as one. Their cells lie apart, so that only `size` and `origin`, and what follows
    // from them, do not hold: ask edge_of() and corner_position().
    const geometry::Cubes& all() const { return models_.size() == 1 ? *models_[0].cubes : joined_; }

    std::size_t count() const { return models_.size(); }
    const BodyModel& model(std::size_t m) const { return models_[m]; }
    ModelStart start(std::size_t m) const { return start_[m]; }  // m <= count(): there, the ends
    std::size_t model_of(std::uint32_t cube) const;

    double edge_of(std::uint32_t cube) const { return models_[model_of(cube)].cubes->size; }  // m
    double least_edge() const;                                                                // m
    bool alike() const;  // all edges are equal

private:
    void place();

    std::vector<BodyModel> models_;
    std::vector<ModelStart> start_;
    geometry::Cubes joined_;  // empty where there is one
};

}  // namespace physics

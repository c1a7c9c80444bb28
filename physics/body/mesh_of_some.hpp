#pragma once

// Makes meshes of some of the triangles of another one, or of other lists of positions.

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace physics {

// A mesh of some triangles with the positions that they use.
class MeshOfSome {
public:
    explicit MeshOfSome(std::size_t positions) : number_(positions, geometry::no_index) {}

    template <class At> void add(const geometry::Triangle& t, const At& at)
    {
        geometry::Triangle own;
        for (std::size_t i = 0; i < 3; ++i) {
            auto& number = number_[t[i]];
            if (number == geometry::no_index) {
                number = static_cast<std::uint32_t>(used_.size());
                used_.push_back(t[i]);
                mesh_.positions.push_back(at(t[i]));
            }
            own[i] = number;
        }
        triangles_.push_back(own);
    }

    // The mesh so far; starts again.
    geometry::TriMesh take()
    {
        for (const auto i : used_) number_[i] = geometry::no_index;
        used_.clear();
        geometry::MeshTopology topology;
        topology.triangles = std::exchange(triangles_, {});
        mesh_.topology = std::make_shared<const geometry::MeshTopology>(std::move(topology));
        return std::exchange(mesh_, {});
    }

private:
    std::vector<std::uint32_t> number_, used_;
    std::vector<geometry::Triangle> triangles_;
    geometry::TriMesh mesh_;
};

}  // namespace physics

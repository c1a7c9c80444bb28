#pragma once

// Points of a collider that stand out of it: its corners, and points along its sharp edges. A body
// whose own points lie about a cube apart meets a rail, a post or a blade between them: these meet
// it instead (feature_touches.hpp). Where a collider is flat or but slightly bent they are not
// needed, as the body's points cannot pass it there.
//
// An edge is sharp where its faces turn by more than 30 degrees, or by more than a surface with a
// radius of a cube turns from the middle of one of them to that of the other. Edges that lead in
// are none. A sphere smaller than a cube is one round point.

#include "physics/body/collider_contact.hpp"

#include <memory>
#include <mutex>
#include <vector>

namespace physics {

struct FeaturePoint {
    std::uint32_t number = 0;     // among those of its collider, from step to step; < 2^31
    Vec3 place = Vec3::Zero();    // m
    Vec3 outward = Vec3::Zero();  // unit, the mean of the faces there; 0: any side is out
    double radius = 0;            // m, of a ball about the place
};

// The box around a collider that has such points for cubes of h (m); empty where it has none.
geometry::Box bounds_of_features(const PosedCollider& collider, double h);

// The points of a collider in a box, a quarter of a cube of h (m) apart along edges. Of a mesh,
// those that crowd in a twelfth of a cube and look the same way are one. With `features`, that one
// may lie outside of the box.
std::vector<FeaturePoint> features_in(const PosedCollider& collider, const geometry::Box& region,
                                      double h);

// The points of a mesh that stays where it is: found at the first search for cubes of a size, where
// they are not too many to keep.
class KeptFeatures {
public:
    KeptFeatures();
    ~KeptFeatures();
    KeptFeatures(const KeptFeatures&) = delete;
    KeptFeatures& operator=(const KeptFeatures&) = delete;

    // All points of the mesh that `collider` has, which is the same at each call; null: too many.
    // May be called from several threads.
    struct OfSize;
    const OfSize* find(const PosedCollider& collider, double h) const;

private:
    mutable std::mutex making_;
    mutable std::vector<std::unique_ptr<const OfSize>> sizes_;
};

}  // namespace physics

#pragma once

// What goes into contact between layered bodies, and what comes out: bodies as they stand, the
// samples that touch, the points of skeletons that are stopped, forces.
//
//   ContactBody  --find_contacts()-->  Contacts { LayerContact, LayerStop, Wrench }
//                  layer_contact.hpp     a sample    a skeleton's   of all of
//                                        touches     point is near  them, a frame

#include "geometry/base/no_index.hpp"
#include "physics/layers/sample_walk.hpp"

#include <limits>
#include <memory>
#include <span>
#include <vector>

namespace physics {

// How a layer behaves in contact.
struct LayerMatter {
    double stiffness = 1e4;  // K, N/m^2 per unit of the field
    double friction = 100;   // lambda, N s/m^3: per area and relative velocity
    // e, of soft ones: share of the speed of an impact that they part with.
    double restitution = 1;
    double bulge_width = 0.1;   // w, m, how far beyond a contact the layer bulges
    double bulge_height = 0.5;  // alpha, of the largest compression
    // Of rigid ones: the largest traction along the surface, as a share of the pressure (Coulomb).
    double grip = std::numeric_limits<double>::infinity();
    bool rigid = false;         // does not deform, others fit it; needs no samples
    double bounce = 0;          // of rigid ones against rigid ones: speed after a hit over before
    bool self_contact = false;  // skeletons that do not blend with each other collide
    bool operator==(const LayerMatter&) const = default;
};

// A mesh that changes its shape: where its vertices were `seconds` ago.
struct MovingMesh {
    std::shared_ptr<const geometry::SkeletonMesh> now;
    std::shared_ptr<const geometry::TriMesh> before;  // of the same topology
    double seconds = 0;
};

// Skeletons that change their shape or size inside their frames, each straight from `before` to
// `after` in so many seconds; the kinds and numbers of points stay.
struct ShapeChange {
    std::vector<geometry::Skeleton> before, after;  // S
    double seconds = 0;
};

// Velocity of a carrier's frame.
struct Twist {
    Vec3 linear = Vec3::Zero();   // m/s, of the frame's origin
    Vec3 angular = Vec3::Zero();  // rad/s
};

// One object, as it stands now. What the pointers name must outlive the call.
struct ContactBody {
    const Field* field = nullptr;
    const SurfaceSamples* samples = nullptr;  // null: emits none
    const SampleWalk* walk = nullptr;         // of those samples on that field
    std::span<const Transform> frames;
    std::span<const Twist> twists;            // one a frame
    std::span<const std::uint32_t> frame_of;  // S, frame of each skeleton
    LayerMatter matter;
    const MovingMesh* moving = nullptr;  // null: moves with its frames alone
    bool drawn = true;  // samples that touch nothing go to the surface that is drawn
    const ShapeChange* change = nullptr;                 // null: skeletons keep their shapes
    std::span<const geometry::Skeleton> skeletons = {};  // S, with `change`: as they are now
};

inline constexpr std::uint32_t no_contact = geometry::no_index;

// A sample on a common surface.
struct LayerContact {
    std::uint32_t body, sample;           // whose sample it is
    std::uint32_t skeleton;               // which one emitted it
    std::uint32_t other, other_skeleton;  // what it touches: body and territory
    Vec3 position;                        // m, on the deformed surface
    Vec3 normal;                          // outward from `body`
    double area;                          // m^2, of the deformed surface, inside the contact
    double compression;                   // -g, units of the field
    double load;                          // m^2, of -g over what the sample stands for
    double distance;                      // m, along the sample's ray
    Vec3 force;                           // N, on `body`; its opposite acts on `other`
};

// A sample that touches nothing, where the surface that is drawn is not where it stopped: a bulge
// moves it, or skeletons that its own does not blend with.
struct DrawnSample {
    std::uint32_t body = 0, sample = 0;
    std::uint32_t skeleton = 0;     // which one emitted it
    Vec3 position = Vec3::Zero();   // m, on the deformed surface
    Vec3 normal = Vec3::UnitY();    // outward
    double area = 0, distance = 0;  // m^2; m, along the sample's ray
};

// A point of a skeleton that another body comes near to: there the layer has nothing left to give.
// Contact is exact only while skeletons themselves stay out of other bodies: f_i >= f_j on them,
// f_j <= c for a rigid j. To first order the point may move by `gap` against `normal` until then.
struct LayerStop {
    std::uint32_t body = 0, skeleton = 0;
    std::uint32_t other = 0, other_skeleton = 0;           // body and territory
    Vec3 position = Vec3::Zero();                          // m, on the skeleton
    Vec3 normal = Vec3::Zero();                            // outward from `other`
    double gap = std::numeric_limits<double>::infinity();  // m; below 0: it is inside
    // m/s: how fast what changes its shape comes on along `normal` by doing so.
    double closing = 0;
    double area = 0;  // m^2, of two rigid bodies that touch: what rubs there
};

struct Wrench {
    Vec3 force = Vec3::Zero();   // N
    Vec3 torque = Vec3::Zero();  // N m, about the frame's origin
};

struct Contacts {
    std::vector<LayerContact> contacts;  // by body, then by sample
    std::vector<DrawnSample> drawn;      // by body, then by sample
    // By body, then by skeleton: of each that a sample's ray meets another body on its inner half,
    // the point of least gap to that body. Then those of rigid bodies, see rigid_stops.hpp.
    std::vector<LayerStop> stops;
    std::vector<std::vector<Wrench>> wrenches;  // one a body and frame
    std::vector<double> compression;            // one a body: the largest, units of the field
    // One a body: how deep, m, its deformed surface stands inside another's at worst, at its
    // samples. By construction round-off, except where a skeleton itself has gone into another
    // body.
    std::vector<double> penetration;
};

}  // namespace physics

#pragma once

// What acts on a body during one frame. Each is a plain description made by a node; solvers read
// them. Motion inside a frame is linear from the state the frame starts with.

#include "geometry/base/vec.hpp"
#include "geometry/mesh/mesh_fwd.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace physics {

using geometry::Transform;
using geometry::Vec3;

// What springs hold of the material in a cube: all of its points, each by the trilinear weights w
// of its cube's corners, have the energy
//   1/2 sum_ab A_ab (x_a - t_a) . (x_b - t_b),   A = sum over points of stiffness * w w^T
// with t where the targets of the corners are (hold_matter.hpp).
struct HeldCube {
    std::uint32_t cube = 0;
    std::array<std::uint32_t, 8> corner{};  // into HeldMatter::corner
    std::uint32_t axes = 7;                 // bits 1, 2, 4: along x, y, z of the world
    std::array<float, 36> stiffness{};      // N/m, lower triangle of A, row by row
    bool operator==(const HeldCube&) const = default;
};

// Points of the material that springs hold.
struct HeldMatter {
    std::vector<std::uint32_t> corner;  // H, of these cubes; of several pins, one may stand twice
    std::vector<Vec3> target;           // H, m, where each would be at the end of this frame
    std::vector<HeldCube> cubes;        // of one pin, by cube
    std::vector<Vec3> pivot = {};       // H, as that of Pins
};

// Corners whose motion is prescribed, along all axes of the world or some of them, and points of
// the material that springs hold.
struct Pins {
    std::vector<std::uint32_t> corner;  // P, sorted, no duplicates
    std::vector<Vec3> target;           // P, m, where each is at the end of this frame
    std::uint64_t cubes = 0;            // mark of the cubes whose corners these are
    // P, bits 1, 2, 4: held along x, y, z; empty: along all
    std::vector<std::uint8_t> axes = {};
    HeldMatter matter = {};
    // P, m, where the place is at the end of this frame that each turns about on its way; not a
    // number: the middle of those that turn with it. Empty: of all
    std::vector<Vec3> pivot = {};

    bool empty() const { return corner.empty() && matter.cubes.empty(); }
};
inline constexpr std::uint8_t all_axes = 7;

inline Vec3 pivot_of(const std::vector<Vec3>& pivots, std::size_t pin)
{
    constexpr double open = std::numeric_limits<double>::quiet_NaN();
    return pivots.empty() ? Vec3::Constant(open) : pivots[pin];
}

inline std::uint8_t held_axes(const Pins& pins, std::size_t pin)
{
    return pins.axes.empty() ? all_axes : pins.axes[pin];
}

struct PressedSurface;  // pressed_surface.hpp
class KeptFeatures;     // collider_features.hpp

// How a wind varies about its velocity (gusts.hpp).
struct Gusts {
    double speed = 0;       // m/s, root mean square; 0: not at all
    double size = 1;        // m, of the largest
    Vec3 carried{0, 0, 0};  // since the shot began, by the wind, in sizes
    double time = 0;        // since the shot began: s, times speed / size
    std::uint32_t seed = 0;
    bool operator==(const Gusts&) const = default;
};

// What of a force may change within a frame.
struct ForceNumbers {
    Vec3 acceleration{0, 0, 0}, velocity{0, 0, 0}, force{0, 0, 0}, position{0, 0, 0};
    Vec3 torque{0, 0, 0}, swirl{0, 0, 0};
    double outward = 0, pressure = 0, air_density = 0, drag = 0, radius = 0;
    Gusts gusts = {};
    bool operator==(const ForceNumbers&) const = default;
};

// A force field, at the end of this frame. What follows, pressure and torque depend on where the
// body is.
struct Force {
    enum class Kind { gravity, wind, point, torque, radial, pressure };
    Kind kind = Kind::gravity;
    Vec3 acceleration{0, -9.81, 0};  // gravity: m/s^2
    Vec3 velocity{0, 0, 0};          // wind: of the air, m/s
    double air_density = 1.2;        // wind: kg/m^3, drag 1/2 rho |v_rel| v_rel per exposed area
    double drag = 1.0;               // wind: coefficient
    Gusts gusts = {};                // wind
    Vec3 force{0, 0, 0};             // point: N, total
    Vec3 position{0, 0, 0};          // point, torque: m, in the rest shape; radial: in the world
    double radius = 0.1;             // point, torque, radial: m, falls off smoothly to 0 here
    Vec3 torque{0, 0, 0};            // torque: N m, total
    bool follow = false;             // point, torque: turns with what it acts on
    double outward = 0;              // radial: m/s^2, away from the position
    Vec3 swirl{0, 0, 0};             // radial: m/s^2, around it along this axis
    double pressure = 0;             // pressure: Pa, against the normals of the surface
    std::shared_ptr<const PressedSurface> surface = nullptr;  // pressure
    std::uint32_t first_corner = 0;  // pressure: of the surface's cubes, among all that are moved
    std::optional<ForceNumbers> before = std::nullopt;  // where the frame starts; none: as here

    ForceNumbers numbers() const;
    // Takes `before` from what it was at the end of the frame before.
    void began_as(const Force& last);
    // As it is when a share of the frame has gone by: between its start and its end along a line.
    Force at(double share) const;
};

// Whether one of them changes within the frame.
bool any_change(std::span<const Force> forces);

// m, each as in Collider, or how fast it grows, m/s.
struct ColliderSize {
    double radius = 0;
    Vec3 half_size{0, 0, 0};
    double thickness = 0;
    bool operator==(const ColliderSize&) const = default;
};

// A rigid or animated obstacle. The pose maps its local frame to the world at the end of
// this frame, `before` at its start.
struct Collider {
    enum class Kind { plane, sphere, box, mesh };
    Kind kind = Kind::plane;                        // plane: local y = 0, solid below
    double radius = 1;                              // sphere, about the local origin
    Vec3 half_size{0.5, 0.5, 0.5};                  // box, about the local origin
    std::shared_ptr<const geometry::TriMesh> mesh;  // mesh: world positions at the end of the frame
    std::shared_ptr<const geometry::TriMesh> mesh_before;  // null: as `mesh`
    std::shared_ptr<const geometry::TriangleBvh> tree;     // of `mesh`; null: made when needed
    std::shared_ptr<const KeptFeatures> features;          // of `mesh`; null: none are kept
    bool sheet = false;  // the mesh is open, and has two sides but while a shot begins
    Transform pose = Transform::Identity();
    Transform before = Transform::Identity();
    double friction = 0.5;  // Coulomb coefficient
    double bounce = 0;      // share of the speed that bricks and springs come off with
    double thickness = 0;   // m, offset of the contact surface
    std::optional<ColliderSize> size_before =
        std::nullopt;  // where the frame starts; none: as here

    ColliderSize size() const { return {radius, half_size, thickness}; }
    // Takes pose and size at the start of the frame from the end of the frame before.
    void began_as(const Collider& last);
};

// A solid rigid ball that bodies, colliders and other balls push about. Where it starts; where it
// is, the state knows.
struct Ball {
    double radius = 0.1;  // m
    double mass = 1;      // kg
    Vec3 position{0, 1, 0};
    Vec3 velocity{0, 0, 0};
    double friction = 0.5;  // Coulomb coefficient with bodies and balls
};

// A point that two parts carry, 8 corners of a cube of each (part_joint.hpp).
struct JointPoint {
    std::array<std::uint32_t, 16> corner{};  // of its model, or of all that are simulated
    std::array<double, 16> weight{};         // of the first part, sum 1; of the second, sum -1
    std::array<double, 2> stiffness{};       // N/m, E h of the cube of each
    bool operator==(const JointPoint&) const = default;
};

// What keeps two parts together.
struct PartJoint {
    std::array<std::uint64_t, 2> cubes{};  // marks of the cubes of each part
    std::vector<JointPoint> points;
    Vec3 position = Vec3::Zero();  // m, in the rest shape
};

// All of it together, for one frame.
struct Loads {
    Pins pins;
    std::vector<Force> forces;
    std::vector<Collider> colliders;
    std::vector<Ball> balls;
    std::vector<JointPoint> joints;
};

}  // namespace physics

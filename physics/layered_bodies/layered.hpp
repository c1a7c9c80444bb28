#pragma once

// Layered models: base structures coated by implicit layers. What they are made of and where they
// are; layered_body.hpp makes them, layered_step.hpp moves them.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997.
//
//   LayeredScene --+-- parts: LayeredPart --> LayeredBody { layer, samples, base, matter, control }
//                  |          told this frame  immutable, shared by all moments
//                  '-- states: LayeredState    what a step changes

#include "physics/layered_bodies/base.hpp"
#include "physics/layers/contact_types.hpp"
#include "physics/layers/volume_control.hpp"
#include "physics/state/loads.hpp"
#include "physics/state/state.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace physics {

// An object: immutable, shared by all its states.
struct LayeredBody {
    ImplicitLayer layer;
    SurfaceSamples samples;
    Base base;
    LayerMatter matter;
    VolumeControl control;
    std::vector<double> volume;  // S, m^3, of each territory at the start
    double sample_spacing = 0;   // m, of the samples; 0: it emits none

    std::size_t bytes() const;
};

// Whether a body has a surface to draw; the ground draws itself.
inline bool has_surface(const LayeredBody& body)
{
    return body.samples.count() > 0 || body.sample_spacing > 0;
}

// What two skeletons that touch have done to each other (layered_bounce.hpp).
struct LayerBounce {
    std::uint32_t skeleton = 0, other = 0, other_skeleton = 0;  // `other`: body
    bool struck = false;                                        // hit, and bounces
    bool turned = false;                                        // is on its way out
    bool spent = false;                                         // has given all
    double arrived = 0;                                         // J, of the approach when it hit
    double stored = 0;  // J, taken by elasticity less given; on the way out: less what is lost
    double phase = 0;   // rad, by which it has swung since
    bool operator==(const LayerBounce&) const = default;
};

// Its moment.
struct LayeredState {
    double time = 0;                        // s
    std::vector<Vec3> position;             // B, m, of frames
    std::vector<Eigen::Vector4d> rotation;  // B, unit quaternion x y z w
    std::vector<Vec3> velocity;             // B, m/s
    std::vector<Vec3> spin;                 // B, rad/s
    State cubes;                            // where a base of cubes is; else empty
    std::vector<double> translation;        // S, m, tau
    // S, m^3, as contacts and bulges leave the territories, at the last walk (of a body
    // that controls it: as the state is); empty before the first.
    std::vector<double> volume;
    std::vector<double> inflation;       // S, of the volume, that was sought then
    std::vector<double> expected_error;  // S, m^3, for the controller; empty before the first
    double penetration = 0;              // of what touches, see Contacts; the step's largest
    std::vector<double> distance;        // N, of samples; empty before the first
    // N, m, as contacts left the samples at the last walk; below 0: not on the surface. For
    // preview.
    std::vector<float> pressed;
    std::vector<std::uint32_t> part;  // S, blend parts
    std::vector<geometry::BlendLink> links;
    std::vector<LayerBounce> bounces;  // of its skeletons with those of bodies after it
    double lag = 0;  // s, by half of which velocities are behind places, see layered_fall.hpp
    double steps_per_second = 0;  // that Bullet needs for it as it is, see explicit_steps()
    Report report;

    std::size_t bytes() const;
};

// A frame of a rigid body or a particle that is held, or moved as it is told.
struct HeldFrame {
    std::uint32_t frame = 0;
    Vec3 way = Vec3::Zero();  // m, from where the part's pose has it
};

// An object in a scene, as it is told to be at a moment.
struct LayeredPart {
    std::shared_ptr<const LayeredBody> body;
    Transform pose = Transform::Identity();  // of a body as drawn: at the start; still, led: always
    Pins pins = {};                          // of its cubes
    // Still, led: where each frame is; else where it starts; empty: by the pose.
    std::vector<Transform> frames = {};
    std::vector<HeldFrame> held = {};   // of rigid bodies and particles
    Vec3 velocity = Vec3::Zero();       // m/s, at the start
    Vec3 spin = Vec3::Zero();           // rad/s, at the start, about the centre of mass
    std::vector<Vec3> velocities = {};  // B, m/s, at the start; empty: by the two above
    // Of the volume that it seeks at the end of the step; it goes there straight.
    double inflation = 1;
    std::vector<double> muscle = {};           // S, the same of each territory besides; empty: 1
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};  // linear RGB
    // A still body of one mesh that changes its shape: where it was a frame ago, with the same
    // triangles; its vertices go straight. Null: it does not.
    std::shared_ptr<const geometry::TriMesh> mesh_before = nullptr;
    // The same of a still body's skeletons, while a frame of the film is stepped.
    std::shared_ptr<const ShapeChange> change = nullptr;

    double sought(std::size_t skeleton) const
    {
        return inflation * (muscle.empty() ? 1 : muscle[skeleton]);
    }
    std::size_t bytes() const
    {
        return (body ? body->bytes() : 0) + frames.size() * sizeof(Transform) +
               muscle.size() * sizeof(double) + held.size() * sizeof(HeldFrame) +
               velocities.size() * sizeof(Vec3);
    }
};

// How far two bodies press each other where they do most, units of the field; a body with itself:
// its parts.
struct BodyPress {
    std::uint32_t body = 0, other = 0;
    double compression = 0;
    bool operator==(const BodyPress&) const = default;
};

// All objects of a scene at a moment.
struct LayeredScene {
    std::vector<LayeredPart> parts;
    std::vector<LayeredState> states;  // one a part
    // Of a scene that was recorded (scene_record.hpp), to be drawn without samples: every two that
    // touch. Its bodies have no samples and nothing moves.
    std::optional<std::vector<BodyPress>> presses = {};

    std::size_t bytes() const;  // of the states: bodies are shared, but recorded ones are counted
};

// Who moves rigid frames: the one implicit step that moves all others too, stable however stiff a
// layer is, or Bullet (layered_bullet.hpp), which keeps bounces but takes layers' forces from
// outside: the stiffer a layer, the more steps.
enum class RigidBodies : std::uint8_t { implicit, bullet };

struct LayeredWorld {
    Vec3 gravity{0, -9.81, 0};  // m/s^2
    double drag = 0;            // 1/s, of the speed of every frame
    RigidBodies rigid_bodies = RigidBodies::implicit;
    std::vector<Force> forces = {};  // see layered_loads.hpp
};

// Where a part's frames are told to be: as it says, or as drawn at its pose.
std::vector<Transform> told_frames(const LayeredPart& part);

// m/s, of the frames of a part that is not on cubes: at the start, where its frames are at `at`.
std::vector<Vec3> first_velocities(const LayeredPart& part, const std::vector<Transform>& at);

// The skeletons that each frame carries.
std::vector<std::vector<std::uint32_t>> skeletons_on_frames(const LayeredBody& body);

// The largest relative error of volume over the bodies that control theirs; 0 before the first
// step.
double volume_error(const LayeredScene& scene);
double volume_error(const LayeredBody& body, const LayeredState& state);

// How deep a body's surface stands inside another one's where they touch, as a share of its
// thinnest layer: the largest over bodies and over the steps of the last frame.
double interpenetration(const LayeredScene& scene);

// Speed of the fastest frame's origin, m/s.
double fastest(const LayeredScene& scene);

}  // namespace physics

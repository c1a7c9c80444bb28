#pragma once

// Layered models: base structures coated by implicit layers, stepped together.
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997. What is ours is said where it stands.
//
// A step of dt seconds:
//   1. fields from frames and translations, seeds walk (field.hpp, seeds.hpp)
//   2. contacts and their forces (layer_contact.hpp)
//   3. controllers move the contributions by tau so that territories, as contacts leave them, keep
//      their volume (volume_control.hpp)
//   4. the base: all forces with their stiffness and damping in one backward Euler step,
//        (M + dt C + dt^2 K) dv = dt (f - dt K v)
//      K, C from contacts, joints, springs, particles and squashing cubes, each a symmetric pair
//      term, so that what one body gets the other loses: momentum is kept to the solver's 1e-10.
//      (The paper integrates explicitly; this stays stable for stiff layers and long steps.)
//      Or, chosen by the scene, Bullet moves rigid bodies explicitly: layered_bullet.hpp.
//   5. soft substances: who may blend with whom (separation, fusion)
// What comes on so fast that it could cross a layer between two steps gets more of them.
// After the last step of a frame bodies that control their volume are walked once more, and what
// the last motion changed of it is mended, by Newton steps in which nothing moves.

#include "physics/cube_base.hpp"
#include "physics/layer_contact.hpp"
#include "physics/loads.hpp"
#include "physics/state.hpp"
#include "physics/volume_control.hpp"

#include <memory>
#include <span>
#include <vector>

namespace physics {

// How a soft substance's particles act on each other, r0 their distance at rest:
//   attraction and repulsion  k_p ((r0/r)^8 - (r0/r)^4) along r, up to `reach` r0
//   friction                  -gamma (1 - (r/(reach r0))^2)^2 (v_p - v_q)
struct Substance {
    double stiffness = 10;           // k_p, N
    double rest_distance = 0.1;      // r0, m
    double friction = 5;             // gamma, N s/m
    double reach = 2;                // of r0
    double fusion_threshold = 1e30;  // Pa: parts that press harder than this fuse
    double fusion_time = 0.25;       // s for a pair of skeletons to blend fully
};

// A spring between two frames' origins.
struct LayerSpring {
    std::uint32_t a = 0, b = 0;
    double rest = 0.1;       // m
    double stiffness = 100;  // N/m
    double damping = 1;      // N s/m
};

// A hinge between two rigid frames: the point and axis are given in both local frames.
struct Hinge {
    std::uint32_t a = 0, b = 0;
    Vec3 point_a = Vec3::Zero(), point_b = Vec3::Zero();  // m
    Vec3 axis_a = Vec3::UnitZ(), axis_b = Vec3::UnitZ();
    Vec3 zero_a = Vec3::UnitX(), zero_b = Vec3::UnitX();  // square to the axis; aligned at angle 0
    double lowest = -1e9, highest = 1e9;                  // rad, limits of the angle from a to b
    double stiffness = 0;                                 // N m/rad towards `rest`
    double rest = 0;                                      // rad
    double damping = 0;                                   // N m s/rad
};

// What carries a layer: `still` frames move only as they are told, `rigid` ones turn and move,
// `particles` only move. `led` ones move as they are told as far as their skeletons stay out of
// other bodies: what leads them knows nothing of those. `cubes` carry frames that have no mass of
// their own, and feel all that those do.
enum class BaseKind : std::uint8_t { still, rigid, particles, led, cubes };

struct Base {
    BaseKind kind = BaseKind::rigid;
    std::vector<Transform> frames;  // B, at the start; a rigid frame's origin is its centre of mass
    std::vector<double> mass;       // B, kg
    std::vector<Mat3> inertia;      // B, kg m^2, about the origin, in local axes; rigid only
    std::vector<LayerSpring> springs;
    std::vector<Hinge> hinges;
    Substance substance;                    // particles only
    std::shared_ptr<const CubeBase> cubes;  // cubes only, else null
};

// An object: immutable, shared by all its states.
struct LayeredBody {
    ImplicitLayer layer;
    Seeds seeds;
    Base base;
    LayerMatter matter;
    VolumeControl control;
    std::vector<double> volume;  // S, m^3, of each territory at the start

    std::size_t bytes() const;
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
    // S, m^3, as contacts leave the territories, bulges not counted, at the last walk (of a body
    // that controls it: as the state is); empty before the first.
    std::vector<double> volume;
    std::vector<double> inflation;       // S, of the volume, that was sought then
    std::vector<double> expected_error;  // S, m^3, for the controller; empty before the first
    double penetration = 0;              // of what touches, see Contacts; the step's largest
    std::vector<double> distance;        // N, of seeds; empty before the first
    // N, m, as contacts left the seeds at the last walk; below 0: not on the surface. For preview.
    std::vector<float> pressed;
    std::vector<std::uint32_t> part;  // S, blend parts
    std::vector<geometry::BlendLink> links;
    double pace = 0;  // steps a second that Bullet wants for it as it is, see explicit_pace()
    Report report;

    std::size_t bytes() const;
};

// An object in a scene, as it is told to be at a moment.
struct LayeredPart {
    std::shared_ptr<const LayeredBody> body;
    Transform pose = Transform::Identity();  // of a body as drawn: at the start; still, led: always
    Pins pins = {};                          // of its cubes
    std::vector<Transform> frames = {};      // still, led: where each frame is; empty: by the pose
    Vec3 velocity = Vec3::Zero();            // m/s, at the start
    // Of the volume that it seeks at the end of the step; it goes there straight.
    double inflation = 1;
    std::vector<double> muscle = {};           // S, the same of each territory besides; empty: 1
    geometry::Vec3f colour{0.7f, 0.7f, 0.7f};  // linear RGB
    // A still body of one mesh that changes its shape: where it was a frame ago, with the same
    // triangles; its vertices go straight. Null: it does not.
    std::shared_ptr<const geometry::TriMesh> mesh_before = nullptr;

    double sought(std::size_t skeleton) const
    {
        return inflation * (muscle.empty() ? 1 : muscle[skeleton]);
    }
    std::size_t bytes() const
    {
        return (body ? body->bytes() : 0) + frames.size() * sizeof(Transform) +
               muscle.size() * sizeof(double);
    }
};

// All objects of a scene at a moment.
struct LayeredScene {
    std::vector<LayeredPart> parts;
    std::vector<LayeredState> states;  // one a part

    std::size_t bytes() const;  // of the states: bodies are shared
};

// A body from a layer drawn in the world: one frame for each number that layer.frame names. Rigid
// frames get mass, centre and inertia from what their territories hold at `density` kg/m^3,
// particles their mass; each skeleton is moved into its frame. `frames` gives orientation, and
// where particles and still frames are. Throws std::invalid_argument as make_field() and
// make_seeds() do, and for a frame that holds no volume.
LayeredBody make_layered_body(ImplicitLayer layer, BaseKind kind, double density,
                              double seed_spacing);

// A rigid thing as a still part: the collider's shape, at its pose at the end of the frame, with
// its friction; a mesh as it changes.
LayeredPart rigid_part(const Collider& collider);

// Lets cubes carry the frames of a body as drawn, which was made `still`, and feel what they do.
// Throws std::invalid_argument where it was not, or the cubes are no solid body.
void set_on_cubes(LayeredBody& body, geometry::Cubes cubes, const BrickOptions& options = {});

// Adds a hinge through `point` along `axis`, both as drawn; the angle as drawn is 0. Throws
// std::invalid_argument for frames that are not there or not rigid, or an axis without direction.
Hinge& add_hinge(Base& base, std::uint32_t a, std::uint32_t b, const Vec3& point, const Vec3& axis);

// Whether frames of that kind are where somebody says.
bool is_told(BaseKind kind);

// Where a part's frames are told to be: as it says, or as drawn at its pose.
std::vector<Transform> told_frames(const LayeredPart& part);

// The skeletons that each frame carries.
std::vector<std::vector<std::uint32_t>> skeletons_on_frames(const LayeredBody& body);

// The angle at which frames a and b stand to each other, rad in -pi..pi.
double hinge_angle(const Hinge& hinge, const Transform& a, const Transform& b);

// Joins frames of a body by springs at rest: each two whose origins are nearer than `reach` m. The
// substance's own forces are taken away. Throws std::invalid_argument where that joins none.
void add_spring_network(Base& base, double reach, double stiffness, double damping);

// Everything where its part's pose puts it, at its velocity.
LayeredScene start(std::vector<LayeredPart> parts);

// Who moves rigid frames: the one implicit step that moves all others too, stable however stiff a
// layer is, or Bullet (layered_bullet.hpp), which keeps bounces but takes layers' forces from
// outside: the stiffer a layer, the more steps.
enum class RigidBodies : std::uint8_t { implicit, bullet };

struct LayeredWorld {
    Vec3 gravity{0, -9.81, 0};  // m/s^2
    double drag = 0;            // 1/s, of the speed of every frame
    RigidBodies rigid_bodies = RigidBodies::implicit;
};

// Throws std::invalid_argument where Bullet is to move what it cannot: particles, cubes, led
// bodies.
void check_rigid_bodies(std::span<const LayeredPart> parts, RigidBodies rigid_bodies);

// The scene dt seconds later, in at least `substeps` equal steps: in more where bodies near each
// other would come on by more than two fifths of a layer in one, or where they swing too fast for
// Bullet; the report warns where 64 times as many are not enough. `parts` are told for its end:
// still and led ones move there, straight and at constant spin. Throws std::invalid_argument where
// they are not the bodies of the scene (as many, with the same frames and skeletons), and as
// check_rigid_bodies() does; never for what happens.
LayeredScene advance(const LayeredScene& scene, std::vector<LayeredPart> parts,
                     const LayeredWorld& world, double dt, int substeps);

// The largest relative error of volume over the bodies that control theirs; 0 before the first
// step.
double volume_error(const LayeredScene& scene);

// How deep a body's surface stands inside another one's where they touch, as a share of its
// thinnest layer: the largest over bodies and over the steps of the last frame.
double interpenetration(const LayeredScene& scene);

// Particles of soft substances whose state is a number, and the pieces that they make.
std::size_t particle_count(const LayeredScene& scene);
std::size_t piece_count(const LayeredScene& scene);

// Speed of the fastest frame's origin, m/s.
double fastest(const LayeredScene& scene);

// A scene laid out for contact and for drawing, at its moment. Keeps what it points to; not copied.
struct LayeredMoment {
    // `mesh_seconds`: how long meshes that change their shape took from where they were.
    explicit LayeredMoment(const LayeredScene& scene, double mesh_seconds = 0);
    LayeredMoment(const LayeredMoment&) = delete;
    LayeredMoment& operator=(const LayeredMoment&) = delete;

    std::vector<std::vector<Transform>> frames;
    std::vector<std::vector<Twist>> twists;
    std::vector<Field> fields;
    std::vector<SeedWalk> walks;
    std::vector<MovingMesh> meshes;
    std::vector<ContactBody> bodies;
    Contacts contacts;
};

}  // namespace physics

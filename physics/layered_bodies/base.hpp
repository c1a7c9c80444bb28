#pragma once

// Base structures: what carries the layers of a body. Masses that turn and move, on hinges and
// springs; particles of a soft substance; frames that are told where to be; cubes.
//
//        o======o  <- skeletons, coated by the layer
//        |      |
//      [ B ]--[ B ]   frames: each carries the skeletons that name it; here two, on a hinge
//
// Cani-Gascuel, Desbrun. Animation of deformable models using implicit surfaces. IEEE TVCG 3(1),
// 1997, V.

#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/layered_bodies/cube_base.hpp"
#include "physics/layered_bodies/joint.hpp"

#include <memory>
#include <string>
#include <vector>

namespace physics {

// How a soft substance's particles act on each other, r0 their distance at rest:
//   attraction and repulsion  k_p ((r0/r)^8 - (r0/r)^4) W(r) along r, r at least 0.3 r0 in it
//   friction                  -gamma W(r) (v_p - v_q)
//   W(r) = (1 - (r/(reach r0))^2)^2 up to `reach` r0, 0 beyond: nothing jumps there
struct Substance {
    double stiffness = 10;           // k_p, N
    double rest_distance = 0.1;      // r0, m
    double friction = 5;             // gamma, N s/m
    double reach = 2;                // of r0
    double fusion_threshold = 1e30;  // Pa: parts that press harder than this fuse
    double fusion_time = 0.25;       // s for a pair of skeletons to blend fully
    // Whether pieces that come apart collide from then on: see let_separate().
    bool separates = true;
    std::string name = {};  // bodies of one name are one body, see join_substances.hpp
    bool operator==(const Substance&) const = default;
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

// A segment or triangle of a net (net_base.hpp): the two or three masses that carry its frame.
struct NetSpan {
    std::vector<std::uint32_t> masses;
};

// What carries a layer: `still` frames move only as they are told, `rigid` ones turn and move,
// `particles` only move. `led` ones move as they are told as far as their skeletons stay out of
// other bodies: what leads them knows nothing of those. `carried` ones have no mass of their own:
// cubes carry them, and feel all that they do. The first frames of a `net` are masses that only
// move, and carry the others.
enum class BaseKind : std::uint8_t { still, rigid, particles, led, carried, net };

struct Base {
    BaseKind kind = BaseKind::rigid;
    std::vector<Transform> frames;  // B, at the start; a rigid frame's origin is its centre of mass
    std::vector<double> mass;       // B, kg
    std::vector<Mat3> inertia;      // B, kg m^2, about the origin, in local axes; rigid only
    std::vector<LayerSpring> springs;
    std::vector<Hinge> hinges;
    std::vector<Joint> joints;
    std::vector<NetSpan> spans;             // of a net, for its last frames
    Substance substance;                    // particles only
    std::shared_ptr<const CubeBase> cubes;  // carried only, else null
};

// How many frames move by themselves: all but those of `spans`.
inline std::size_t mass_count(const Base& base)
{
    return base.frames.size() - base.spans.size();
}

// Adds a hinge through `point` along `axis`, both as drawn; the angle as drawn is 0. Throws
// std::invalid_argument for frames that are not there or not rigid, or an axis without direction.
Hinge& add_hinge(Base& base, std::uint32_t a, std::uint32_t b, const Vec3& point, const Vec3& axis);

// Adds a joint of frame b with frame a, or with the world where that is Joint::world, at `point` as
// drawn. `axis`: a slider's way, the middle of a ball's cone, or the axis of two that a carries;
// `second_axis`: the one that b carries, else not used. Throws std::invalid_argument as add_hinge()
// does, and for two axes that are not square to each other.
Joint& add_joint(Base& base, JointKind kind, std::uint32_t a, std::uint32_t b, const Vec3& point,
                 const Vec3& axis, const Vec3& second_axis = Vec3::Zero());

// The angle at which frames a and b stand to each other, rad, unwound.
double hinge_angle(const Hinge& hinge, const Transform& a, const Transform& b);

// Whether a hinge stops anywhere: limits that are a whole turn apart stop it nowhere.
bool has_limits(const Hinge& hinge);

// An angle counted from where it is half a turn, at most, from the middle between the hinge's
// limits, or from its rest where it has none: it does not jump wherever the hinge may be.
double unwound(const Hinge& hinge, double angle);

// Joins frames of a body by springs at rest: each two whose origins are nearer than `reach` m. The
// substance's own forces are taken away. Throws std::invalid_argument where that joins none.
void add_spring_network(Base& base, double reach, double stiffness, double damping);

// The same along the edges of a mesh, as drawn: each joins the frames nearest to its two ends,
// where those are different and within `reach` m of the ends.
void add_spring_edges(Base& base, const geometry::TriMesh& mesh, double reach, double stiffness,
                      double damping);

// Whether frames of that kind are where somebody says.
bool is_told(BaseKind kind);

}  // namespace physics

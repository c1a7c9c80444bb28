#pragma once

// A mesh that vibrates in a few modes: James, Barbic, Twigg. Squashing cubes. SIGGRAPH 2004
// sketches. The modes were found on cubes and interpolated to the vertices; the cubes are gone. In
// modal coordinates q the body is k oscillators that know nothing of each other,
//   q'' + c q' + omega^2 q = f,     x = X + base + amplitude sum_k q_k phi_k
// stepped exactly under loads that are constant for the length of a step. All is linear: large
// rotations grow. The base, where the pins hold, moves in straight lines from frame to frame; in
// its frame the body feels a jerk of -participation . (change of its velocity) where they meet.

#include "geometry/mesh/mesh_fwd.hpp"
#include "physics/modal/modes.hpp"
#include "physics/state/loads.hpp"

namespace physics {

using geometry::Vec3f;

// What to step: k modes of a mesh with V vertices and N normals.
struct ModalModel {
    std::shared_ptr<const geometry::TriMesh> rest;
    std::vector<double> omega_sq;                   // k, rad^2/s^2, ascending
    std::vector<double> damping;                    // k, 1/s, from the material
    std::vector<Vec3> participation;                // k, sqrt(kg), sum of mass * mode
    std::vector<std::vector<Vec3f>> shape;          // k x V, kg^-1/2
    std::vector<std::vector<Vec3f>> normal_change;  // k x N, by q, where displacements are small
    std::vector<std::string> warnings;
    std::uint64_t mark = 0;  // of omega_sq and shape, see mark_of()

    std::size_t count() const { return omega_sq.size(); }
};

// Tells modes from others: coordinates in these mean nothing in those.
std::uint64_t mark_of(const ModalModel& model);

// Interpolates modes of cubes to a mesh that they carry.
ModalModel make_modal_model(const Modes& modes, const geometry::Cubes& cubes,
                            std::shared_ptr<const geometry::TriMesh> mesh);

struct ModalState {
    double time = 0;                    // s since the first frame
    std::vector<double> q, q_dot;       // k, sqrt(kg) m and sqrt(kg) m/s
    Vec3 base = Vec3::Zero();           // m
    Vec3 base_velocity = Vec3::Zero();  // m/s, over the last step
    std::uint64_t mark = 0;             // of the model
};

// A blow that lasts no time, spread smoothly over the vertices around a place.
struct Kick {
    Vec3 position{0, 0, 0};  // m, in the rest shape
    Vec3 impulse{0, -1, 0};  // N s
    double radius = 0.1;  // m, falls off smoothly to 0 here; the nearest vertex if none is inside
};

// How fast modes die out.
struct ModalDamping {
    enum class Kind { material, ratio, rayleigh };
    Kind kind = Kind::material;
    double ratio = 0.02;           // ratio: of critical damping, every mode
    double mass_damping = 0;       // rayleigh: alpha, 1/s
    double stiffness_damping = 0;  // rayleigh: beta, s
};

// At rest at time 0.
ModalState rest_state(const ModalModel& model);

// What acts on the modes for a step.
struct ModalLoads {
    std::span<const Force> forces;
    Vec3 base{0, 0, 0};  // m, at its end
    std::span<const Collider> colliders = {};
};

// The state `dt` seconds later: forces as they are for the whole step, the base at `base` at its
// end. Colliders stop vertices (modal_contact.hpp). Wind is of first order in time, on the faces as
// they are at rest (modal_wind.hpp). Throws std::invalid_argument for a state of other modes, and
// where wind moves a mesh of next to no mass.
ModalState advance(const ModalModel& model, ModalState state, const ModalLoads& loads,
                   const ModalDamping& damping, double dt);
inline ModalState advance(const ModalModel& model, ModalState state, std::span<const Force> forces,
                          const Vec3& base, const ModalDamping& damping, double dt)
{
    return advance(model, std::move(state), ModalLoads{forces, base}, damping, dt);
}

// The state just after a blow.
ModalState struck(const ModalModel& model, ModalState state, const Kick& kick);

// The mesh as it stands, modes exaggerated by `amplitude`, with a "displacement" (m) and a "speed"
// (m/s) a vertex.
geometry::TriMesh deformed(const ModalModel& model, const ModalState& state, double amplitude = 1);

// Of the motion relative to the base, J.
double energy(const ModalModel& model, const ModalState& state);

}  // namespace physics

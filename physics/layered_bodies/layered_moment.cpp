#include "physics/layered_bodies/layered_moment.hpp"

namespace physics {

LayeredMoment::LayeredMoment(const LayeredScene& scene, double mesh_seconds, Drawn drawn)
{
    const std::size_t n = scene.parts.size();
    fields.reserve(n);
    walks.reserve(n);
    for (std::size_t b = 0; b < n; ++b) {
        const LayeredBody& body = *scene.parts[b].body;
        const LayeredState& state = scene.states[b];
        std::vector<Transform> at;
        std::vector<Twist> moving;
        for (std::size_t f = 0; f < state.position.size(); ++f) {
            Transform t = Transform::Identity();
            t.translate(state.position[f]).rotate(Eigen::Quaterniond(state.rotation[f]));
            at.push_back(t);
            moving.push_back({state.velocity[f], state.spin[f]});
        }
        ImplicitLayer layer = body.layer;
        layer.blend.part = state.part;
        layer.blend.links = state.links;
        fields.push_back(geometry::make_field(layer, at, state.translation));
        SampleWalk before;
        before.distance = state.distance;
        walks.push_back(physics::walk(fields.back(), body.samples, at,
                                      state.distance.empty() ? nullptr : &before,
                                      body.control.proportional > 0));
        frames.push_back(std::move(at));
        twists.push_back(std::move(moving));
    }
    for (const LayeredPart& part : scene.parts) {
        meshes.push_back({part.mesh_before ? part.body->layer.skeletons[0].mesh : nullptr,
                          part.mesh_before, mesh_seconds});
    }
    for (std::size_t b = 0; b < n; ++b) {
        bodies.push_back({&fields[b], &scene.parts[b].body->samples, &walks[b], frames[b],
                          twists[b], scene.parts[b].body->layer.frame, scene.parts[b].body->matter,
                          meshes[b].before ? &meshes[b] : nullptr,
                          drawn == Drawn::all || scene.parts[b].body->control.proportional > 0});
    }
    contacts = find_contacts(bodies);
}

}  // namespace physics

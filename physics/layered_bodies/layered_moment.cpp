#include "physics/layered_bodies/layered_moment.hpp"

#include "physics/layered_bodies/net_base.hpp"

#include <algorithm>

namespace physics {

namespace {

// As find_contacts() would say it to bulges_of(), which asks for no more than this.
Contacts recorded_contacts(std::span<const BodyPress> presses, std::span<const ContactBody> bodies)
{
    Contacts out;
    for (const ContactBody& body : bodies) out.wrenches.emplace_back(body.frames.size());
    out.compression.assign(bodies.size(), 0);
    out.penetration.assign(bodies.size(), 0);
    for (const BodyPress& press : presses) {
        LayerContact contact{};
        contact.position = contact.normal = contact.force = Vec3::Zero();
        contact.body = press.body;
        contact.other = press.other;
        contact.compression = press.compression;
        for (const std::uint32_t b : {press.body, press.other}) {
            out.compression[b] = std::max(out.compression[b], press.compression);
        }
        out.contacts.push_back(contact);
    }
    return out;
}

}  // namespace

LayeredMoment::LayeredMoment(const LayeredScene& scene, double mesh_seconds, Drawn drawn)
{
    const std::size_t n = scene.parts.size();
    fields.reserve(n);
    walks.reserve(n);
    stretched.reserve(n);
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
        const bool stretches = !body.base.spans.empty();
        stretched.push_back(stretches ? body.samples : SurfaceSamples{});
        if (stretches) stretch_net(body, state, layer, stretched.back());
        fields.push_back(geometry::make_field(layer, at, state.translation));
        SampleWalk before;
        before.distance = state.distance;
        walks.push_back(scene.presses
                            ? SampleWalk{}
                            : physics::walk(fields.back(),
                                            stretches ? stretched.back() : body.samples, at,
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
        const LayeredBody& body = *scene.parts[b].body;
        const SurfaceSamples* const samples = scene.presses             ? nullptr
                                              : body.base.spans.empty() ? &body.samples
                                                                        : &stretched[b];
        bodies.push_back({&fields[b], samples, &walks[b], frames[b], twists[b],
                          scene.parts[b].body->layer.frame, scene.parts[b].body->matter,
                          meshes[b].before ? &meshes[b] : nullptr,
                          drawn == Drawn::all || scene.parts[b].body->control.proportional > 0,
                          scene.parts[b].change.get(), scene.parts[b].body->layer.skeletons});
    }
    contacts = scene.presses ? recorded_contacts(*scene.presses, bodies) : find_contacts(bodies);
}

std::pair<double, double> slopes_at(const LayeredMoment& moment, const LayerContact& contact)
{
    return {
        geometry::surface_slope(moment.fields[contact.body], contact.skeleton, contact.position),
        geometry::surface_slope(moment.fields[contact.other], contact.other_skeleton,
                                contact.position)};
}

}  // namespace physics

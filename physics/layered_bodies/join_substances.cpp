#include "physics/layered_bodies/join_substances.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace physics {
namespace {

// One of the parts to join, and which of all it is.
struct Member {
    std::size_t number = 0;
    LayeredPart part;
};

// What keeps two bodies from being of one substance; null where nothing does.
const char* difference(const LayeredBody& a, const LayeredBody& b)
{
    if (a.layer.isovalue != b.layer.isovalue) return "isovalue";
    if (a.layer.blend.rule != b.layer.blend.rule) return "Skeletons.blend";
    if (!(a.matter == b.matter)) return "matter";
    if (!(a.control == b.control)) return "volume";
    if (!(a.base.substance == b.base.substance)) {
        return "substance (Springs sets its stiffness and friction to 0)";
    }
    return nullptr;
}

void check_one_substance(const Member& first, const Member& other)
{
    const std::string& name = first.part.body->base.substance.name;
    const char* const differs = difference(*first.part.body, *other.part.body);
    if (differs) {
        throw std::invalid_argument(fmt::format(
            "parts {} and {} of Layered, counted from 0, are of the substance '{}', but differ in "
            "{}: bodies of one substance need the same. Make them equal, or give one another "
            "substance.name",
            first.number, other.number, name, differs));
    }
    const LayeredBody& body = *other.part.body;
    if (body.layer.blend.rule == geometry::BlendRule::sum || !body.matter.self_contact) {
        throw std::invalid_argument(fmt::format(
            "parts {} and {} of Layered, counted from 0, are of the substance '{}', but their "
            "pieces blend wherever they meet. Set substance.separates to true",
            first.number, other.number, name));
    }
}

template <class T> void append(std::vector<T>& to, const std::vector<T>& from)
{
    to.insert(to.end(), from.begin(), from.end());
}

// The same, of numbers that count from `first` on.
void append_numbers(std::vector<std::uint32_t>& to, const std::vector<std::uint32_t>& from,
                    std::size_t first)
{
    for (const std::uint32_t i : from) {
        to.push_back(i == no_sample ? i : i + static_cast<std::uint32_t>(first));
    }
}

void append_samples(SurfaceSamples& to, const SurfaceSamples& from, std::size_t frames)
{
    const auto n = static_cast<std::uint32_t>(to.count());
    to.first.pop_back();
    append_numbers(to.first, from.first, n);
    append(to.origin, from.origin);
    append(to.direction, from.direction);
    append(to.a0, from.a0);
    append(to.a1, from.a1);
    append(to.a2, from.a2);
    for (geometry::Triangle t : from.faces) {
        for (std::uint32_t& i : t) i += n;
        to.faces.push_back(t);
    }
    for (geometry::Triangle t : from.across) {
        for (std::uint32_t& i : t) i = i == no_sample ? i : i + n;
        to.across.push_back(t);
    }
    append(to.valence, from.valence);
    append(to.core, from.core);
    append_numbers(to.frame, from.frame, frames);
}

// Parts of the blend by the first skeleton of each, with those before counted.
void append_blend(geometry::Blend& to, const geometry::Blend& from, std::uint32_t before,
                  std::uint32_t skeletons)
{
    std::map<std::uint32_t, std::uint32_t> first;
    for (std::uint32_t s = 0; s < skeletons; ++s) {
        const std::uint32_t part = from.part.empty() ? s : from.part[s];
        to.part.push_back(first.emplace(part, before + s).first->second);
    }
    for (geometry::BlendLink link : from.links) {
        link.a += before, link.b += before;
        to.links.push_back(link);
    }
}

void append_base(Base& to, const Base& from)
{
    const auto n = static_cast<std::uint32_t>(to.frames.size());
    append(to.frames, from.frames);
    append(to.mass, from.mass);
    append(to.inertia, from.inertia);
    for (LayerSpring spring : from.springs) {
        spring.a += n, spring.b += n;
        to.springs.push_back(spring);
    }
}

LayeredBody without_content(const LayeredBody& like)
{
    LayeredBody body;
    body.layer.isovalue = like.layer.isovalue;
    body.layer.blend.rule = like.layer.blend.rule;
    body.samples.first = {0};
    body.base.kind = like.base.kind;
    body.base.substance = like.base.substance;
    body.matter = like.matter;
    body.control = like.control;
    return body;
}

void append_body(LayeredBody& to, const LayeredBody& from)
{
    const auto before = static_cast<std::uint32_t>(to.layer.skeletons.size());
    const std::size_t frames = to.base.frames.size();
    append_blend(to.layer.blend, from.layer.blend, before,
                 static_cast<std::uint32_t>(from.layer.skeletons.size()));
    append(to.layer.skeletons, from.layer.skeletons);
    append(to.layer.contributions, from.layer.contributions);
    append_numbers(to.layer.frame, from.layer.frame, frames);
    append_samples(to.samples, from.samples, frames);
    append_base(to.base, from.base);
    append(to.volume, from.volume);
    to.sample_spacing = std::max(to.sample_spacing, from.sample_spacing);
}

void append_part(LayeredPart& to, const LayeredPart& from)
{
    const std::vector<Transform> at = told_frames(from);
    for (HeldFrame held : from.held) {
        held.frame += static_cast<std::uint32_t>(to.frames.size());
        to.held.push_back(held);
    }
    append(to.velocities, first_velocities(from, at));
    append(to.frames, at);
    for (std::size_t s = 0; s < from.body->layer.skeletons.size(); ++s) {
        to.muscle.push_back(from.sought(s));
    }
}

LayeredPart joined(const std::vector<Member>& members)
{
    LayeredPart part;
    part.colour = members[0].part.colour;
    LayeredBody body = without_content(*members[0].part.body);
    for (const Member& member : members) {
        if (&member != &members[0]) check_one_substance(members[0], member);
        append_body(body, *member.part.body);
        append_part(part, member.part);
    }
    part.body = std::make_shared<const LayeredBody>(std::move(body));
    return part;
}

}  // namespace

std::vector<LayeredPart> join_substances(std::vector<LayeredPart> parts)
{
    std::map<std::string, std::vector<Member>> substances;
    for (std::size_t b = 0; b < parts.size(); ++b) {
        const Base& base = parts[b].body->base;
        if (base.kind != BaseKind::particles || base.substance.name.empty()) continue;
        substances[base.substance.name].push_back({b, parts[b]});
    }
    std::vector<std::size_t> gone;
    for (const auto& [name, members] : substances) {
        if (members.size() < 2) continue;
        parts[members[0].number] = joined(members);
        for (std::size_t m = 1; m < members.size(); ++m) gone.push_back(members[m].number);
    }
    std::sort(gone.rbegin(), gone.rend());
    for (const std::size_t b : gone) parts.erase(parts.begin() + static_cast<std::ptrdiff_t>(b));
    return parts;
}

}  // namespace physics

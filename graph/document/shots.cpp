#include "graph/document/shots.hpp"

#include "graph/document/check_json.hpp"

#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include <fmt/format.h>

namespace graph {

namespace {

bool has_keys(const Json& json)
{
    return json.find("keys") != nullptr;
}

// Gives each member of `over` to `merge(base's member of that key or null, member)`, which says
// whether base's member stays; members without one in base that stay are added.
template <class Merge> void merge_members(Json& base, Json over, Merge merge)
{
    Json::Object& members = *base.object();
    std::unordered_map<std::string, std::size_t> index;
    for (std::size_t i = 0; i < members.size(); ++i) index.emplace(members[i].key, i);
    const std::size_t before = members.size();
    std::vector<char> gone(before, 0);
    for (Member& member : *over.object()) {
        const auto found = index.find(member.key);
        if (found == index.end()) {
            if (merge(nullptr, member)) members.push_back(std::move(member));
        } else if (!merge(&members[found->second], member)) {
            gone[found->second] = 1;
        }
    }
    std::size_t kept = 0;
    for (std::size_t i = 0; i < members.size(); ++i) {
        if (i < before && gone[i]) continue;
        if (kept != i) members[kept] = std::move(members[i]);
        ++kept;
    }
    members.resize(kept);
}

// Of an object that is laid over nothing, null takes nothing away.
void drop_nulls(Json& object)
{
    std::vector<Member>& members = *object.object();
    std::erase_if(members, [](const Member& member) { return member.value.null(); });
    for (Member& member : members) {
        if (member.value.object() && !has_keys(member.value)) drop_nulls(member.value);
    }
}

// Lays `patch` over `base`: null takes away, objects go in member by member, all else replaces.
void lay_over(Json& base, Json patch)
{
    if (!base.object() || !patch.object() || has_keys(base) || has_keys(patch)) {
        base = std::move(patch);
        return;
    }
    merge_members(base, std::move(patch), [](Member* below, Member& member) {
        if (member.value.null()) return false;
        if (below) {
            lay_over(below->value, std::move(member.value));
        } else if (member.value.object() && !has_keys(member.value)) {
            drop_nulls(member.value);
        }
        return true;
    });
}

bool replace(Member* below, Member& member)
{
    if (below) *below = std::move(member);
    return true;
}

void patch_nodes(Json& nodes, Json over, Problems& problems)
{
    std::vector<Problem> lost;  // told once the names have stopped moving
    merge_members(nodes, std::move(over), [&](Member* below, Member& member) {
        const bool whole = member.value.find("type") != nullptr;
        if (!below && !whole) {
            lost.push_back(problem_at(
                member.key_place(), fmt::format("the base document has no node '{}'", member.key)));
            lost.back().found = member.key;
            return false;
        }
        if (!below) return true;
        if (member.value.null()) return false;
        if (whole || !member.value.object()) return replace(below, member);
        lay_over(below->value, std::move(member.value));
        return true;
    });
    const std::vector<std::string_view> left = member_names(&nodes);
    for (Problem& p : lost) {
        p.suggestion = problems.full() ? "" : suggest(p.found, left);
        p.found.clear();
        problems.add(std::move(p));
    }
}

}  // namespace

void lay_shot_over(Json& base, Json over, Problems& problems)
{
    // What a scene promises of its numbers holds for that scene only.
    erase(base, "expect");
    merge_members(base, std::move(over), [&](Member* below, Member& member) {
        if (!below) return true;
        const bool objects = below->value.object() && member.value.object();
        if (member.key == "nodes" && objects) {
            patch_nodes(below->value, std::move(member.value), problems);
        } else if ((member.key == "frames" || member.key == "variables") && objects) {
            merge_members(below->value, std::move(member.value), replace);
        } else {
            replace(below, member);
        }
        return true;
    });
}

}  // namespace graph

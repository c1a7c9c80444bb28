#include "graph/document/json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>

#include <fmt/format.h>

namespace graph {

std::optional<double> Json::number() const
{
    if (const auto* i = std::get_if<std::int64_t>(&is)) return static_cast<double>(*i);
    if (const auto* d = std::get_if<double>(&is)) return *d;
    return {};
}

const Json* Json::find(std::string_view key) const
{
    if (const Object* members = object()) {
        for (const Member& m : *members) {
            if (m.key == key) return &m.value;
        }
    }
    return nullptr;
}

Json* Json::find(std::string_view key)
{
    return const_cast<Json*>(std::as_const(*this).find(key));
}

Place Json::place() const
{
    return origin ? origin->source->place(begin) : Place{};
}

Place Member::key_place() const
{
    return value.origin ? value.origin->source->place(key_begin) : Place{};
}

std::string Json::snippet() const
{
    if (object()) return object()->empty() ? "{}" : "an object";
    if (array() && array()->size() > 4) return fmt::format("a list of {}", array()->size());
    std::string text = to_text(*this);
    if (text.size() > 48) {
        std::size_t cut = 40;
        while (cut > 0 && !begins_character(text[cut])) --cut;
        text.resize(cut);
        text += "...";
    }
    return text;
}

namespace {

void write(const Json& json, std::string& out)
{
    if (const auto* b = std::get_if<bool>(&json.is)) {
        out += *b ? "true" : "false";
    } else if (const auto* i = std::get_if<std::int64_t>(&json.is)) {
        out += std::to_string(*i);
    } else if (const auto* d = std::get_if<double>(&json.is)) {
        out += nlohmann::json(*d).dump();  // the shortest text that reads back to the same number
    } else if (const std::string* s = json.text()) {
        out += nlohmann::json(*s).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    } else if (const Json::Array* items = json.array()) {
        out += '[';
        for (std::size_t k = 0; k < items->size(); ++k) {
            if (k > 0) out += ", ";
            write((*items)[k], out);
        }
        out += ']';
    } else if (const Json::Object* members = json.object()) {
        out += '{';
        for (std::size_t k = 0; k < members->size(); ++k) {
            if (k > 0) out += ", ";
            out += nlohmann::json((*members)[k].key)
                       .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
            out += ": ";
            write((*members)[k].value, out);
        }
        out += '}';
    } else {
        out += "null";
    }
}

}  // namespace

void put(Json& object, Member member)
{
    for (Member& m : *object.object()) {
        if (m.key == member.key) {
            m = std::move(member);
            return;
        }
    }
    object.object()->push_back(std::move(member));
}

Json* put_missing(Json& object, std::string_view key, decltype(Json::is) value)
{
    if (!object.object()) return nullptr;
    if (!object.find(key)) {
        Json made{std::move(value), object.origin, object.begin, object.end};
        object.object()->push_back({std::string(key), object.begin, std::move(made)});
    }
    return object.find(key);
}

Json& child(Json& parent, const std::string& key, const Json& like)
{
    const Json empty{Json::Object{}, like.origin, like.begin, like.end};
    if (!parent.object()) parent = empty;
    if (Json* found = parent.find(key)) return *found;
    parent.object()->push_back({key, like.begin, empty});
    return parent.object()->back().value;
}

void erase(Json& object, std::string_view key)
{
    if (!object.object()) return;
    Json::Object& members = *object.object();
    members.erase(std::remove_if(members.begin(), members.end(),
                                 [&](const Member& m) { return m.key == key; }),
                  members.end());
}

void rename(Json& object, std::string_view from, std::string to)
{
    if (!object.object()) return;
    for (Member& m : *object.object()) {
        if (m.key != from) continue;
        m.key = std::move(to);
        return;
    }
}

std::string to_text(const Json& json)
{
    std::string out;
    write(json, out);
    return out;
}

}  // namespace graph

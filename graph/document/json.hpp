#pragma once

// JSON as a tree in which every value and every key knows where it stands: what a document says.
// parse_json.hpp makes one of a text.

#include "graph/document/source.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace graph {

class Grammar;

// The text that a value came from, and the variables that its expressions may use.
struct Origin {
    std::shared_ptr<const Source> source;
    std::shared_ptr<const Grammar> grammar;
    std::string prefix;  // of the nodes that links name: "outer/" inside of a subgraph
    int layer = 0;       // of texts laid over each other, as a shot over its base: higher is later
};

struct Member;

struct Json {
    using Array = std::vector<Json>;
    using Object = std::vector<Member>;  // in order of the text, keys unique

    std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object> is;
    const Origin* origin = nullptr;
    std::uint32_t begin = 0, end = 0;  // bytes of the source

    // Null when it is something else.
    const Array* array() const { return std::get_if<Array>(&is); }
    const Object* object() const { return std::get_if<Object>(&is); }
    Array* array() { return std::get_if<Array>(&is); }
    Object* object() { return std::get_if<Object>(&is); }
    const std::string* text() const { return std::get_if<std::string>(&is); }
    bool null() const { return is.index() == 0; }
    std::optional<double> number() const;  // integers too

    // The member's value, null when there is none or this is no object.
    const Json* find(std::string_view key) const;
    Json* find(std::string_view key);

    Place place() const;
    // What stands there, on one line and shortened, for "found ...".
    std::string snippet() const;
};

struct Member {
    std::string key;
    std::uint32_t key_begin = 0;
    Json value;

    Place key_place() const;
};

// ---- changing an object: upgrade steps, shots and overrides do
// -----------------------------------

// Puts a member in the place of the one with its key, or at the end.
void put(Json& object, Member member);
// The member of that key; one of that value, standing where the object does, when there was none.
// Null when this is no object.
Json* put_missing(Json& object, std::string_view key, decltype(Json::is) value);
// The member `key` of `parent`, which becomes an object if it was none. What is made stands where
// `like` does.
Json& child(Json& parent, const std::string& key, const Json& like);
// Takes the member away, if there is one.
void erase(Json& object, std::string_view key);
// Gives the member `from`, if there is one, the name `to`.
void rename(Json& object, std::string_view from, std::string to);

// One line of canonical JSON.
std::string to_text(const Json&);

}  // namespace graph

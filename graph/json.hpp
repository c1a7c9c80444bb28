#pragma once

// JSON text as a tree in which every value and every key knows where it stands. The library's own
// tree forgets that; its event interface does the parsing, and a scanner of ours keeps in step with
// the events (between two tokens there is only white space, a comma, a colon or a comment).

#include "graph/problem.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace graph {

// A text, and an index from byte offsets to lines and columns.
class Source {
public:
    // `lines`: whether places in it have lines and columns (a command line's have not).
    Source(std::string name, std::filesystem::path folder, std::string text, bool lines = true);

    Place place(std::size_t offset) const;
    const std::string& name() const { return name_; }
    const std::filesystem::path& folder() const { return folder_; }  // relative paths start here
    const std::string& text() const { return text_; }

private:
    std::size_t characters_before(std::size_t offset) const;

    std::string name_;
    std::filesystem::path folder_;
    std::string text_;
    bool lines_;
    std::vector<std::uint32_t> line_starts_;
    std::vector<std::uint32_t> characters_;  // before every 256th byte
};

class Grammar;

// The text that a value came from, and the variables that its expressions may use.
struct Origin {
    std::shared_ptr<const Source> source;
    std::shared_ptr<const Grammar> grammar;
    std::string prefix;  // of the nodes that links name: "outer/" inside of a subgraph
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

struct Comment {
    std::uint32_t begin = 0, end = 0;
};

struct JsonLimits {
    int depth = 64;
    std::size_t values = 4'000'000;
};

// Null when the text is not JSON; what is wrong goes to `problems`, twice-used keys too (the first
// one stays). Comments are as in C++. `origin` must outlive the tree.
std::optional<Json> parse_json(const Origin& origin, const JsonLimits&, Problems& problems,
                               std::vector<Comment>* comments = nullptr);

// ---- changing an object (upgrade steps do)
// -------------------------------------------------------

// Puts a member in the place of the one with its key, or at the end.
void put(Json& object, Member member);
// The member of that key; one of that value, standing where the object does, when there was none.
// Null when this is no object.
Json* put_missing(Json& object, std::string_view key, decltype(Json::is) value);
// Takes the member away, if there is one.
void erase(Json& object, std::string_view key);
// Gives the member `from`, if there is one, the name `to`.
void rename(Json& object, std::string_view from, std::string to);

// One line of canonical JSON.
std::string to_text(const Json&);

}  // namespace graph

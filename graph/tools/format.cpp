#include "graph/tools/format.hpp"

#include "graph/document/expression.hpp"
#include "graph/document/parse_json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <unordered_map>
#include <unordered_set>

namespace graph {

namespace {

constexpr std::size_t columns = 100;

class Writer {
public:
    Writer(const std::string& source, std::vector<Comment> comments)
        : source_(source), comments_(std::move(comments))
    {}

    std::string document(Json& root)
    {
        order(root);
        claim_comments(root);
        spread_.insert(&root);
        if (const Json* nodes = root.find("nodes")) spread_.insert(nodes);
        std::string out;
        for (const Comment& c : claimed(before_, root)) out.append(text_of(c)).append("\n");
        write(root, 0, 0, out);
        for (const Comment& c : claimed(behind_, root)) out.append(" ").append(text_of(c));
        for (const Comment& c : inside_[nullptr]) out.append("\n").append(text_of(c));
        return out + "\n";
    }

private:
    // ---- order of members ------------------------------------------------------------------

    static void sort_members(Json& json, std::initializer_list<std::string_view> known)
    {
        if (!json.object()) return;
        const auto rank = [&](const Member& m) {
            return std::find(known.begin(), known.end(), m.key) - known.begin();
        };
        std::stable_sort(json.object()->begin(), json.object()->end(),
                         [&](const Member& a, const Member& b) { return rank(a) < rank(b); });
    }
    static void order(Json& root)
    {
        sort_members(root, {"$schema", "aspic", "doc", "extends", "subgraph", "frames", "variables",
                            "nodes", "expect"});
        if (Json* frames = root.find("frames")) sort_members(*frames, {"first", "last", "fps"});
        if (Json* nodes = root.find("nodes"); nodes && nodes->object()) {
            for (Member& node : *nodes->object()) {
                sort_members(node.value, {"type", "doc", "inputs", "params"});
            }
        }
    }

    // ---- comments --------------------------------------------------------------------------

    std::string text_of(const Comment& c) const
    {
        std::string text = source_.substr(c.begin, c.end - c.begin);
        while (!text.empty() && (text.back() == '\r' || text.back() == ' ')) text.pop_back();
        return text;
    }

    bool same_line(std::size_t from, std::size_t to) const
    {
        return source_.find('\n', from) >= to;
    }

    // Gives each comment to the value that it stands behind on the same line, or else to the one
    // that comes next, or else to the end of the object or list around it.
    void claim_comments(const Json& root)
    {
        if (comments_.empty()) return;
        struct Item {
            std::size_t begin, end;
            const Json* value;
            const Json* parent;
        };
        std::vector<Item> items;
        const auto collect = [&](const auto& self, const Json& json, const Json* parent,
                                 std::size_t begin) -> void {
            items.push_back({begin, json.end, &json, parent});
            if (json.object()) {
                for (const Member& m : *json.object()) self(self, m.value, &json, m.key_begin);
            } else if (json.array()) {
                for (const Json& j : *json.array()) self(self, j, &json, j.begin);
            }
        };
        collect(collect, root, nullptr, root.begin);
        std::sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
            return a.begin != b.begin ? a.begin < b.begin : a.end > b.end;
        });
        std::vector<const Item*> by_end;
        for (const Item& item : items) by_end.push_back(&item);
        std::sort(by_end.begin(), by_end.end(), [](const Item* a, const Item* b) {
            return a->end != b->end ? a->end < b->end : a->begin > b->begin;
        });
        for (const Comment& c : comments_) {
            const auto next =
                std::lower_bound(items.begin(), items.end(), std::size_t{c.begin},
                                 [](const Item& i, std::size_t at) { return i.begin < at; });
            const auto after =
                std::upper_bound(by_end.begin(), by_end.end(), std::size_t{c.begin},
                                 [](std::size_t at, const Item* i) { return at < i->end; });
            // What ends last before the comment; what begins last before it if that is an opening.
            const Item* previous = after == by_end.begin() ? nullptr : *(after - 1);
            const Item* opened = next == items.begin() ? nullptr : &*(next - 1);
            if (previous && opened && opened->begin > previous->end) previous = nullptr;
            if (previous && same_line(previous->end, c.begin)) {
                behind_[previous->value].push_back(c);
                spread_.insert(previous->parent);
            } else if (next != items.end() &&
                       (after == by_end.end() || next->begin < (*after)->end)) {
                before_[next->value].push_back(c);
                spread_.insert(next->parent);
            } else {
                const Json* around = after == by_end.end() ? nullptr : (*after)->value;
                if (around && !around->object() && !around->array()) {
                    before_[around].push_back(c);  // it stood between a key and its value
                    spread_.insert((*after)->parent);
                } else {
                    inside_[around].push_back(c);
                    spread_.insert(around);
                }
            }
        }
        spread_around_comments(root);
    }

    // An object or list with a comment anywhere in it takes several lines.
    bool spread_around_comments(const Json& json)
    {
        bool any = spread_.count(&json) > 0;
        if (json.object()) {
            for (const Member& m : *json.object()) any = spread_around_comments(m.value) || any;
        } else if (json.array()) {
            for (const Json& j : *json.array()) any = spread_around_comments(j) || any;
        }
        if (any) spread_.insert(&json);
        return any;
    }

    // ---- text ------------------------------------------------------------------------------

    static std::string quoted(const std::string& text)
    {
        return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }

    // A whole number beyond 64 bits as it was written: Aspic rounds it to a double, but in "ui" it
    // may be an id of another program.
    std::optional<std::string> long_digits(const Json& json) const
    {
        const auto* d = std::get_if<double>(&json.is);
        if (!d || std::fabs(*d) < 0x1p63) return {};
        std::string text = source_.substr(json.begin, json.end - json.begin);
        if (text.find_first_not_of("-0123456789") != text.npos) return {};
        return text;
    }

    std::string flat(const Json& json) const
    {
        if (const auto* d = std::get_if<double>(&json.is);
            d && std::fabs(*d) < 1e15 && *d == std::floor(*d)) {
            return std::to_string(static_cast<std::int64_t>(*d));
        }
        if (auto digits = long_digits(json)) return *digits;
        if (json.array() && !json.array()->empty()) {
            std::string out = "[";
            for (const Json& j : *json.array()) out += (out.size() > 1 ? ", " : "") + flat(j);
            return out + "]";
        }
        if (json.object() && !json.object()->empty()) {
            std::string out = "{ ";
            for (const Member& m : *json.object()) {
                out += (out.size() > 2 ? ", " : "") + quoted(m.key) + ": " + flat(m.value);
            }
            return out + " }";
        }
        return to_text(json);
    }

    // `column`: where the text begins, with room for a comma after it.
    void write(const Json& json, std::size_t level, std::size_t column, std::string& out)
    {
        const bool nests = json.object() || json.array();
        if (!nests || !spread_.count(&json)) {
            const std::string line = flat(json);
            if (!nests || column + line.size() + 1 <= columns) {
                out += line;
                return;
            }
        }
        const std::string indent((level + 1) * 2, ' ');
        const Json::Object* members = json.object();
        const std::size_t count = members ? members->size() : json.array()->size();
        out += members ? "{" : "[";
        for (std::size_t i = 0; i < count; ++i) {
            const Json& value = members ? (*members)[i].value : (*json.array())[i];
            const std::string head = members ? quoted((*members)[i].key) + ": " : "";
            for (const Comment& c : claimed(before_, value))
                out.append("\n").append(indent).append(text_of(c));
            out.append("\n").append(indent).append(head);
            write(value, level + 1, indent.size() + head.size(), out);
            if (i + 1 < count) out += ",";
            for (const Comment& c : claimed(behind_, value)) out.append("  ").append(text_of(c));
        }
        for (const Comment& c : claimed(inside_, json))
            out.append("\n").append(indent).append(text_of(c));
        out.append("\n").append(level * 2, ' ').append(members ? "}" : "]");
    }

    using Claims = std::unordered_map<const Json*, std::vector<Comment>>;
    static const std::vector<Comment>& claimed(const Claims& claims, const Json& json)
    {
        static const std::vector<Comment> none;
        const auto found = claims.find(&json);
        return found == claims.end() ? none : found->second;
    }

    const std::string& source_;
    std::vector<Comment> comments_;
    Claims before_, behind_, inside_;
    std::unordered_set<const Json*> spread_;  // take several lines
};

}  // namespace

std::optional<std::string> format_document(std::string text, const std::filesystem::path& file,
                                           Problems& problems)
{
    Origin origin;
    origin.source =
        std::make_shared<const Source>(file.generic_string(), file.parent_path(), std::move(text));
    std::vector<Comment> comments;
    std::optional<Json> root = parse_json(origin, {}, problems, &comments);
    if (!root || problems.has_errors()) return {};
    return Writer(origin.source->text(), std::move(comments)).document(*root);
}

}  // namespace graph

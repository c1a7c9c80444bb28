#include "graph/json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>

namespace graph {

namespace {

constexpr std::size_t block = 256;

bool begins_character(char c)
{
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;  // all but UTF-8 continuation bytes
}

}  // namespace

Source::Source(std::string name, std::filesystem::path folder, std::string text, bool lines)
    : name_(std::move(name)), folder_(std::move(folder)), text_(std::move(text)), lines_(lines)
{
    line_starts_.push_back(0);
    std::uint32_t characters = 0;
    for (std::size_t i = 0; i < text_.size(); ++i) {
        if (i % block == 0) characters_.push_back(characters);
        if (begins_character(text_[i])) ++characters;
        if (text_[i] == '\n') line_starts_.push_back(static_cast<std::uint32_t>(i + 1));
    }
}

std::size_t Source::characters_before(std::size_t offset) const
{
    if (characters_.empty()) return 0;
    const std::size_t b = std::min(offset / block, characters_.size() - 1);
    std::size_t count = characters_[b];
    for (std::size_t i = b * block; i < offset; ++i) count += begins_character(text_[i]) ? 1 : 0;
    return count;
}

Place Source::place(std::size_t offset) const
{
    if (!lines_) return {name_, 0, 0};
    offset = std::min(offset, text_.size());
    const auto after = std::upper_bound(line_starts_.begin(), line_starts_.end(), offset);
    const std::size_t start = *(after - 1);
    return {name_, static_cast<int>(after - line_starts_.begin()),
            static_cast<int>(characters_before(offset) - characters_before(start)) + 1};
}

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

// The library's text "[json.exception...] parse error at line 1, column 2: syntax error while ...;
// last read: ..." without the parts that a place says better.
std::string plain(std::string what)
{
    if (const auto end = what.find("] "); end != std::string::npos) what = what.substr(end + 2);
    for (const std::string_view lead : {"parse error", "syntax error "}) {
        const auto found = what.find(lead);
        if (found == std::string::npos) continue;
        const auto colon = lead.ends_with(' ') ? found : what.find(": ", found);
        if (colon != std::string::npos) {
            what = what.substr(colon + (lead.ends_with(' ') ? lead.size() : 2));
        }
    }
    const auto read = what.find("; last read: ");
    if (read == std::string::npos) return what;
    const auto rest = what.find("'; ", read);  // "; expected ..."
    return what.substr(0, read) + (rest == std::string::npos ? "" : what.substr(rest + 1));
}

// Reads the events of the library's parser and finds each one's token again in the text.
class TreeBuilder : public nlohmann::json_sax<nlohmann::json> {
public:
    TreeBuilder(const Origin& origin, const JsonLimits& limits, Problems& problems,
                std::vector<Comment>* comments)
        : origin_(origin), text_(origin.source->text()), limits_(limits), problems_(problems),
          comments_(comments)
    {
        if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
    }

    std::optional<Json> finish()
    {
        skip();  // the comments at the end
        return std::move(root_);
    }

    bool null() override { return word({}, 4); }
    bool boolean(bool b) override { return word({b}, b ? 4 : 5); }
    bool number_integer(std::int64_t i) override { return number({i}); }
    bool number_unsigned(std::uint64_t u) override
    {
        if (u > static_cast<std::uint64_t>(INT64_MAX)) return number({static_cast<double>(u)});
        return number({static_cast<std::int64_t>(u)});
    }
    bool number_float(double d, const std::string&) override { return number({d}); }
    bool string(std::string& s) override
    {
        const std::size_t begin = skip();
        pass_string();
        return place({std::move(s)}, begin);
    }
    bool binary(nlohmann::json::binary_t&) override { return false; }  // JSON text has none

    bool key(std::string& k) override
    {
        const std::size_t begin = skip();
        pass_string();
        keys_.push_back({std::move(k), static_cast<std::uint32_t>(begin)});
        return true;
    }
    bool start_object(std::size_t) override { return open(Json::Object{}); }
    bool start_array(std::size_t) override { return open(Json::Array{}); }
    bool end_object() override
    {
        refuse_twins(*open_.back().object());
        return close();
    }
    bool end_array() override { return close(); }

    bool parse_error(std::size_t position, const std::string&,
                     const nlohmann::detail::exception& e) override
    {
        const std::size_t start = skip();
        std::size_t offset = position > 0 ? position - 1 : 0;
        // Inside a string the byte that is wrong, else the whole token's beginning.
        if (start < offset && text_[start] != '"') offset = start;

        Problem p;
        p.place = origin_.source->place(offset);
        p.message = "this is not JSON: " + plain(e.what());
        const std::size_t before = text_.find_last_not_of(" \t\r\n", offset - 1);
        if (offset >= text_.size()) {
            p.suggestion = "the file ends too early: was it cut off?";
        } else if ((text_[offset] == '}' || text_[offset] == ']') && before < offset &&
                   text_[before] == ',') {
            p.suggestion = "no comma may stand before the closing bracket";
        }
        problems_.add(std::move(p));
        return false;
    }

private:
    using Content = decltype(Json::is);
    struct Key {
        std::string text;
        std::uint32_t begin;
    };

    // Moves to the next token and says where it begins.
    std::size_t skip()
    {
        while (at_ < text_.size()) {
            const char c = text_[at_];
            if (c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',' || c == ':') {
                ++at_;
            } else if (c == '/' && at_ + 1 < text_.size()) {
                const std::size_t begin = at_;
                if (text_[at_ + 1] == '/') {
                    at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
                } else {
                    const std::size_t stop = text_.find("*/", at_ + 2);
                    at_ = stop == std::string::npos ? text_.size() : stop + 2;
                }
                if (comments_) {
                    comments_->push_back(
                        {static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(at_)});
                }
            } else {
                break;
            }
        }
        return at_;
    }
    void pass_string()
    {
        for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
            if (text_[at_] == '\\') ++at_;
        }
        ++at_;
    }

    bool word(Content content, std::size_t length)
    {
        const std::size_t begin = skip();
        at_ += length;
        return place(std::move(content), begin);
    }
    bool number(Content content)
    {
        const std::size_t begin = skip();
        at_ = std::min(text_.find_first_not_of("+-.eE0123456789", at_), text_.size());
        return place(std::move(content), begin);
    }

    bool refuse(std::size_t offset, std::string message)
    {
        Problem p;
        p.place = origin_.source->place(offset);
        p.message = std::move(message);
        problems_.add(std::move(p));
        return false;
    }

    bool open(Content content)
    {
        const std::size_t begin = skip();
        ++at_;
        if (static_cast<int>(open_.size()) >= limits_.depth) {
            return refuse(begin, fmt::format("brackets nest deeper than {}", limits_.depth));
        }
        Json json{std::move(content), &origin_, static_cast<std::uint32_t>(begin), 0};
        open_.push_back(std::move(json));
        return true;
    }
    bool close()
    {
        skip();
        ++at_;
        Json json = std::move(open_.back());
        open_.pop_back();
        json.end = static_cast<std::uint32_t>(at_);
        return attach(std::move(json));
    }
    bool place(Content content, std::size_t begin)
    {
        return attach({std::move(content), &origin_, static_cast<std::uint32_t>(begin),
                       static_cast<std::uint32_t>(at_)});
    }
    bool attach(Json json)
    {
        if (++values_ > limits_.values) {
            return refuse(json.begin, fmt::format("more than {} values", limits_.values));
        }
        if (open_.empty()) {
            root_ = std::move(json);
        } else if (Json::Object* members = open_.back().object()) {
            members->push_back({std::move(keys_.back().text), keys_.back().begin, std::move(json)});
            keys_.pop_back();
        } else {
            open_.back().array()->push_back(std::move(json));
        }
        return true;
    }

    // Keeps the first of members with equal keys and reports the others.
    void refuse_twins(Json::Object& members)
    {
        std::vector<char> twin(members.size(), 0);
        bool any = false;
        const auto compare = [&](std::size_t first, std::size_t second) {
            Problem p;
            p.place = members[second].key_place();
            p.message = fmt::format("'{}' stands here a second time, first on line {}",
                                    members[second].key, members[first].key_place().line);
            p.suggestion = "keep one of the two";
            problems_.add(std::move(p));
            twin[second] = 1;
            any = true;
        };
        if (members.size() <= 8) {
            for (std::size_t i = 1; i < members.size(); ++i) {
                for (std::size_t k = 0; k < i; ++k) {
                    if (members[k].key == members[i].key) {
                        compare(k, i);
                        break;
                    }
                }
            }
        } else {
            std::unordered_map<std::string_view, std::size_t> first;
            first.reserve(members.size());
            for (std::size_t i = 0; i < members.size(); ++i) {
                const auto [found, added] = first.try_emplace(members[i].key, i);
                if (!added) compare(found->second, i);
            }
        }
        if (!any) return;
        std::size_t kept = 0;
        for (std::size_t i = 0; i < members.size(); ++i) {
            if (twin[i]) continue;
            if (kept != i) members[kept] = std::move(members[i]);
            ++kept;
        }
        members.resize(kept);
    }

    const Origin& origin_;
    const std::string& text_;
    JsonLimits limits_;
    Problems& problems_;
    std::vector<Comment>* comments_;
    std::size_t at_ = 0, values_ = 0;
    std::vector<Json> open_;
    std::vector<Key> keys_;
    std::optional<Json> root_;
};

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

std::optional<Json> parse_json(const Origin& origin, const JsonLimits& limits, Problems& problems,
                               std::vector<Comment>* comments)
{
    TreeBuilder builder(origin, limits, problems, comments);
    const bool whole = nlohmann::json::sax_parse(origin.source->text(), &builder,
                                                 nlohmann::json::input_format_t::json, true, true);
    if (!whole) return {};
    return builder.finish();
}

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

#include "graph/document/parse_json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>

namespace graph {

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

// What a word that is no JSON, such as Python's True, is likely to mean.
std::string help_for_word(std::string_view word)
{
    if (word.empty() || word == "true" || word == "false" || word == "null") return {};
    if (word[0] == '\'') return "text stands in double quotes: \"...\"";
    if (word == "None") return "did you mean null?";
    constexpr std::string_view words[] = {"true", "false", "null"};
    const std::string near = nearest(word, words);
    if (!near.empty()) return fmt::format("did you mean {}?", near);
    return fmt::format("text stands in double quotes: \"{}\"", word);
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
        const std::string what = plain(e.what());
        const bool no_end = what.ends_with("expected '}'") || what.ends_with("expected ']'");
        // Inside a string the byte that is wrong, else the whole token's beginning.
        if (start < offset && (no_end || text_[start] != '"')) offset = start;

        Problem p;
        p.place = origin_.source->place(is_utf16() ? 0 : offset);
        if (is_utf16()) {
            p.message = "this is UTF-16";
            p.suggestion = "save it as UTF-8";
            problems_.add(std::move(p));
            return false;
        }
        p.message = "invalid JSON: " + what;
        const std::size_t before = text_.find_last_not_of(" \t\r\n", offset - 1);
        const auto follows = [&](std::string_view some) {
            return before < offset && some.find(text_[before]) != std::string_view::npos;
        };
        if (offset >= text_.size()) {
            p.suggestion = "the file ends too early; is it complete?";
        } else if ((text_[offset] == '}' || text_[offset] == ']') && follows(",")) {
            p.suggestion = "remove the comma before the closing bracket";
        } else if (std::string help = help_for_word(word_at(start)); !help.empty()) {
            p.suggestion = std::move(help);
        } else if (no_end && !follows(",:[{")) {
            p.suggestion = "a comma is missing before it";
        }
        problems_.add(std::move(p));
        return false;
    }

private:
    // By the mark that such files begin with, or as every other byte of "{\n" is 0.
    bool is_utf16() const
    {
        using namespace std::string_view_literals;
        for (const auto start : {"\xFF\xFE"sv, "\xFE\xFF"sv, "{\0"sv, "\0{"sv}) {
            if (text_.starts_with(start)) return true;
        }
        return false;
    }

    // The word of letters, or the single quote, that begins there.
    std::string_view word_at(std::size_t begin) const
    {
        if (begin >= text_.size()) return {};
        if (text_[begin] == '\'') return std::string_view(text_).substr(begin, 1);
        std::size_t end = begin;
        while (end < text_.size() && std::isalpha(static_cast<unsigned char>(text_[end]))) ++end;
        return std::string_view(text_).substr(begin, std::min<std::size_t>(end - begin, 40));
    }

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
                    constexpr std::string_view ends{"\r\n\0", 3};  // as the parser has it
                    at_ = std::min(text_.find_first_of(ends, at_), text_.size());
                    if (at_ < text_.size() && text_[at_] == '\0') ++at_;
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
            return refuse(begin, fmt::format("brackets nested deeper than {}", limits_.depth));
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
            p.message = fmt::format("duplicate key '{}', first on line {}", members[second].key,
                                    members[first].key_place().line);
            p.suggestion = "remove one of them";
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

}  // namespace graph

#include "graph/read_params.hpp"

#include "graph/curve.hpp"
#include "graph/evaluate.hpp"
#include "graph/expression.hpp"
#include "graph/frame_path.hpp"

#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace graph {

namespace {

double linear_of_srgb(double s)
{
    return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// "#rgb" or "#rrggbb" as linear RGB.
std::optional<std::array<double, 3>> hex_colour(const std::string& text)
{
    if ((text.size() != 4 && text.size() != 7) || text[0] != '#') return {};
    const std::size_t digits = (text.size() - 1) / 3;
    std::array<double, 3> rgb{};
    for (std::size_t c = 0; c < 3; ++c) {
        int level = 0;
        for (std::size_t d = 0; d < 2; ++d) {
            const char digit = text[1 + c * digits + (digits == 2 ? d : 0)];
            if (!std::isxdigit(static_cast<unsigned char>(digit))) return {};
            const int lower = std::tolower(static_cast<unsigned char>(digit));
            level = 16 * level + (lower <= '9' ? lower - '0' : lower - 'a' + 10);
        }
        rgb[c] = linear_of_srgb(level / 255.0);
    }
    return rgb;
}

bool is_expression(const Json& json)
{
    return json.text() && json.text()->starts_with('=');
}

bool is_curve(const Json& json)
{
    return json.object() != nullptr;
}

// Where byte `position` of an expression stands, when the text has it as it is.
Place place_in(const Json& json, std::size_t position)
{
    if (!json.origin) return {};
    const Source& source = *json.origin->source;
    const bool quoted = json.begin < source.text().size() && source.text()[json.begin] == '"';
    const std::size_t begin = json.begin + (quoted ? 1 : 0);
    const std::string_view raw(source.text().data() + begin, json.end - begin);
    return source.place(raw.starts_with(*json.text()) ? begin + 1 + position : json.begin);
}

std::optional<Expression> compile(const Json& json, Problem& problem)
{
    try {
        return json.origin->grammar->compile(json.text()->substr(1));
    } catch (const ExpressionError& e) {
        problem.place = place_in(json, e.position);
        problem.message = e.what();
        problem.suggestion = e.suggestion;
        return {};
    }
}

// Reads the parameters of one node, recursively through blocks and lists (whose depth the
// description bounds).
class ParamReader {
public:
    ParamReader(const ReadContext& context, Node& node) : c_(context), node_(node) {}

    ParamValues read_struct(const std::vector<Param>& params, const Json* given)
    {
        ParamValues values;
        values.reserve(params.size());
        for (const Param& p : params) values.push_back(p.fallback);
        if (!given) return values;
        if (!given->object()) {
            complain(given->place(), "an object {...}", *given);
            return values;
        }

        std::vector<const Json*> found(params.size(), nullptr);
        for (const Member& member : *given->object()) {
            const std::size_t i = index_of(params, member.key);
            if (i == params.size()) {
                unknown(params, member);
            } else {
                found[i] = &member.value;
            }
        }
        // Choices first: they decide which of the others are looked at.
        for (const bool deciding : {true, false}) {
            for (std::size_t i = 0; i < params.size(); ++i) {
                if (!found[i] || decides(params[i]) != deciding) continue;
                const ShownWhen* const by = deciding ? nullptr : hidden_by(params, values, i);
                if (by) {
                    hidden(params[i], *found[i], *by, values, params);
                    continue;
                }
                where_.push_back(static_cast<std::uint32_t>(i));
                names_.push_back(params[i].name);
                values[i] = read(params[i], *found[i]);
                names_.pop_back();
                where_.pop_back();
            }
        }
        for (std::size_t i = 0; i < params.size(); ++i) {
            if (!found[i] || !decides(params[i])) continue;
            if (const ShownWhen* const by = hidden_by(params, values, i)) {
                hidden(params[i], *found[i], *by, values, params);
                values[i] = params[i].fallback;
            }
        }
        return values;
    }

private:
    static std::size_t index_of(const std::vector<Param>& params, std::string_view name)
    {
        std::size_t i = 0;
        while (i < params.size() && params[i].name != name) ++i;
        return i;
    }
    static bool decides(const Param& p)
    {
        return p.kind == ParamKind::choice || p.kind == ParamKind::boolean;
    }

    // The outermost condition that does not hold, of its own and those of the parameters that it
    // depends on; null: it is shown.
    static const ShownWhen* hidden_by(const std::vector<Param>& params, const ParamValues& values,
                                      std::size_t i)
    {
        const ShownWhen* by = nullptr;
        for (std::size_t depth = 0; depth <= params.size(); ++depth) {
            const ShownWhen& when = params[i].shown_when;
            const std::size_t k = index_of(params, when.param);
            if (k == params.size()) break;
            const std::string now = text_of(values[k]);
            if (std::find(when.values.begin(), when.values.end(), now) == when.values.end()) {
                by = &when;
            }
            i = k;
        }
        return by;
    }
    static std::string text_of(const ParamValue& value)
    {
        if (const auto* s = std::get_if<std::string>(&value.is)) return *s;
        if (const auto* b = std::get_if<bool>(&value.is)) return *b ? "true" : "false";
        if (const auto* i = std::get_if<std::int64_t>(&value.is)) return std::to_string(*i);
        return {};
    }

    std::string path(const std::string& last = {}) const
    {
        std::string text;
        for (const std::string& name : names_) text += (text.empty() ? "" : ".") + name;
        return last.empty() ? text : text + (text.empty() ? "" : ".") + last;
    }

    Problem problem(Place place, Severity severity = Severity::error) const
    {
        Problem p;
        p.place = std::move(place);
        p.severity = severity;
        p.node = node_.name;
        p.part = Part::parameter;
        p.port = path();
        return p;
    }
    void complain(Place place, std::string expected, const Json& found, std::string help = {})
    {
        Problem p = problem(std::move(place));
        if (names_.empty()) p.part = Part::none;
        p.expected = std::move(expected);
        p.found = found.snippet();
        p.suggestion = std::move(help);
        c_.problems.add(std::move(p));
    }

    // Where blocks, and blocks in blocks, have a parameter of this name.
    static std::vector<std::string> within_blocks(const std::vector<Param>& params,
                                                  const std::string& name)
    {
        std::vector<std::string> found;
        for (const Param& block : params) {
            if (block.kind != ParamKind::block) continue;
            for (const Param& p : block.children) {
                if (p.name == name) found.push_back(block.name + "." + name);
            }
            for (const std::string& path : within_blocks(block.children, name)) {
                found.push_back(block.name + "." + path);
            }
        }
        return found;
    }

    void unknown(const std::vector<Param>& params, const Member& member)
    {
        std::vector<std::string_view> names;
        for (const Param& p : params) names.emplace_back(p.name);
        Problem p = problem(member.key_place());
        p.port = path(member.key);
        p.message = names.empty() && names_.empty()
                        ? fmt::format("{} has no parameters", node_.type->name)
                    : names_.empty() ? fmt::format("{} has no such parameter", node_.type->name)
                                     : fmt::format("'{}' has no such parameter", path());
        p.suggestion = suggest(member.key, names);
        const std::vector<std::string> inside = within_blocks(params, member.key);
        if (!inside.empty()) {
            p.suggestion = fmt::format("did you mean '{}'?", fmt::join(inside, "' or '"));
        }
        for (std::size_t i = 0; names_.empty() && i < node_.type->inputs.size(); ++i) {
            if (node_.type->inputs[i].name == member.key) {
                p.suggestion = fmt::format("'{}' is an input: link it in \"inputs\"", member.key);
            }
        }
        c_.problems.add(std::move(p));
    }

    void hidden(const Param& param, const Json& given, const ShownWhen& by,
                const ParamValues& values, const std::vector<Param>& params)
    {
        const std::size_t k = index_of(params, by.param);
        Problem p = problem(given.place(), Severity::warning);
        p.port = path(param.name);
        const std::vector<std::string_view> wanted(by.values.begin(), by.values.end());
        p.message = fmt::format("this has no effect while {} is {}; it takes {}", by.param,
                                text_of(values[k]), list_names(wanted));
        c_.problems.add(std::move(p));
        // It is read all the same: what is wrong with it would come out when it is wanted.
        Problems inside;
        Node scratch;
        scratch.name = node_.name;
        scratch.type = node_.type;
        const ReadContext context{c_.range, c_.paths, inside};
        ParamReader reader(context, scratch);
        reader.names_ = names_;
        reader.names_.push_back(param.name);
        reader.read(param, given);
        for (Problem& found : inside.take()) {
            found.severity = std::min(found.severity, Severity::warning);
            c_.problems.add(std::move(found));
        }
    }

    ParamValue read(const Param& param, const Json& json)
    {
        switch (param.kind) {
        case ParamKind::boolean:
            if (const bool* b = std::get_if<bool>(&json.is)) return {*b};
            break;
        case ParamKind::integer:
        case ParamKind::number:
            return read_number(param, json);
        case ParamKind::vector:
        case ParamKind::colour:
            return read_vector(param, json);
        case ParamKind::text:
            if (json.text()) return {*json.text()};
            break;
        case ParamKind::choice:
            return read_choice(param, json);
        case ParamKind::path_in:
            if (json.text()) return read_path_in(param, json);
            break;
        case ParamKind::path_out:
            if (json.text()) return read_path_out(param, json);
            break;
        case ParamKind::list:
            return read_list(param, json);
        case ParamKind::block:
            if (json.object()) return {read_struct(param.children, &json)};
            break;
        }
        complain(json.place(), expectation_of(param), json);
        return param.fallback;
    }

    // A plain number or a constant expression, rounded if need be and checked; else reports.
    std::optional<double> read_plain(const Param& param, const Json& json, bool may_round = false)
    {
        const bool computed = is_expression(json);
        Problem p = problem(json.place());
        std::optional<double> x = read_constant(json, p);
        if (!x) {
            if (p.message.empty()) p.expected = expectation_of(param);
            c_.problems.add(std::move(p));
            return {};
        }
        return check(param, *x, json, computed || may_round);
    }

    std::optional<double> check(const Param& param, double x, const Json& json, bool may_round)
    {
        const bool whole = param.kind == ParamKind::integer;
        if (whole && may_round) x = std::round(x);
        if (within(x, param.limits) && std::isfinite(x) && (!whole || x == std::floor(x))) return x;
        Problem p = problem(json.place());
        p.expected = expectation_of(param);
        p.found = is_expression(json)
                      ? fmt::format("{}, which is {}", json.snippet(), number_text(x))
                      : json.snippet();
        c_.problems.add(std::move(p));
        return {};
    }

    ParamValue plain_value(const Param& param, double x) const
    {
        if (param.kind == ParamKind::integer) return {static_cast<std::int64_t>(x)};
        return {x};
    }

    Animated animated(const Param& param, const Json& json, int component) const
    {
        Animated a;
        a.where = where_;
        a.component = component;
        a.kind = param.kind;
        a.limits = param.limits;
        a.source = json.text() ? *json.text() : to_text(json);
        a.place = json.place();
        return a;
    }

    // A number that is an expression or a curve: its value if it never changes, else nothing and
    // one more entry in node.animated (or a report).
    std::optional<double> read_moving(const Param& param, const Json& json, int component)
    {
        if (is_expression(json)) {
            Problem p = problem(json.place());
            std::optional<Expression> e = compile(json, p);
            if (!e) {
                c_.problems.add(std::move(p));
                return {};
            }
            if (e->constant) return check(param, *e->constant, json, true);
            Animated a = animated(param, json, component);
            a.value = std::move(e->value);
            node_.animated.push_back(std::move(a));
            return {};
        }
        std::optional<Keys> keys = read_keys(param, json, 1);
        if (!keys) return {};
        return add_curve(param, json, component, std::move(keys->times), std::move(keys->values[0]),
                         *keys);
    }

    ParamValue read_number(const Param& param, const Json& json)
    {
        const std::optional<double> x = is_expression(json) || is_curve(json)
                                            ? read_moving(param, json, -1)
                                            : read_plain(param, json);
        return x ? plain_value(param, *x) : param.fallback;
    }

    // Three numbers as a list or a colour's name; each may be an expression or a curve.
    ParamValue read_vector(const Param& param, const Json& json)
    {
        auto value = std::get<std::array<double, 3>>(param.fallback.is);
        if (is_curve(json)) {
            std::optional<Keys> keys = read_keys(param, json, 3);
            for (std::size_t i = 0; keys && i < 3; ++i) {
                const auto x = add_curve(param, json, static_cast<int>(i), keys->times,
                                         std::move(keys->values[i]), *keys);
                if (x) value[i] = *x;
            }
            return {value};
        }
        if (param.kind == ParamKind::colour && json.text()) {
            if (const auto rgb = hex_colour(*json.text())) return {*rgb};
        }
        const Json::Array* items = json.array();
        if (!items || items->size() != 3) {
            complain(json.place(), expectation_of(param), json,
                     is_expression(json) ? "write an expression for each component" : "");
            return {value};
        }
        for (std::size_t i = 0; i < 3; ++i) {
            const Json& item = (*items)[i];
            const std::optional<double> x = is_expression(item) || is_curve(item)
                                                ? read_moving(param, item, static_cast<int>(i))
                                                : read_plain(param, item);
            if (x) value[i] = *x;
        }
        return {value};
    }

    struct Keys {
        std::vector<double> times;
        std::array<std::vector<double>, 3> values;
        bool seconds = false;
        Curve::Between between = Curve::Between::monotone;
        Curve::Beyond beyond = Curve::Beyond::hold;
    };

    // { "keys": [[frame, value], ...], "interpolation": ..., "extend": ..., "times": ... }
    std::optional<Keys> read_keys(const Param& param, const Json& json, std::size_t width)
    {
        Keys keys;
        bool good = true;
        const Json* list = nullptr;
        for (const Member& member : *json.object()) {
            if (member.key == "keys") {
                list = &member.value;
            } else if (member.key == "interpolation") {
                const auto i = word(member.value, {"monotone", "smooth", "linear", "step"});
                good = good && i;
                if (i) keys.between = static_cast<Curve::Between>(*i);
            } else if (member.key == "extend") {
                const auto i = word(member.value, {"hold", "cycle"});
                good = good && i;
                if (i) keys.beyond = static_cast<Curve::Beyond>(*i);
            } else if (member.key == "times") {
                const auto i = word(member.value, {"frames", "seconds"});
                good = good && i;
                if (i) keys.seconds = *i == 1;
            } else {
                static constexpr std::string_view known[] = {"keys", "interpolation", "extend",
                                                             "times"};
                Problem p = problem(member.key_place());
                p.message = fmt::format("a curve has no '{}'", member.key);
                p.suggestion = suggest(member.key, known);
                c_.problems.add(std::move(p));
                good = false;
            }
        }
        if (!list || !list->array() || list->array()->empty()) {
            if (!list && !good) return {};  // said already
            complain((list ? *list : json).place(),
                     list ? "keys [[frame, value], ...]"
                          : expectation_of(param) +
                                ", or keyframes { \"keys\": [[frame, value], ...] }",
                     list ? *list : json);
            return {};
        }
        for (const Json& key : *list->array()) good = read_key(param, key, width, keys) && good;
        if (!good) return {};
        return keys;
    }

    bool read_key(const Param& param, const Json& key, std::size_t width, Keys& keys)
    {
        if (!key.array() || key.array()->size() != 2) {
            complain(key.place(), "a key [frame, value]", key);
            return false;
        }
        const Json &when = (*key.array())[0], &what = (*key.array())[1];
        Problem p = problem(when.place());
        const std::optional<double> time = read_constant(when, p);
        if (!time) {
            if (p.message.empty()) p.expected = "the key's frame, a number";
            c_.problems.add(std::move(p));
            return false;
        }
        if (!keys.times.empty() && !(*time > keys.times.back())) {
            complain(when.place(),
                     fmt::format("a frame after {}, that of the key before it", keys.times.back()),
                     when);
            return false;
        }
        std::array<double, 3> value{};
        if (!read_key_value(param, what, width, value)) return false;
        keys.times.push_back(*time);
        for (std::size_t i = 0; i < width; ++i) keys.values[i].push_back(value[i]);
        return true;
    }

    bool read_key_value(const Param& param, const Json& what, std::size_t width,
                        std::array<double, 3>& value)
    {
        if (width == 1) {
            const std::optional<double> x = read_plain(param, what, true);
            if (x) value[0] = *x;
            return x.has_value();
        }
        if (param.kind == ParamKind::colour && what.text()) {
            if (const auto rgb = hex_colour(*what.text())) return value = *rgb, true;
        }
        if (!what.array() || what.array()->size() != width) {
            complain(what.place(), expectation_of(param), what);
            return false;
        }
        bool good = true;
        for (std::size_t i = 0; i < width; ++i) {
            const std::optional<double> x = read_plain(param, (*what.array())[i]);
            good = good && x;
            if (x) value[i] = *x;
        }
        return good;
    }

    std::optional<std::size_t> word(const Json& json, std::vector<std::string_view> words)
    {
        for (std::size_t i = 0; json.text() && i < words.size(); ++i) {
            if (*json.text() == words[i]) return i;
        }
        complain(json.place(), "one of " + list_names(words), json,
                 json.text() && !nearest(*json.text(), words).empty() ? suggest(*json.text(), words)
                                                                      : "");
        return {};
    }

    std::optional<double> add_curve(const Param& param, const Json& json, int component,
                                    std::vector<double> times, std::vector<double> values,
                                    const Keys& keys)
    {
        bool still = true;
        for (const double v : values) still = still && v == values[0];
        if (still) return values[0];
        Animated a = animated(param, json, component);
        auto curve = std::make_shared<const Curve>(
            curve_through(std::move(times), std::move(values), keys.between, keys.beyond));
        if (keys.seconds) {
            a.value = [curve](int, double time) { return curve->at(time); };
        } else {
            a.value = [curve](int frame, double) { return curve->at(frame); };
        }
        node_.animated.push_back(std::move(a));
        return {};
    }

    ParamValue read_choice(const Param& param, const Json& json)
    {
        if (json.text()) {
            for (const std::string& choice : param.choices) {
                if (choice == *json.text()) return {choice};
            }
        }
        const std::vector<std::string_view> names(param.choices.begin(), param.choices.end());
        const bool near = json.text() && !nearest(*json.text(), names).empty();
        complain(json.place(), expectation_of(param), json,
                 near ? suggest(*json.text(), names) : "");
        return param.fallback;
    }

    ParamValue read_list(const Param& param, const Json& json)
    {
        if (!json.array()) {
            complain(json.place(), expectation_of(param), json);
            return param.fallback;
        }
        ParamValues elements;
        for (std::size_t i = 0; i < json.array()->size(); ++i) {
            where_.push_back(static_cast<std::uint32_t>(i));
            names_.push_back(std::to_string(i));
            const Json& item = (*json.array())[i];
            if (!item.object()) complain(item.place(), "an object {...}", item);
            elements.push_back({read_struct(param.children, item.object() ? &item : nullptr)});
            names_.pop_back();
            where_.pop_back();
        }
        return {std::move(elements)};
    }

    // The frames of a sequence of files, "walk.####.obj"; none for the name of one file.
    static std::vector<int> sequence(const std::filesystem::path& pattern)
    {
        std::error_code error;
        const bool numbered = pattern.filename().string().find('#') != std::string::npos;
        if (!numbered || std::filesystem::exists(pattern, error)) return {};
        return frames_on_disk(pattern);
    }

    static std::filesystem::path file_of_frame(const std::filesystem::path& pattern, int frame,
                                               int first, int last,
                                               const std::filesystem::path& root)
    {
        const std::filesystem::path file = frame_path(pattern, frame);
        std::error_code error;
        if (!std::filesystem::is_regular_file(file, error)) {
            throw std::invalid_argument(
                fmt::format("there is no file {}; the sequence has files from frame {} to {}",
                            file.generic_string(), first, last));
        }
        if (!root.empty() && !lies_in(std::filesystem::canonical(file), root)) {
            throw std::invalid_argument(fmt::format("{} leads outside of the project's folder, {}",
                                                    file.generic_string(), root.generic_string()));
        }
        return file;
    }

    // The file as an absolute path; of a sequence the pattern, and one more entry in node.animated.
    ParamValue read_path_in(const Param& param, const Json& json)
    {
        namespace fs = std::filesystem;
        if (json.text()->empty()) return {std::string()};
        Problem p = problem(json.place());
        const fs::path path = (json.origin->source->folder() / *json.text()).lexically_normal();
        std::error_code error;
        const fs::path real = fs::weakly_canonical(path, error);
        if (!can_be_a_path(*json.text()) || error) {
            p.message = "this cannot be a path";
            p.found = json.snippet();
            if (!error) p.suggestion = "leave out control characters (tabs, line breaks)";
        } else if (!c_.paths.allow_outside && !lies_in(real, c_.paths.root)) {
            p.message = fmt::format("this leads outside of the project's folder, {}",
                                    c_.paths.root.generic_string());
            p.found = real == path
                          ? json.snippet()
                          : fmt::format("{}, which is {}", json.snippet(), real.generic_string());
            p.suggestion = "copy the file into the project, or allow files outside of it";
        } else if (const auto frames = sequence(path); !frames.empty()) {
            Animated a = animated(param, json, -1);
            a.file = [path, first = frames.front(), last = frames.back(),
                      root = c_.paths.allow_outside ? fs::path() : c_.paths.root](int frame) {
                return file_of_frame(path, frame, first, last, root);
            };
            node_.animated.push_back(std::move(a));
            return {path.generic_string()};
        } else if (!fs::exists(real, error)) {
            p.message = fmt::format("there is no file {}", path.generic_string());
            p.suggestion = suggest_file(path);
        } else if (fs::is_directory(real, error)) {
            p.expected = "a file";
            p.found = fmt::format("the folder {}", path.generic_string());
        } else {
            return {path.generic_string()};
        }
        c_.problems.add(std::move(p));
        return param.fallback;
    }

    ParamValue read_path_out(const Param& param, const Json& json)
    {
        namespace fs = std::filesystem;
        const fs::path path = fs::path(*json.text()).lexically_normal();
        const bool leaves = path.is_absolute() || (!path.empty() && *path.begin() == "..");
        if (!can_be_a_path(*json.text())) {
            complain(json.place(), "a path without control characters (tabs, line breaks)", json);
        } else if (leaves && !c_.paths.allow_outside) {
            complain(json.place(), "a path inside of the output folder", json);
        } else {
            return {path.generic_string()};
        }
        return param.fallback;
    }

    const ReadContext& c_;
    Node& node_;
    std::vector<std::uint32_t> where_;
    std::vector<std::string> names_;
};

}  // namespace

bool can_be_a_path(std::string_view text)
{
    return std::none_of(text.begin(), text.end(),
                        [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; });
}

bool lies_in(const std::filesystem::path& path, const std::filesystem::path& root)
{
    const auto [at, end] = std::mismatch(root.begin(), root.end(), path.begin(), path.end());
    return at == root.end() || (at->empty() && std::next(at) == root.end());
}

std::string suggest_file(const std::filesystem::path& path)
{
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path folder = path.parent_path();
    if (!fs::is_directory(folder, error)) {
        return fmt::format("there is no folder {} either", folder.generic_string());
    }
    const std::string name = path.filename().string(), stem = path.stem().string();
    std::vector<std::string> files, alike;  // alike: what could be meant, a file of this kind
    std::size_t looked_at = 0;
    for (fs::directory_iterator it(folder, error), end; !error && it != end && ++looked_at < 1000;
         it.increment(error)) {
        const std::string file = it->path().filename().string();
        if (file.starts_with('.')) continue;
        files.push_back(file);
        if (it->path().extension() == path.extension()) alike.push_back(file);
    }
    std::sort(files.begin(), files.end());
    std::sort(alike.begin(), alike.end());
    for (const std::string& file : files) {  // in a folder below
        if (fs::exists(folder / file / name, error)) {
            return fmt::format("did you mean '{}/{}'?", file, name);
        }
    }
    for (const std::string& file : files) {  // the same name in another format
        if (fs::path(file).stem() == stem) return fmt::format("did you mean '{}'?", file);
    }
    const std::vector<std::string>& told = alike.empty() ? files : alike;
    const std::vector<std::string_view> names(told.begin(), told.end());
    return names.empty() ? "its folder is empty" : suggest(name, names);
}

std::optional<double> read_constant(const Json& json, Problem& problem)
{
    if (const auto x = json.number()) return x;
    if (!is_expression(json)) {
        problem.found = json.snippet();
        return {};
    }
    const std::optional<Expression> e = compile(json, problem);
    if (!e) return {};
    if (!e->constant) {
        problem.message = "this number may not change with the frame";
        problem.found = json.snippet();
        return {};
    }
    if (!std::isfinite(*e->constant)) {
        problem.message =
            fmt::format("{} gives {}, no finite number", *json.text(), number_text(*e->constant));
        return {};
    }
    return e->constant;
}

void read_params(const Json* given, const ReadContext& context, Node& node)
{
    node.animated.clear();
    node.params = ParamReader(context, node).read_struct(node.type->params, given);
}

}  // namespace graph

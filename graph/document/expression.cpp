#include "graph/document/expression.hpp"

#include "graph/document/problem.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <optional>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <muParser.h>

namespace graph {

namespace {

// A hash of a lattice point to a slope in [-1, 1] (the finalizer of MurmurHash3).
double slope(std::int64_t i)
{
    auto h = static_cast<std::uint64_t>(i) + 0x9E3779B97F4A7C15u;
    h = (h ^ (h >> 33)) * 0xFF51AFD7ED558CCDu;
    h = (h ^ (h >> 33)) * 0xC4CEB9FE1A85EC53u;
    h ^= h >> 33;
    return static_cast<double>(h >> 11) * 0x1p-52 - 1;
}

double clamp(double x, double low, double high)
{
    return std::min(std::max(x, low), high);
}
double mix(double a, double b, double t)
{
    return a + (b - a) * t;
}
double step(double edge, double x)
{
    return x < edge ? 0 : 1;
}
double smoothstep(double from, double to, double x)
{
    if (!(from != to)) return step(from, x);
    const double t = clamp((x - from) / (to - from), 0, 1);
    return t * t * (3 - 2 * t);
}
// With the sign of b, so that a clock that runs into negative times goes on evenly.
double mod(double a, double b)
{
    return a - b * std::floor(a / b);
}
double fract(double x)
{
    return x - std::floor(x);
}
double sign(double x)
{
    return x > 0 ? 1 : x < 0 ? -1 : x;
}
double least(const double* v, int n)
{
    return *std::min_element(v, v + n);
}
double most(const double* v, int n)
{
    return *std::max_element(v, v + n);
}

using Of1 = double (*)(double);
using Of2 = double (*)(double, double);
using Of3 = double (*)(double, double, double);

constexpr std::pair<const char*, Of1> of_one[] = {
    {"sin", std::sin},
    {"cos", std::cos},
    {"tan", std::tan},
    {"asin", std::asin},
    {"acos", std::acos},
    {"atan", std::atan},
    {"sinh", std::sinh},
    {"cosh", std::cosh},
    {"tanh", std::tanh},
    {"exp", std::exp},
    {"log", std::log},
    {"log2", std::log2},
    {"log10", std::log10},
    {"sqrt", std::sqrt},
    {"cbrt", std::cbrt},
    {"abs", std::fabs},
    {"floor", std::floor},
    {"ceil", std::ceil},
    {"round", std::round},
    {"fract", fract},
    {"sign", sign},
    {"noise", noise},
    {"radians", [](double x) { return x * (std::numbers::pi / 180); }},
    {"degrees", [](double x) { return x * (180 / std::numbers::pi); }},
};
constexpr std::pair<const char*, Of2> of_two[] = {
    {"atan2", std::atan2}, {"pow", std::pow}, {"mod", mod}, {"step", step}, {"hypot", std::hypot},
};
constexpr std::pair<const char*, Of3> of_three[] = {
    {"clamp", clamp}, {"mix", mix}, {"smoothstep", smoothstep}};
constexpr std::pair<const char*, double (*)(const double*, int)> of_any[] = {{"min", least},
                                                                             {"max", most}};

std::vector<std::string_view> function_names()
{
    std::vector<std::string_view> names;
    for (const auto& f : of_one) names.emplace_back(f.first);
    for (const auto& f : of_two) names.emplace_back(f.first);
    for (const auto& f : of_three) names.emplace_back(f.first);
    for (const auto& f : of_any) names.emplace_back(f.first);
    return names;
}

std::vector<std::string_view> own_names()
{
    std::vector<std::string_view> names = function_names();
    names.insert(names.begin(), {"frame", "time", "fps", "pi"});
    return names;
}

// The position of an `=` that is no comparison: muparser would read it as an assignment.
std::size_t find_assignment(std::string_view text)
{
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (text[i] != '=') continue;
        if (i + 1 < text.size() && text[i + 1] == '=') {
            ++i;
        } else if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) {
            return i;
        }
    }
    return std::string_view::npos;
}

bool name_begins(std::string_view text, std::size_t i)
{
    return i < text.size() && (std::isalpha(static_cast<unsigned char>(text[i])) || text[i] == '_');
}

std::size_t name_end(std::string_view text, std::size_t i)
{
    while (name_begins(text, i) ||
           (i < text.size() && std::isdigit(static_cast<unsigned char>(text[i]))))
        ++i;
    return i;
}

// "m.value": the output of a node, which expressions can't see.
void refuse_outputs(std::string_view text)
{
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (!name_begins(text, i)) {
            if (text[i] != '.' && !std::isdigit(static_cast<unsigned char>(text[i]))) continue;
            // A number, "1.5e3", has letters of its own.
            while (i < text.size() &&
                   (text[i] == '.' || std::isalnum(static_cast<unsigned char>(text[i]))))
                ++i;
            --i;
            continue;
        }
        const std::size_t end = name_end(text, i);
        if (end < text.size() && text[end] == '.' && name_begins(text, end + 1)) {
            const std::size_t last = name_end(text, end + 1);
            throw ExpressionError(fmt::format("an expression can't read the output '{}' of a node",
                                              text.substr(i, last - i)),
                                  i,
                                  "use a variable of the document for both, or link the output to "
                                  "an input");
        }
        i = end - 1;
    }
}

// "$F": Houdini's way to say the number of the frame.
ExpressionError unknown_dollar(std::string_view text, std::size_t i)
{
    const std::string_view name = text.substr(i, name_end(text, i + 1) - i);
    return {fmt::format("unknown name '{}'", name), i,
            name.starts_with("$T") ? "the time is 'time', in seconds"
                                   : "the number of the frame is 'frame'"};
}

}  // namespace

double noise(double x)
{
    if (!(std::fabs(x) < 0x1p53)) return 0;  // beyond it every double is a whole number
    const double below = std::floor(x), t = x - below;
    const auto i = static_cast<std::int64_t>(below);
    const double a = slope(i) * t, b = slope(i + 1) * (t - 1);
    // Quintic fade; a and b reach 0.5 half-way at the most, so twice the mix stays in [-1, 1].
    return 2 * (a + (b - a) * (t * t * t * (t * (6 * t - 15) + 10)));
}

struct Grammar::Parser {
    mu::Parser mu;
    double frame = 0, time = 0;
    std::mutex turn;  // muparser evaluates into buffers of its own

    Parser()
    {
        mu.ClearFun();
        mu.ClearConst();
        for (const auto& f : of_one) mu.DefineFun(f.first, f.second);
        for (const auto& f : of_two) mu.DefineFun(f.first, f.second);
        for (const auto& f : of_three) mu.DefineFun(f.first, f.second);
        for (const auto& f : of_any) mu.DefineFun(f.first, f.second);
        mu.DefineConst("pi", std::numbers::pi);
        bind();
    }
    explicit Parser(const Parser& like) : mu(like.mu) { bind(); }

    void read(const std::string& text)
    {
        // Where muparser folds constants, it cuts the operands of && and || to whole numbers:
        // 0.5 && 1 would be 0.
        const auto has = [&text](const char* part) { return text.find(part) != text.npos; };
        mu.EnableOptimizer(!has("&&") && !has("||"));
        mu.SetExpr(text);
    }

    double at(int f, double t)
    {
        const std::lock_guard lock(turn);
        frame = f;
        time = t;
        return mu.Eval();
    }

private:
    void bind()
    {
        mu.ClearVar();
        mu.DefineVar("frame", &frame);
        mu.DefineVar("time", &time);
    }
};

Grammar::Grammar() : parser_(std::make_unique<Parser>()) {}

void Grammar::define(const std::string& name, double value)
{
    parser_->mu.DefineConst(name, value);
    variables_.push_back(name);
    std::erase(announced_, name);
}

Grammar::~Grammar() = default;

bool Grammar::free_name(std::string_view name)
{
    if (name.empty() || name.size() > 64) return false;
    if (!std::isalpha(static_cast<unsigned char>(name[0])) && name[0] != '_') return false;
    for (const char c : name) {
        if (!std::isalnum(static_cast<unsigned char>(c)) && c != '_') return false;
    }
    const auto taken = own_names();
    return std::find(taken.begin(), taken.end(), name) == taken.end();
}

ExpressionError Grammar::unknown(std::string name, std::size_t position) const
{
    name = name.substr(0, name.find_last_not_of(" \t\r\n") + 1);
    if (std::find(announced_.begin(), announced_.end(), name) != announced_.end()) {
        return {fmt::format("variable '{}' has no value here yet", name), position,
                "define it before the variables that use it"};
    }
    std::vector<std::string_view> names = own_names();
    names.insert(names.end(), variables_.begin(), variables_.end());
    std::erase(names, name);  // fps, where the document still has to say it
    std::string help = nearest(name, names);
    if (help.empty()) {
        names = {"frame", "time", "pi"};
        names.insert(names.end(), variables_.begin(), variables_.end());
        help = fmt::format("available: {}, and functions", list_names(names));
    } else {
        help = fmt::format("did you mean '{}'?", help);
    }
    return {fmt::format("unknown name '{}'", name), position, std::move(help)};
}

namespace {

void check_text(const std::string& text)
{
    if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
        throw ExpressionError("the expression is empty", 0, {});
    }
    if (text.size() > 4000) {
        throw ExpressionError("the expression is longer than the limit of 4000 characters", 0, {});
    }
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto c = static_cast<unsigned char>(text[i]);
        if (c == '$') throw unknown_dollar(text, i);
        if (c >= 128 || (c < 32 && !std::isspace(c)) || c == '"' || c == '\'' || c == '#') {
            throw ExpressionError("this character is not allowed in an expression", i, {});
        }
    }
    refuse_outputs(text);
    if (const auto at = find_assignment(text); at != std::string_view::npos) {
        throw ExpressionError("assignment is not allowed in an expression", at,
                              "use == to compare");
    }
}

void require_one_number(const mu::Parser& mu)
{
    if (mu.GetNumResults() == 1) return;
    throw ExpressionError("expected one number, found several", 0,
                          "commas only separate function arguments");
}

// The first name before a parenthesis that is no function's. muparser tells the parenthesis.
std::optional<ExpressionError> unknown_function(const std::string& text)
{
    const auto of_name = [&](std::size_t i) {
        return std::isalnum(static_cast<unsigned char>(text[i])) || text[i] == '_';
    };
    const std::vector<std::string_view> functions = function_names();
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (!of_name(i)) continue;
        const std::size_t begin = i;
        while (i < text.size() && of_name(i)) ++i;
        const std::string name = text.substr(begin, i - begin);
        const std::size_t next = text.find_first_not_of(" \t\r\n", i);
        if (next == std::string::npos || text[next] != '(') continue;
        if (std::isdigit(static_cast<unsigned char>(name[0]))) continue;
        if (std::find(functions.begin(), functions.end(), name) != functions.end()) continue;
        const std::string near = nearest(name, functions);
        return ExpressionError(fmt::format("there is no function '{}'", name), begin,
                               near.empty() ? fmt::format("the functions are {}",
                                                          list_names(functions, functions.size()))
                                            : fmt::format("did you mean '{}'?", near));
    }
    return {};
}

// muparser's own words for what is wrong.
ExpressionError translated(const mu::Parser::exception_type& e, const std::string& text)
{
    if (const auto function = unknown_function(text)) return *function;
    const auto at = static_cast<std::size_t>(std::max(e.GetPos(), 0));
    std::string what = e.GetMsg();
    while (!what.empty() && (what.back() == '.' || what.back() == '\n')) what.pop_back();
    return {what, std::min(at, text.size()), {}};
}

}  // namespace

Expression Grammar::compile(const std::string& text) const
{
    check_text(text);
    try {
        mu::Parser& mu = parser_->mu;
        parser_->read(text);
        const auto used = mu.GetUsedVar();  // also parses
        for (const auto& [name, address] : used) {
            if (name == "frame" || name == "time") continue;
            const auto at = text.find(name);
            throw unknown(name, at == std::string::npos ? 0 : at);
        }
        const double now = parser_->at(1, 0);
        require_one_number(mu);
        if (used.empty()) return {now, [now](int, double) { return now; }};
        auto own = std::make_shared<Parser>(*parser_);
        own->read(text);
        own->at(1, 0);  // compiles
        return {{}, [own](int frame, double time) { return own->at(frame, time); }};
    } catch (const mu::Parser::exception_type& e) {
        if (e.GetCode() == mu::ecUNASSIGNABLE_TOKEN && !e.GetToken().empty()) {
            const auto at = static_cast<std::size_t>(std::max(e.GetPos(), 0));
            throw unknown(e.GetToken(), std::min(at, text.size()));
        }
        throw translated(e, text);
    }
}

FunctionOf Grammar::compile_of(const std::string& text, const std::vector<std::string>& names) const
{
    check_text(text);
    auto own = std::make_shared<Parser>(*parser_);
    auto values = std::make_shared<std::vector<double>>(names.size(), 0.0);
    own->mu.ClearVar();
    try {
        for (std::size_t i = 0; i < names.size(); ++i) own->mu.DefineVar(names[i], &(*values)[i]);
        own->read(text);
        for (const auto& [name, address] : own->mu.GetUsedVar()) {
            if (address) continue;
            throw ExpressionError(
                fmt::format("unknown name '{}'", name), text.find(name),
                fmt::format("available: {}, and functions", fmt::join(names, ", ")));
        }
        own->mu.Eval();
        require_one_number(own->mu);
    } catch (const mu::Parser::exception_type& e) {
        throw translated(e, text);
    }
    return [own, values](std::span<const double> given) {
        std::copy_n(given.begin(), values->size(), values->begin());
        return own->mu.Eval();
    };
}

}  // namespace graph

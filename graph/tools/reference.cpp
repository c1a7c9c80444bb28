#include "graph/tools/reference.hpp"

#include "graph/document/problem.hpp"
#include "graph/types/registry.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace graph {

namespace {

const char* kind_text(ParamKind kind)
{
    switch (kind) {
    case ParamKind::boolean:
        return "true or false";
    case ParamKind::integer:
        return "whole number";
    case ParamKind::number:
        return "number";
    case ParamKind::vector:
        return "vector";
    case ParamKind::colour:
        return "colour";
    case ParamKind::text:
        return "text";
    case ParamKind::choice:
        return "choice";
    case ParamKind::path_in:
        return "file to read";
    case ParamKind::path_out:
        return "file to write";
    case ParamKind::list:
        return "list";
    case ParamKind::block:
        return "block";
    }
    return "";
}

// A parameter as one row: blocks and lists first name themselves, then what is in them.
struct Row {
    std::string name, kind, fallback, range, doc;
};

std::string range_of(const Param& p)
{
    if (p.kind == ParamKind::choice) return fmt::format("{}", fmt::join(p.choices, ", "));
    if (!p.numeric() || p.kind == ParamKind::colour) return {};
    const bool low = p.limits.min > -2147483648.0, high = p.limits.max < 2147483647.0;
    std::string text;
    if (low && high) text = fmt::format("{} to {}", p.limits.min, p.limits.max);
    if (low && !high) text = fmt::format("from {}", p.limits.min);
    if (!low && high) text = fmt::format("to {}", p.limits.max);
    if (p.limits.unit.empty()) return text;
    return text + (text.empty() ? "" : " ") + p.limits.unit;
}

void add_rows(const std::vector<Param>& params, const std::string& prefix, std::vector<Row>& rows)
{
    for (const Param& p : params) {
        Row row{prefix + p.name, kind_text(p.kind), value_text(p.fallback), range_of(p), p.doc};
        if (!p.shown_when.param.empty()) {
            row.doc += fmt::format(" Only while {}{} is {}.", prefix, p.shown_when.param,
                                   fmt::join(p.shown_when.values, " or "));
        }
        const bool nests = p.kind == ParamKind::block || p.kind == ParamKind::list;
        if (nests) row.fallback = p.kind == ParamKind::list ? "[]" : "";
        rows.push_back(std::move(row));
        if (nests) {
            add_rows(p.children, prefix + p.name + (p.kind == ParamKind::list ? "[]." : "."), rows);
        }
    }
}

std::vector<Row> rows_of(const NodeType& type)
{
    std::vector<Row> rows;
    add_rows(type.params, "", rows);
    return rows;
}

const char* links_text(const InputPort& port)
{
    if (port.many) return port.optional ? "any number of links" : "one link or more";
    if (port.gather) return "one link, read at several frames";
    return port.optional ? "optional" : "required";
}

// Text that stands in a cell of a Markdown table.
std::string cell(const std::string& text)
{
    std::string out;
    for (const char c : text) {
        if (c == '|') out += '\\';
        out += c == '\n' ? ' ' : c;
    }
    return out;
}

std::string code(const std::string& text)
{
    return text.empty() ? "" : fmt::format("`{}`", cell(text));
}

// Words of `text` in lines of at most `width`, each but the first indented.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t width)
{
    std::string out;
    std::size_t column = indent;
    for (std::size_t i = 0; i < text.size();) {
        const std::size_t begin = text.find_first_not_of(" \n", i);
        if (begin == std::string::npos) break;
        const std::size_t end = std::min(text.find_first_of(" \n", begin), text.size());
        if (column > indent && column + 1 + (end - begin) > width) {
            out += "\n" + std::string(indent, ' ');
            column = indent;
        } else if (column > indent) {
            out += ' ';
            ++column;
        }
        out.append(text, begin, end - begin);
        column += end - begin;
        i = end;
    }
    return out;
}

}  // namespace

std::string value_text(const ParamValue& value)
{
    if (const auto* b = std::get_if<bool>(&value.is)) return *b ? "true" : "false";
    if (const auto* i = std::get_if<std::int64_t>(&value.is)) return std::to_string(*i);
    if (const auto* d = std::get_if<double>(&value.is)) return fmt::format("{}", *d);
    if (const auto* s = std::get_if<std::string>(&value.is)) {
        return nlohmann::json(*s).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    }
    if (const auto* v = std::get_if<std::array<double, 3>>(&value.is)) {
        return fmt::format("[{}, {}, {}]", (*v)[0], (*v)[1], (*v)[2]);
    }
    if (const auto* list = std::get_if<ParamValues>(&value.is)) {
        std::string text = "[";
        for (const ParamValue& element : *list) {
            text += (text.size() > 1 ? ", " : "") + value_text(element);
        }
        return text + "]";
    }
    return {};
}

std::string reference_page(const Registry& registry)
{
    std::string page = "# Nodes\n\nWritten from the descriptions in `nodes/` by `aspic nodes "
                       "--markdown`. How a document names inputs and parameters: "
                       "[file-format.md](file-format.md).\n\n| node | what it does |\n|---|---|\n";
    for (const auto& [name, type] : registry.types()) {
        std::string anchor = name;
        std::transform(anchor.begin(), anchor.end(), anchor.begin(),
                       [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
        page += fmt::format("| [{}](#{}) | {} |\n", name, anchor, cell(type.summary));
    }
    for (const auto& [name, type] : registry.types()) {
        page +=
            fmt::format("\n## {}\n\n{}\n\nType `{}@{}`.", name, type.summary, name, type.version);
        if (type.sink) page += " Writes files: cooked without being asked for.";
        if (!type.previous.empty()) page += " Remembers its own result of the frame before.";
        page += "\n";
        if (!type.inputs.empty()) {
            page += "\n| input | wire | links | what |\n|---|---|---|---|\n";
            for (const InputPort& port : type.inputs) {
                page += fmt::format("| `{}` | {} | {} | {} |\n", port.name, port.type,
                                    links_text(port), cell(port.doc));
            }
        }
        if (!type.outputs.empty()) {
            page += "\n| output | wire | what |\n|---|---|---|\n";
            for (const OutputPort& port : type.outputs) {
                page += fmt::format("| `{}` | {} | {} |\n", port.name, port.type, cell(port.doc));
            }
        }
        if (!type.params.empty()) {
            page += "\n| parameter | kind | default | range | what |\n|---|---|---|---|---|\n";
            for (const Row& row : rows_of(type)) {
                page += fmt::format("| `{}` | {} | {} | {} | {} |\n", row.name, row.kind,
                                    code(row.fallback), cell(row.range), cell(row.doc));
            }
        }
    }
    return page;
}

std::string reference_text(const NodeType& type, int width)
{
    const auto columns = static_cast<std::size_t>(std::max(width, 40));
    std::vector<Row> inputs, outputs;
    for (const InputPort& p : type.inputs) {
        inputs.push_back({p.name, p.type, "", links_text(p), p.doc});
    }
    for (const OutputPort& p : type.outputs) outputs.push_back({p.name, p.type, "", "", p.doc});
    const std::vector<Row> params = rows_of(type);

    std::string text = fmt::format("{}@{}  {}\n", type.name, type.version,
                                   wrapped(type.summary, type.name.size() + 4, columns));
    const auto section = [&](const char* title, const std::vector<Row>& rows) {
        if (rows.empty()) return;
        text += fmt::format("\n{}\n", title);
        for (const Row& row : rows) {
            std::string head = fmt::format("{} ({}", row.name, row.kind);
            if (!row.range.empty()) head += ", " + row.range;
            if (!row.fallback.empty()) head += "; default " + row.fallback;
            text += "  " + wrapped(head + ")", 2, columns) + "\n";
            text += "      " + wrapped(row.doc, 6, columns) + "\n";
        }
    };
    section("inputs", inputs);
    section("outputs", outputs);
    section("parameters", params);
    return text;
}

namespace {

bool speaks_of(const std::string& text, std::string_view word)
{
    return std::search(text.begin(), text.end(), word.begin(), word.end(), [](char a, char b) {
               return std::tolower(static_cast<unsigned char>(a)) ==
                      std::tolower(static_cast<unsigned char>(b));
           }) != text.end();
}

bool speaks_of(const NodeType& type, std::string_view word)
{
    return speaks_of(type.name, word) || speaks_of(type.summary, word) ||
           std::any_of(type.synonyms.begin(), type.synonyms.end(),
                       [&](const std::string& s) { return speaks_of(s, word); });
}

// "sphere.radius": parameters that speak of the word, those in blocks included.
void add_params(const std::vector<Param>& params, const std::string& before, std::string_view word,
                std::vector<std::string>& names)
{
    for (const Param& p : params) {
        const bool said = speaks_of(p.name, word) || speaks_of(p.doc, word) ||
                          std::any_of(p.choices.begin(), p.choices.end(),
                                      [&](const std::string& c) { return speaks_of(c, word); });
        if (said) names.push_back(before + p.name);
        add_params(p.children, before + p.name + ".", word, names);
    }
}

std::vector<std::string> parts_that_speak_of(const NodeType& type, std::string_view word)
{
    std::vector<std::string> names;
    for (const InputPort& port : type.inputs) {
        if (speaks_of(port.name, word) || speaks_of(port.doc, word)) names.push_back(port.name);
    }
    for (const OutputPort& port : type.outputs) {
        if (speaks_of(port.name, word) || speaks_of(port.doc, word)) names.push_back(port.name);
    }
    add_params(type.params, "", word, names);
    return names;
}

}  // namespace

std::string reference_list(const Registry& registry, std::string_view word)
{
    std::size_t longest = 0;
    for (const auto& [name, type] : registry.types()) longest = std::max(longest, name.size());
    std::string text, others;
    for (const auto& [name, type] : registry.types()) {
        if (speaks_of(type, word)) {
            text += fmt::format("{:{}}  {}\n", name, longest, type.summary);
        } else if (const auto parts = parts_that_speak_of(type, word); !parts.empty()) {
            others += fmt::format("{:{}}  {}\n", name, longest, fmt::join(parts, ", "));
        }
    }
    return text + others;
}

}  // namespace graph

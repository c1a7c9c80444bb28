#include "runtime/cook/key_parts.hpp"

#include <algorithm>
#include <array>

namespace runtime {

using graph::Param;
using graph::ParamKind;
using graph::ParamValue;
using graph::ParamValues;

ParamValue& animated_value(ParamValues& values, const std::vector<std::uint32_t>& where)
{
    ParamValue* value = &values.at(where.at(0));
    for (std::size_t i = 1; i < where.size(); ++i) {
        value = &std::get<ParamValues>(value->is).at(where[i]);
    }
    return *value;
}

ParamValues without_animated(const graph::Node& node)
{
    ParamValues params = node.params;
    for (const graph::Animated& a : node.animated) {
        ParamValue& value = animated_value(params, a.where);
        if (a.component < 0) {
            value = {};
        } else {
            std::get<std::array<double, 3>>(value.is)[static_cast<std::size_t>(a.component)] = 0;
        }
    }
    return params;
}

bool has_path_in(const std::vector<Param>& params)
{
    return std::any_of(params.begin(), params.end(), [](const Param& p) {
        return p.kind == ParamKind::path_in || has_path_in(p.children);
    });
}

void add_file(KeyBuilder& builder, const std::string& text, FileDigests& files)
{
    const std::filesystem::path path(text);
    const Key digest = text.empty() ? Key{} : files.of(path);
    builder.add(path.extension().generic_string()).add(digest);
    // What is not there may be a pattern ("mesh.####.obj"): its name has to do.
    if (!digest) builder.add(path.filename().generic_string());
}

void add_param(KeyBuilder& builder, const Param& param, const ParamValue& value, FileDigests& files)
{
    const auto* nested = std::get_if<ParamValues>(&value.is);
    if (param.kind == ParamKind::path_in && std::holds_alternative<std::string>(value.is)) {
        add_file(builder, std::get<std::string>(value.is), files);
    } else if (param.kind == ParamKind::list && nested) {
        builder.add(nested->size());
        for (const ParamValue& element : *nested) {
            const auto& members = std::get<ParamValues>(element.is);
            for (std::size_t i = 0; i < members.size(); ++i) {
                add_param(builder, param.children.at(i), members[i], files);
            }
        }
    } else if (param.kind == ParamKind::block && nested) {
        for (std::size_t i = 0; i < nested->size(); ++i) {
            add_param(builder, param.children.at(i), (*nested)[i], files);
        }
    } else {
        builder.add(value);
    }
}

const std::string* first_path(const std::vector<Param>& params, const ParamValues& values)
{
    for (std::size_t i = 0; i < params.size(); ++i) {
        if (params[i].kind == ParamKind::path_in) {
            const auto* text = std::get_if<std::string>(&values.at(i).is);
            if (text && !text->empty()) return text;
        }
        const auto* nested = std::get_if<ParamValues>(&values.at(i).is);
        if (!nested) continue;
        if (params[i].kind == ParamKind::block) {
            if (const auto* found = first_path(params[i].children, *nested)) return found;
        } else if (params[i].kind == ParamKind::list) {
            for (const ParamValue& element : *nested) {
                const auto& members = std::get<ParamValues>(element.is);
                if (const auto* found = first_path(params[i].children, members)) return found;
            }
        }
    }
    return nullptr;
}

}  // namespace runtime

#include "geometry/cubes/assign_matter.hpp"

#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {
namespace {

Vec3f face_colour(const TriMesh& mesh, std::size_t f)
{
    const MeshTopology& topology = *mesh.topology;
    if (mesh.colours.size() == mesh.positions.size() && !mesh.colours.empty()) {
        const auto& [a, b, c] = topology.triangles[f];
        if (std::max({a, b, c}) < mesh.colours.size()) {
            return (mesh.colours[a] + mesh.colours[b] + mesh.colours[c]) / 3;
        }
    }
    const std::size_t m = f < topology.material.size() ? topology.material[f] : 0;
    return m < topology.materials.size() ? topology.materials[m].colour : Material{}.colour;
}

}  // namespace

bool matches(const std::string& text, const std::string& pattern)
{
    // Greedy with one step back: a later star makes an earlier one's choice final.
    std::size_t t = 0, p = 0, star = std::string::npos, resume = 0;
    while (t < text.size()) {
        if (p < pattern.size() && pattern[p] == '*') {
            star = p++;
            resume = t;
        } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == text[t])) {
            ++p, ++t;
        } else if (star != std::string::npos) {
            p = star + 1;
            t = ++resume;
        } else {
            return false;
        }
    }
    while (p < pattern.size() && pattern[p] == '*') ++p;
    return p == pattern.size();
}

void check(const Matter& m)
{
    const auto wrong = [&](const char* what, double value, const char* expected) {
        throw std::invalid_argument("matter \"" + m.name + "\": " + what + ": expected " +
                                    expected + ", found " + fmt::format("{:.6g}", value));
    };
    const auto positive = [](double v) { return v > 0 && std::isfinite(v); };
    if (!positive(m.density)) wrong("density", m.density, "positive (kg/m^3)");
    if (!positive(m.young)) wrong("Young's modulus", m.young, "positive (Pa)");
    if (!(m.poisson >= 0 && m.poisson < 0.5)) wrong("Poisson ratio", m.poisson, "in 0 .. 0.4999");
    if (!(m.mass_damping >= 0)) wrong("mass damping", m.mass_damping, "0 or more (1/s)");
    if (!(m.stiffness_damping >= 0)) {
        wrong("stiffness damping", m.stiffness_damping, "0 or more (s)");
    }
}

FaceMatter matter_of_some(const FaceMatter& all, std::span<const std::uint32_t> faces)
{
    FaceMatter out{{}, all.matters, {}};
    for (const auto f : faces) {
        if (!all.face.empty()) out.face.push_back(all.face[f]);
    }
    return out;
}

FaceMatter assign_matter(const TriMesh& mesh, std::span<const MatterRule> rules,
                         const Matter& fallback)
{
    if (rules.size() > 65000) throw std::invalid_argument("more than 65,000 rules");
    check(fallback);
    for (const MatterRule& rule : rules) check(rule.matter);

    const MeshTopology& topology = *mesh.topology;
    const std::size_t faces = topology.triangles.size();
    std::vector<std::string> material_names;
    for (const Material& m : topology.materials) material_names.push_back(m.name);

    std::vector<std::uint16_t> rule_of(faces, 0);  // 0: fallback, else rule + 1
    FaceMatter out;
    for (std::size_t r = 0; r < rules.size(); ++r) {
        const MatterRule& rule = rules[r];
        // Names repeat over thousands of faces: match each one once.
        const std::vector<std::string>& names =
            rule.match == MatterRule::Match::group ? topology.groups : material_names;
        const std::vector<std::uint16_t>& index =
            rule.match == MatterRule::Match::group ? topology.group : topology.material;
        std::vector<std::uint8_t> named(names.size() + 1);
        for (std::size_t n = 0; n < names.size(); ++n) named[n] = matches(names[n], rule.name);
        named.back() = matches("", rule.name);

        const auto applies = [&](std::size_t f) {
            if (rule.match == MatterRule::Match::all) return true;
            if (rule.match == MatterRule::Match::colour) {
                return (face_colour(mesh, f) - rule.colour).cwiseAbs().maxCoeff() <= rule.tolerance;
            }
            const std::size_t n = f < index.size() ? index[f] : 0;
            return named[std::min(n, names.size())] != 0;
        };
        bool idle = true;
        for (std::size_t f = 0; f < faces; ++f) {
            if (!applies(f)) continue;
            rule_of[f] = static_cast<std::uint16_t>(r + 1);
            idle = false;
        }
        if (idle) out.idle.push_back(r);
    }

    std::vector<std::uint8_t> used(rules.size() + 1, 0);
    for (const std::uint16_t r : rule_of) used[r] = 1;
    if (faces == 0) used[0] = 1;
    std::vector<std::uint16_t> number(used.size(), 0);
    for (std::size_t r = 0; r < used.size(); ++r) {
        if (!used[r]) continue;
        number[r] = static_cast<std::uint16_t>(out.matters.size());
        out.matters.push_back(r == 0 ? fallback : rules[r - 1].matter);
    }
    if (out.matters.size() > 1) {
        out.face.resize(faces);
        for (std::size_t f = 0; f < faces; ++f) out.face[f] = number[rule_of[f]];
    }
    return out;
}

}  // namespace geometry

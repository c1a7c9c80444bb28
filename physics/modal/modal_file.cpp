#include "physics/modal/modal_file.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <numbers>
#include <stdexcept>

namespace physics {
namespace {

using geometry::Triangle;
using geometry::TriMesh;

// Words of the file, one after the other.
class Words {
public:
    explicit Words(std::string_view rest) : rest_(rest) {}

    std::string_view next()
    {
        while (!rest_.empty() && (is_space(rest_[0]) || rest_[0] == '#')) {
            const bool comment = rest_[0] == '#';
            const std::size_t line_end = std::min(rest_.find('\n'), rest_.size());
            const std::size_t skip = comment ? line_end : 1;
            line_ += !comment && rest_[0] == '\n' ? 1 : 0;
            rest_.remove_prefix(skip);
        }
        std::size_t n = 0;
        while (n < rest_.size() && !is_space(rest_[n])) ++n;
        const std::string_view word = rest_.substr(0, n);
        rest_.remove_prefix(n);
        return word;
    }
    void expect(std::string_view word)
    {
        if (const std::string_view found = next(); found != word) refuse(word, found);
    }
    double number(std::string_view what)
    {
        const std::string_view word = next();
        double value = 0;
        const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value);
        const bool whole = error == std::errc() && stop == word.data() + word.size();
        if (!whole || !std::isfinite(value)) refuse(what, word);
        return value;
    }
    double at_least(double least, std::string_view what)
    {
        const double value = number(what);
        if (!(value >= least)) refuse(what, fmt::format("{:g}", value));
        return value;
    }
    std::size_t count(std::string_view what)
    {
        const double value = at_least(0, what);
        if (value > 4e9 || value != std::floor(value)) refuse(what, fmt::format("{:g}", value));
        return static_cast<std::size_t>(value);
    }
    std::size_t bytes_left() const { return rest_.size(); }

    [[noreturn]] void refuse(std::string_view expected, std::string_view found) const
    {
        throw std::runtime_error(
            fmt::format("line {}: expected {}, found {}", line_, expected,
                        found.empty() ? "the end" : fmt::format("\"{}\"", found.substr(0, 40))));
    }

private:
    static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

    std::string_view rest_;
    std::size_t line_ = 1;
};

// Of each normal, the sum of its faces' normals, weighted by their areas.
std::vector<Vec3> face_normals(const TriMesh& mesh, const std::vector<Vec3>& x)
{
    std::vector<Vec3> sum(mesh.normals.size(), Vec3::Zero());
    const auto& corners = mesh.topology->normal_triangles;
    for (std::size_t f = 0; f < corners.size(); ++f) {
        const Triangle& t = mesh.triangles()[f];
        const Vec3 area = (x[t[1]] - x[t[0]]).cross(x[t[2]] - x[t[0]]);
        for (const std::uint32_t n : corners[f]) {
            if (n < sum.size()) sum[n] += area;
        }
    }
    for (Vec3& n : sum) {
        const double length = n.norm();
        n = length > 0 ? Vec3(n / length) : Vec3(Vec3::Zero());
    }
    return sum;
}

// How normals change with the coordinate of a mode, where it moves no vertex by more than a
// thousandth of the mesh.
std::vector<Vec3f> normal_change(const TriMesh& mesh, const std::vector<Vec3f>& shape)
{
    std::vector<Vec3f> change(mesh.normals.size(), Vec3f::Zero());
    double largest = 0;
    for (const Vec3f& s : shape) largest = std::max(largest, double(s.norm()));
    if (!(largest > 0) || change.empty()) return change;
    const double small = 1e-3 * geometry::bounds(mesh).size().maxCoeff() / largest;
    std::vector<Vec3> rest, moved;
    for (std::size_t i = 0; i < shape.size(); ++i) {
        rest.emplace_back(mesh.positions[i].cast<double>());
        moved.emplace_back(rest.back() + small * shape[i].cast<double>());
    }
    const std::vector<Vec3> before = face_normals(mesh, rest), after = face_normals(mesh, moved);
    for (std::size_t i = 0; i < change.size(); ++i) {
        change[i] = ((after[i] - before[i]) / small).cast<float>();
    }
    return change;
}

}  // namespace

std::string modal_file(const ModalModel& model)
{
    std::string out = fmt::format("aspic-modes 1\nvertices {}\nmodes {}\n",
                                  model.rest->positions.size(), model.count());
    const auto put = [&out](const auto& v) {
        fmt::format_to(std::back_inserter(out), "{} {} {}\n", v.x(), v.y(), v.z());
    };
    for (std::size_t k = 0; k < model.count(); ++k) {
        const double frequency = std::sqrt(model.omega_sq[k]) / (2 * std::numbers::pi);
        out += fmt::format("mode {} {} 1  ", frequency, model.damping[k]);
        put(model.participation[k]);
        for (const Vec3f& s : model.shape[k]) put(s);
    }
    return out;
}

ModalModel read_modal_file(std::string_view bytes, std::shared_ptr<const TriMesh> mesh)
{
    Words words(bytes);
    words.expect("aspic-modes");
    words.expect("1");
    words.expect("vertices");
    const std::size_t vertices = words.count("their number");
    if (vertices != mesh->positions.size()) {
        throw std::runtime_error(
            fmt::format("expected modes of the {} vertices of the mesh, found modes of {}",
                        mesh->positions.size(), vertices));
    }
    words.expect("modes");
    const std::size_t modes = words.count("their number");
    ModalModel model;
    for (std::size_t k = 0; k < modes; ++k) {
        words.expect("mode");
        const double omega = 2 * std::numbers::pi * words.at_least(0, "a frequency of 0 or more");
        model.omega_sq.push_back(omega * omega);
        model.damping.push_back(words.at_least(0, "a damping of 0 or more"));
        const double mass = words.at_least(1e-300, "a modal mass above 0");
        const double scale = 1 / std::sqrt(mass);
        const auto vector = [&words](const char* what) {
            const double x = words.number(what), y = words.number(what), z = words.number(what);
            return Vec3(x, y, z);
        };
        model.participation.emplace_back(scale * vector("a sum of mass times shape"));
        // Each vertex takes six bytes at least: what a wrong number announces is not reserved.
        if (vertices > words.bytes_left() / 5) words.refuse("more vertices", "");
        std::vector<Vec3f> shape;
        shape.reserve(vertices);
        for (std::size_t i = 0; i < vertices; ++i) {
            shape.emplace_back((scale * vector("the shape at a vertex")).cast<float>());
        }
        model.normal_change.push_back(normal_change(*mesh, shape));
        model.shape.push_back(std::move(shape));
    }
    if (const std::string_view more = words.next(); !more.empty()) words.refuse("the end", more);
    model.rest = std::move(mesh);
    model.mark = mark_of(model);
    return model;
}

}  // namespace physics

#include "geometry/io/file_vertices.hpp"

#include "geometry/base/no_index.hpp"
#include "geometry/base/numbering.hpp"
#include "geometry/base/stop.hpp"
#include "geometry/io/mesh_text.hpp"
#include "geometry/mesh/mesh.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

namespace geometry {
namespace {

bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\r';
}

// The three numbers that a line goes on with. False: it does not.
bool read_numbers(std::string_view line, Vec3f& out)
{
    const char *at = line.data(), *const end = line.data() + line.size();
    for (int d = 0; d < 3; ++d) {
        while (at != end && is_blank(*at)) ++at;
        if (at != end && *at == '+') ++at;
        double value = 0;
        const auto [stop, error] = number_from(at, end, value);
        if (error != std::errc()) return false;
        out[d] = static_cast<float>(value);
        at = stop;
    }
    return true;
}

// Finite positions, to find those near a place: the first of those in one place, in cells that are
// much wider than what is near.
class Places {
public:
    explicit Places(std::span<const Vec3f> positions) : positions_(positions)
    {
        Box box;
        for (const Vec3f& p : positions) box.add(p.cast<double>());
        low_ = box.lo;
        reach_ = std::max(1e-6 * box.diagonal(), 1e-30);
        Numbering<3> distinct;
        std::vector<std::uint32_t> firsts;
        next_.assign(positions.size(), no_index);
        for (std::uint32_t i = 0; i < positions.size(); ++i) {
            const std::uint32_t number = distinct.add(bits(positions[i]));
            if (number == firsts.size()) {
                firsts.push_back(i);
                chain(i);
            }
            first_.push_back(firsts[number]);
        }
    }

    // The first at the same place.
    std::uint32_t first(std::size_t i) const { return first_[i]; }

    // The nearest one; no_index: none is near.
    std::uint32_t nearest(const Vec3f& p)
    {
        const Vec3 at = p.cast<double>() - low_;
        const auto lowest = cell(at.array() - reach_), highest = cell(at.array() + reach_);
        double best = reach_ * reach_;
        std::uint32_t found = no_index;
        for (std::uint32_t x = lowest[0]; x <= highest[0]; ++x) {
            for (std::uint32_t y = lowest[1]; y <= highest[1]; ++y) {
                for (std::uint32_t z = lowest[2]; z <= highest[2]; ++z) {
                    look({x, y, z}, p, best, found);
                }
            }
        }
        return found;
    }

private:
    using Cell = Numbering<3>::Key;

    Cell cell(const Vec3& at) const
    {
        const Vec3 c = (at / (64 * reach_)).array().floor().max(0).min(1e9);
        return {static_cast<std::uint32_t>(c[0]), static_cast<std::uint32_t>(c[1]),
                static_cast<std::uint32_t>(c[2])};
    }
    void chain(std::uint32_t i)
    {
        const std::uint32_t number = cells_.add(cell(positions_[i].cast<double>() - low_));
        if (number == last_.size()) last_.push_back(no_index);
        next_[i] = std::exchange(last_[number], i);
    }
    void look(const Cell& at, const Vec3f& p, double& best, std::uint32_t& found)
    {
        const std::uint32_t number = cells_.add(at);
        if (number == last_.size()) last_.push_back(no_index);
        for (std::uint32_t i = last_[number]; i != no_index; i = next_[i]) {
            const double away = (positions_[i] - p).cast<double>().squaredNorm();
            if (away <= best) best = away, found = i;
        }
    }

    std::span<const Vec3f> positions_;
    Vec3 low_;
    double reach_;
    std::vector<std::uint32_t> first_;
    Numbering<3> cells_;
    std::vector<std::uint32_t> last_, next_;  // of each cell; of each position, the one before
};

// Of each vertex of the mesh, that of the file.
std::vector<std::uint32_t> places_in_file(const TriMesh& mesh, Places& file)
{
    std::vector<std::uint32_t> place;
    StopCheck check;
    for (const Vec3f& p : mesh.positions) {
        check();
        place.push_back(file.nearest(p));
        if (place.back() == no_index) {
            throw std::runtime_error(
                "its faces have vertices that are not those of the file, as curves and tubes do: "
                "set keep_order = false");
        }
    }
    return place;
}

// The same where several vertices of the mesh have one place: each gets one of the doubles there.
void part_doubles(std::vector<std::uint32_t>& place, const Places& file, std::size_t of_file)
{
    // Of each place's first vertex: how many there are in the mesh and in the file, and the vertex
    // for the next of the mesh.
    std::vector<std::uint32_t> in_mesh(of_file), in_file(of_file), next(of_file), last(of_file);
    std::vector<std::uint32_t> after(of_file, no_index);  // of each vertex of the file, its double
    for (const std::uint32_t first : place) ++in_mesh[first];
    for (std::uint32_t i = 0; i < of_file; ++i) {
        const std::uint32_t first = file.first(i);
        if (in_file[first]++ == 0) {
            next[first] = i;
        } else {
            after[last[first]] = i;
        }
        last[first] = i;
    }
    for (std::uint32_t& p : place) {
        const std::uint32_t first = p;
        if (in_mesh[first] == 1) continue;
        if (in_mesh[first] != in_file[first]) {
            throw std::runtime_error(
                "its objects touch in vertices that they share, or where one of them has several, "
                "so that weld = groups cannot keep the order: set weld = all, or keep_order = "
                "false");
        }
        p = std::exchange(next[first], after[next[first]]);
    }
}

}  // namespace

std::vector<Vec3f> obj_vertices(std::string_view text)
{
    std::vector<Vec3f> out;
    StopCheck check;
    text = without_byte_order_mark(text);
    for (std::size_t number = 1; !text.empty(); ++number) {
        check();
        const std::size_t length = std::min(text.find('\n'), text.size());
        std::string_view line = text.substr(0, length);
        text.remove_prefix(std::min(length + 1, text.size()));
        while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
        if (line.size() < 2 || line[0] != 'v' || !is_blank(line[1])) continue;
        if (!read_numbers(line.substr(2), out.emplace_back())) {
            throw std::runtime_error("line " + std::to_string(number) +
                                     ": expected three numbers after v");
        }
    }
    return out;
}

void keep_file_vertices(TriMesh& mesh, std::span<const Vec3f> of_file, bool apart)
{
    for (const Vec3f& p : of_file) {
        if (!p.allFinite()) {
            throw std::runtime_error(
                "a vertex is not a finite number: set keep_order = false to leave it out");
        }
    }
    Places file(of_file);
    std::vector<std::uint32_t> place = places_in_file(mesh, file);
    if (apart) part_doubles(place, file, of_file.size());
    // Doubles have the values of the first at their place, which faces use.
    std::vector<std::uint32_t> from(of_file.size(), no_index);
    for (std::size_t v = 0; v < place.size(); ++v) from[place[v]] = static_cast<std::uint32_t>(v);
    for (std::size_t i = 0; i < of_file.size(); ++i) {
        if (from[i] == no_index) from[i] = from[file.first(i)];
    }
    const auto spread = [&](const auto& values, const auto& otherwise) {
        std::decay_t<decltype(values)> out;
        for (const std::uint32_t v : from) out.push_back(v == no_index ? otherwise : values[v]);
        return out;
    };
    if (!mesh.colours.empty()) mesh.colours = spread(mesh.colours, Vec3f(Vec3f::Ones()));
    for (Attribute& a : mesh.attributes) {
        if (!a.values.empty()) a.values = spread(a.values, 0.f);
    }
    auto topology = std::make_shared<MeshTopology>(*mesh.topology);
    for (Triangle& t : topology->triangles) {
        for (std::uint32_t& v : t) v = place[v];
    }
    mesh.topology = std::move(topology);
    mesh.positions.assign(of_file.begin(), of_file.end());
}

}  // namespace geometry

// aspic-openvdb: the process in which OpenVDB runs, see geometry/io/library_process.hpp. The one
// source that includes its headers, which take most of the time that it compiles.
//   Museth. VDB: high-resolution sparse volumes with dynamic topology. ACM TOG 32(3), 2013.
// A voxel (i, j, k) reaches from -1/2 to 1/2 around the place that the grid's transform gives it.

#include "geometry/io/imported_volume.hpp"
#include "geometry/io/library_main.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

namespace {

using geometry::ImportedVolume;
using geometry::Vec3f;
using openvdb::FloatGrid;

struct Wanted {
    std::string path, grid;  // empty grid: the first that suits
    double iso = 0;          // of a level set, in the file's unit
    double fog_iso = 0.5;    // of other grids
    bool mesh = true, points = true;
    std::uint64_t most_voxels = 0;
};

[[noreturn]] void fail(const std::string& text)
{
    throw std::runtime_error(text);
}

std::string text_of(double number)
{
    std::ostringstream out;
    out << number;
    return out.str();
}

// What a file says as a line of text has it: of a damaged file that is any bytes.
std::string plain(std::string text)
{
    for (char& c : text) {
        if (c < ' ' || c > '~') c = '?';
    }
    return text;
}

std::string in_quotes(const std::string& name)
{
    return '"' + plain(name.substr(0, 80)) + '"';
}

void want_vdb(const std::string& path)
{
    std::ifstream in(path, std::ios::binary);
    std::int32_t magic = 0;
    in.read(reinterpret_cast<char*>(&magic), sizeof magic);
    if (!in || magic != openvdb::OPENVDB_MAGIC) {
        fail("expected a VDB file, found other bytes at its beginning");
    }
}

struct Listed {
    std::string name, type;
};

std::vector<Listed> grids_of(openvdb::io::File& file)
{
    std::vector<Listed> out;
    for (auto name = file.beginName(); name != file.endName(); ++name) {
        out.push_back({*name, file.readGridMetadata(*name)->valueType()});
    }
    return out;
}

std::string list(const std::vector<Listed>& grids)
{
    constexpr std::size_t most = 20;
    std::string out;
    for (std::size_t i = 0; i < grids.size() && i < most; ++i) {
        out += (i ? ", " : "") + in_quotes(grids[i].name) + " (" + plain(grids[i].type) + ")";
    }
    if (grids.size() > most) out += " and " + std::to_string(grids.size() - most) + " more";
    return grids.empty() ? "no grid" : out;
}

// The grid that is asked for; else surface or density, as the programs call them that write most
// of these files; else the first of floats.
std::string chosen(const std::vector<Listed>& grids, const std::string& asked)
{
    const auto named = [&](const std::string& name) {
        return std::find_if(grids.begin(), grids.end(),
                            [&](const Listed& g) { return g.name == name; });
    };
    if (!asked.empty()) {
        const auto found = named(asked);
        if (found == grids.end()) {
            fail("there is no grid " + in_quotes(asked) + ", but " + list(grids));
        }
        if (found->type == "float") return asked;
        fail("grid " + in_quotes(asked) + " holds values of type " + plain(found->type) +
             ", expected float: choose a grid of floats, or convert it where it was written");
    }
    for (const char* const usual : {"surface", "density"}) {
        const auto found = named(usual);
        if (found != grids.end() && found->type == "float") return usual;
    }
    for (const Listed& g : grids) {
        if (g.type == "float") return g.name;
    }
    fail("expected a grid of floats, found " + list(grids));
}

// What is known before the voxels are read.
void want_usable(const openvdb::GridBase& grid, const std::string& name)
{
    if (!grid.transform().isLinear()) {
        fail("grid " + in_quotes(name) +
             " has a frustum transform, expected an affine one: resample "
             "it to voxels of one size where it was written");
    }
}

struct Scan {
    float low = std::numeric_limits<float>::infinity(), high = -low;
    openvdb::Index64 inside = 0;  // voxels
};

// The volume of a grid as a set of voxels: those on the inner side of the isovalue.
struct Side {
    float iso;
    bool below;

    bool operator()(float value) const { return below ? value < iso : value >= iso; }
};

// see(value, first voxel, last voxel) of each voxel that is stored alone, then of each block of
// voxels that share a value; of those outside of the tree's nodes nothing is stored.
template <class See> void each_value(const FloatGrid& grid, const See& see)
{
    using Leaf = FloatGrid::TreeType::LeafNodeType;
    using All = FloatGrid::TreeType::ValueAllCIter;
    for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
        const float* const values = leaf->buffer().data();
        for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
            const openvdb::Coord at = leaf->offsetToGlobalCoord(i);
            see(values[i], at, at);
        }
    }
    All tile = grid.tree().cbeginValueAll();
    tile.setMaxDepth(All::LEAF_DEPTH - 1);
    for (; tile; ++tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        see(*tile, box.min(), box.max());
    }
}

Scan scan(const FloatGrid& grid, const Side& is_inside)
{
    Scan out;
    each_value(grid, [&](float v, const openvdb::Coord& first, const openvdb::Coord& last) {
        if (!std::isfinite(v)) {
            std::ostringstream at;
            at << first;
            fail("grid " + in_quotes(grid.getName()) + " has the value " + text_of(v) +
                 " at voxel " + at.str() + ", expected numbers: repair it where it was written");
        }
        out.low = std::min(out.low, v);
        out.high = std::max(out.high, v);
        if (is_inside(v)) out.inside += openvdb::CoordBBox(first, last).volume();
    });
    return out;
}

void want_few(openvdb::Index64 voxels, const char* which, const std::string& name,
              const Wanted& wanted)
{
    if (voxels <= wanted.most_voxels) return;
    fail("grid " + in_quotes(name) + " has " + std::to_string(voxels) + " " + which +
         " voxels, more than max_voxels = " + std::to_string(wanted.most_voxels) +
         ": raise it, or write the grid with larger voxels");
}

// What would be found wrong with the isovalue.
void want_crossed(const FloatGrid& grid, const Side& is_inside, const Scan& found)
{
    const std::string name = is_inside.below ? "iso" : "fog_iso";
    const std::string is = name + " is " + text_of(is_inside.iso) + " in the file's unit, ";
    if (is_inside(grid.background())) {
        fail(is + "and all that lies beyond grid " + in_quotes(grid.getName()) +
             " would be inside, where its value is " + text_of(grid.background()) + ": expected " +
             (is_inside.below ? "less" : "more") + " than that");
    }
    if (found.inside == 0) {
        fail(is + "and no voxel of grid " + in_quotes(grid.getName()) +
             " is inside: its values reach from " + text_of(found.low) + " to " +
             text_of(found.high));
    }
}

void add_points(const FloatGrid& grid, const Side& is_inside, openvdb::Index64 count,
                ImportedVolume& out)
{
    out.points.reserve(count);
    out.values.reserve(count);
    each_value(grid, [&](float v, const openvdb::Coord& first, const openvdb::Coord& last) {
        if (!is_inside(v)) return;
        for (auto at = openvdb::CoordBBox(first, last).begin(); at; ++at) {
            const openvdb::Vec3d p = grid.indexToWorld(*at);
            out.points.emplace_back(float(p.x()), float(p.y()), float(p.z()));
            out.values.push_back(v);
        }
    });
}

bool is_mirrored(const openvdb::math::Transform& transform)
{
    return transform.baseMap()->getAffineMap()->getMat4().getMat3().det() < 0;
}

void add_surface(const FloatGrid& grid, float iso, ImportedVolume& out)
{
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    openvdb::tools::volumeToMesh(grid, points, triangles, quads, iso);
    for (const auto& p : points) out.positions.emplace_back(p.x(), p.y(), p.z());
    // OpenVDB's faces run clockwise seen from outside, but of mirrored grids.
    const bool mirrored = is_mirrored(grid.transform());
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        out.triangles.push_back(mirrored ? geometry::Triangle{a, b, c}
                                         : geometry::Triangle{a, c, b});
    };
    for (const auto& t : triangles) add(t[0], t[1], t[2]);
    for (const auto& q : quads) {
        const bool short_02 =
            (points[q[0]] - points[q[2]]).lengthSqr() <= (points[q[1]] - points[q[3]]).lengthSqr();
        const int k = short_02 ? 0 : 1;
        add(q[k], q[k + 1], q[k + 2]);
        add(q[k], q[k + 2], q[(k + 3) % 4]);
    }
}

FloatGrid::Ptr read_grid(const Wanted& wanted, ImportedVolume& out)
{
    openvdb::initialize();
    openvdb::io::File file(wanted.path);
    file.open(false);  // values are read at once, not later from a file that may have changed
    const std::string name = chosen(grids_of(file), wanted.grid);
    want_usable(*file.readGridMetadata(name), name);
    out.grid = name.empty() || name[0] == '[' ? "" : name;  // of no name there is a number
    const auto grid = openvdb::gridPtrCast<FloatGrid>(file.readGrid(name));
    if (!grid) fail("grid " + in_quotes(name) + " is not of the tree that OpenVDB uses for floats");
    return grid;
}

void read(const Wanted& wanted, ImportedVolume& out)
{
    want_vdb(wanted.path);
    FloatGrid::Ptr grid;
    try {
        grid = read_grid(wanted, out);
    } catch (const openvdb::Exception& error) {
        fail("OpenVDB cannot read it (" + plain(error.what()) +
             "): the file is damaged, or of a newer version. Write it again");
    }
    out.level_set = grid->getGridClass() == openvdb::GRID_LEVEL_SET;
    const openvdb::Index64 active = grid->activeVoxelCount();
    if (active == 0) fail("grid " + in_quotes(out.grid) + " is empty: it has no active voxel");
    want_few(active, "active", out.grid, wanted);
    const Side is_inside{float(out.level_set ? wanted.iso : wanted.fog_iso), out.level_set};
    const Scan found = scan(*grid, is_inside);
    want_crossed(*grid, is_inside, found);
    if (wanted.points) {
        want_few(found.inside, "inner", out.grid, wanted);
        add_points(*grid, is_inside, found.inside, out);
    }
    if (wanted.mesh) add_surface(*grid, is_inside.iso, out);
}

}  // namespace

int main(int argc, char** argv)
{
    if (argc != 9) {
        std::fputs("aspic-openvdb is run by aspic to read VDB files\n", stderr);
        return 2;
    }
    const std::string make = argv[5];
    const Wanted wanted{argv[1],
                        argv[2],
                        std::atof(argv[3]),
                        std::atof(argv[4]),
                        make != "points",
                        make != "mesh",
                        std::strtoull(argv[6], nullptr, 10)};
    // On one thread: the limit of seconds is of all together.
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    geometry::limit_process(std::atof(argv[7]), std::atof(argv[8]));
    geometry::hand_over([&] {
        return geometry::made_by<ImportedVolume>([&](ImportedVolume& made) { read(wanted, made); });
    });
}

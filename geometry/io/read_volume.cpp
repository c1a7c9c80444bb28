#include "geometry/io/read_volume.hpp"

#include "geometry/base/parallel.hpp"
#include "geometry/io/file_axes.hpp"
#include "geometry/io/file_bytes.hpp"
#include "geometry/io/import_scene.hpp"
#include "geometry/io/imported_volume.hpp"
#include "geometry/mesh/normals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <stdexcept>
#include <utility>

namespace geometry {
namespace {

namespace fs = std::filesystem;

// Why a run gave no volume; empty when it did.
std::string why_no_volume(const LibraryRun& run, const ProcessLimits& limits)
{
    using End = LibraryRun::End;
    const char* const damaged = ": raise the limit, unless the file is damaged";
    switch (run.end) {
    case End::fine:
        return "";
    case End::out_of_memory:
        return fmt::format("reading it takes more than {} GiB of memory{}",
                           shorter(limits.gigabytes), damaged);
    case End::out_of_time:
        return fmt::format("reading it takes more than {} s{}", shorter(limits.seconds), damaged);
    case End::gave_up:
        return "the reader failed: " + run.said;
    case End::crashed:
        return fmt::format("OpenVDB crashed ({}): the file is damaged. Write it again", run.said);
    case End::not_understood:
        break;
    }
    return run.said;
}

ImportedVolume import_volume(const fs::path& path, const VolumeOptions& options, double metres)
{
    want_mesh_file(path);
    const char* const make = options.make == VolumeParts::mesh     ? "mesh"
                             : options.make == VolumeParts::points ? "points"
                                                                   : "both";
    ImportedVolume volume;
    const LibraryRun run = run_library(
        openvdb_program,
        {fs::absolute(path).string(), options.grid, fmt::format("{}", options.iso / metres),
         fmt::format("{}", options.fog_iso), make, fmt::format("{}", options.max_voxels)},
        {}, options.limits, options.check,
        [&](const char* bytes, std::size_t size) { volume = unpack<ImportedVolume>(bytes, size); });
    std::string why = why_no_volume(run, options.limits);
    if (why.empty()) why = volume.error;
    if (!why.empty()) throw std::runtime_error(path.string() + ": " + why);
    return volume;
}

// Throws where what was handed over is not whole: a damaged file may have damaged the reader.
void require_whole(const fs::path& path, const ImportedVolume& volume)
{
    bool whole = volume.values.size() == volume.points.size();
    for (const Triangle& t : volume.triangles) {
        whole &= std::max({t[0], t[1], t[2]}) < volume.positions.size();
    }
    const auto finite = [](const Vec3f& p) { return p.allFinite(); };
    whole = whole && std::all_of(volume.positions.begin(), volume.positions.end(), finite) &&
            std::all_of(volume.points.begin(), volume.points.end(), finite);
    if (whole) return;
    throw std::runtime_error(path.string() +
                             ": its voxels have places that are not finite, or are not whole: the "
                             "file is damaged. Write it again");
}

void place(std::vector<Vec3f>& points, const Mat3& to_metres)
{
    parallel_for(points.size(), 65536, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            points[i] = (to_metres * points[i].cast<double>()).cast<float>();
        }
    });
}

}  // namespace

ReadVolume read_volume(const fs::path& path, const VolumeOptions& options)
{
    ReadOptions axes;
    axes.unit = options.unit;
    axes.custom_unit = options.custom_unit;
    axes.up = options.up;
    const double metres = metres_of(axes.unit, axes.custom_unit, 0);
    ImportedVolume volume = import_volume(path, options, metres);
    require_whole(path, volume);
    const Mat3 M = to_metres({}, axes);
    ReadVolume out;
    auto topology = std::make_shared<MeshTopology>();
    topology->triangles = std::move(volume.triangles);
    out.mesh.topology = std::move(topology);
    out.mesh.positions = std::move(volume.positions);
    place(out.mesh.positions, M);
    if (!out.mesh.positions.empty()) compute_normals(out.mesh, axes.crease);
    out.points.positions = std::move(volume.points);
    place(out.points.positions, M);
    if (volume.level_set) {
        for (float& v : volume.values) v = static_cast<float>(v * metres);
    }
    out.points.attributes.push_back(
        {one_line(options.attribute.empty() ? volume.grid : options.attribute, "value"),
         volume.level_set ? "m" : "", std::move(volume.values)});
    return out;
}

std::string why_no_volumes()
{
    return why_missing(openvdb_program);
}

}  // namespace geometry

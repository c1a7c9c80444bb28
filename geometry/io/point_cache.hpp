#pragma once

// One file for a whole shot (PC2): a header, then the positions of every vertex at every sample.
// The format has no word for a sample that is missing, and zeros would put the whole mesh into one
// point, so one that nobody has written holds the nearest written one before it, or else the first.
// While there are such, the file ends in a note of which, behind what its header speaks of:
//
//   header  sample 0  sample 1 ... sample n-1   "ASPIC GAPS"  n bytes: 1 written, 0 not
//
// The note goes when the last of them has been written.

#include "geometry/mesh/mesh_fwd.hpp"

#include <filesystem>
#include <span>
#include <vector>

namespace geometry {

// What the header says: positions of every vertex at `samples` times, `rate` frames apart, the
// first at frame `start`.
struct PointCache {
    std::uint32_t points = 0;
    float start = 1, rate = 1;
    std::uint32_t samples = 0;

    bool operator==(const PointCache&) const = default;
};

// What a point cache holds beside what the caller writes, samples ascending.
struct SampleWritten {
    std::vector<std::uint32_t> missing;  // nobody has written them
    // Written by others, which made this sample other than it is now: they are of another motion.
    std::vector<std::uint32_t> outdated;
};

// Puts one sample into the point cache at `path`, at its own place: samples may come in any order
// and from several threads and processes. A file whose header is another's is begun anew. Samples
// not written so far hold this one where it is the nearest, but for those `coming` (ascending),
// which the caller is about to write, so that a sample is not written many times over, and which
// are not outdated. Throws std::runtime_error when it cannot be written and std::invalid_argument
// when there are not cache.points positions or no such sample.
SampleWritten write_sample(const std::filesystem::path& path, const PointCache& cache,
                           std::uint32_t sample, const std::vector<Vec3f>& positions,
                           std::span<const std::uint32_t> coming = {});

// The positions at frame `frame` of the point cache at `path`. Throws std::runtime_error naming the
// file when it is none or is cut short, when it has no sample at that frame, and when nobody has
// written that sample.
std::vector<Vec3f> read_sample(const std::filesystem::path& path, int frame);

}  // namespace geometry

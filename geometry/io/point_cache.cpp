#include "geometry/io/point_cache.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <tuple>

namespace geometry {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t header_size = 32;
constexpr std::string_view note_mark = "ASPIC GAPS";

std::string header_of(const PointCache& cache)
{
    std::string out("POINTCACHE2\0", 12);
    const auto put = [&](const auto& value) {
        static_assert(sizeof value == 4);
        out.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    put(std::int32_t(1));
    put(cache.points);
    put(cache.start);
    put(cache.rate);
    put(cache.samples);
    return out;
}

// The file at `path`, whose only user this is for as long as it lives.
class CacheFile {
public:
    CacheFile(const fs::path& path, const PointCache& cache)
        : path_(path), cache_(cache), header_(header_of(cache)),
          sample_size_(sizeof(Vec3f) * cache.points)
    {
        std::error_code code;
        if (path.has_parent_path()) fs::create_directories(path.parent_path(), code);
        fd_ = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (fd_ < 0) fail();
        while (::flock(fd_, LOCK_EX) != 0) {
            if (errno == EINTR) continue;
            const int why = errno;
            ::close(fd_);
            errno = why;
            fail();
        }
    }
    ~CacheFile() { ::close(fd_); }
    CacheFile(CacheFile&&) = delete;

    // Which samples were written, 1 each; empty when this is no file of such a cache.
    std::string written() const
    {
        struct stat about;
        if (::fstat(fd_, &about) != 0) fail();
        const auto size = static_cast<std::size_t>(about.st_size);
        if (read(0, header_size) != header_) return {};
        if (size == samples_end()) return std::string(cache_.samples, '\1');
        if (read(samples_end(), note_mark.size()) != note_mark) return {};
        const std::string note = read(samples_end() + note_mark.size(), cache_.samples);
        return note.size() == cache_.samples ? note : std::string();
    }

    void begin()
    {
        resize(0);
        write(header_, 0);
    }
    bool holds(std::uint32_t sample, const std::vector<Vec3f>& positions) const
    {
        return read(header_size + sample_size_ * sample, sample_size_) ==
               std::string_view(reinterpret_cast<const char*>(positions.data()), sample_size_);
    }
    void put(std::uint32_t sample, const std::vector<Vec3f>& positions)
    {
        write({reinterpret_cast<const char*>(positions.data()), sample_size_},
              header_size + sample_size_ * sample);
    }
    // Only what has gaps has a note of them.
    void put_note(const std::string& written)
    {
        if (written.find('\0') == std::string::npos) return resize(samples_end());
        write(std::string(note_mark) + written, samples_end());
    }

private:
    std::size_t samples_end() const { return header_size + sample_size_ * cache_.samples; }

    [[noreturn]] void fail() const
    {
        throw std::runtime_error("could not write the point cache " + path_.string() + ": " +
                                 std::strerror(errno));
    }
    std::string read(std::size_t offset, std::size_t size) const
    {
        std::string bytes(size, '\0');
        std::size_t done = 0;
        while (done < size) {
            const ssize_t n =
                ::pread(fd_, bytes.data() + done, size - done, static_cast<off_t>(offset + done));
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) fail();
            if (n == 0) break;
            done += static_cast<std::size_t>(n);
        }
        bytes.resize(done);
        return bytes;
    }
    void write(std::string_view bytes, std::size_t offset)
    {
        while (!bytes.empty()) {
            const ssize_t n = ::pwrite(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
            if (n < 0 && errno == EINTR) continue;
            if (n < 0) fail();
            bytes.remove_prefix(static_cast<std::size_t>(n));
            offset += static_cast<std::size_t>(n);
        }
    }
    void resize(std::size_t size)
    {
        if (::ftruncate(fd_, static_cast<off_t>(size)) != 0) fail();
    }

    const fs::path& path_;
    const PointCache& cache_;
    const std::string header_;
    const std::size_t sample_size_;
    int fd_ = -1;
};

// Those that hold sample `s`: from it to the next that is written or coming; all before it, too,
// where it is the first.
std::pair<std::uint32_t, std::uint32_t> held(const std::string& written, std::uint32_t s,
                                             std::span<const std::uint32_t> coming)
{
    const auto own = [&](std::uint32_t i) {
        return written[i] != 0 || std::binary_search(coming.begin(), coming.end(), i);
    };
    std::uint32_t begin = s, end = s + 1;
    while (end < written.size() && !own(end)) ++end;
    while (begin > 0 && !own(begin - 1)) --begin;
    return {begin == 0 ? 0 : s, end};
}

// What the first bytes of a point cache say. Throws where they are not those of one.
PointCache cache_of(const std::string& header)
{
    const auto take = [&](auto& value, std::size_t at) {
        std::memcpy(&value, header.data() + at, sizeof value);
    };
    PointCache cache;
    if (header.size() == header_size) {
        take(cache.points, 16);
        take(cache.start, 20);
        take(cache.rate, 24);
        take(cache.samples, 28);
    }
    const bool sane = std::isfinite(cache.start) && std::isfinite(cache.rate) && cache.rate > 0;
    if (header != header_of(cache) || !sane) {
        throw std::runtime_error("it is no point cache (PC2) of version 1, or is cut short");
    }
    return cache;
}

// The place of a frame among the samples.
std::uint64_t sample_at(const PointCache& cache, int frame)
{
    const double place = (frame - double(cache.start)) / double(cache.rate);
    if (place >= 0 && place < cache.samples && place == std::floor(place)) {
        return static_cast<std::uint64_t>(place);
    }
    throw std::runtime_error(fmt::format(
        "it has no frame {}: it holds {} frames from {:g} to {:g}, {:g} apart", frame,
        cache.samples, cache.start,
        double(cache.start) + double(cache.rate) * (double(cache.samples) - 1), cache.rate));
}

std::vector<Vec3f> sample_in(std::ifstream& file, std::uint64_t size, int frame)
{
    const auto take = [&](std::uint64_t offset, std::size_t bytes) {
        std::string out(bytes, '\0');
        file.clear();
        file.seekg(static_cast<std::streamoff>(offset));
        file.read(out.data(), static_cast<std::streamsize>(bytes));
        out.resize(static_cast<std::size_t>(file.gcount()));
        return out;
    };
    const PointCache cache = cache_of(take(0, header_size));
    const std::uint64_t s = sample_at(cache, frame);
    const std::uint64_t each = sizeof(Vec3f) * std::uint64_t(cache.points);
    if (each > 0 && (size - header_size) / each < cache.samples) {
        throw std::runtime_error(fmt::format("it is cut short: its header announces {} frames of "
                                             "{} points, the file has {} bytes",
                                             cache.samples, cache.points, size));
    }
    const std::uint64_t end = header_size + each * cache.samples;
    const std::string note = take(end, note_mark.size() + cache.samples);
    if (note.size() == note_mark.size() + cache.samples && note.starts_with(note_mark) &&
        note[note_mark.size() + s] == '\0') {
        throw std::runtime_error(
            fmt::format("its frame {} was never written: cook that frame first", frame));
    }
    const std::string bytes = take(header_size + each * s, each);
    std::vector<Vec3f> positions(bytes.size() / sizeof(Vec3f));
    std::memcpy(static_cast<void*>(positions.data()), bytes.data(), bytes.size());
    return positions;
}

}  // namespace

std::vector<Vec3f> read_sample(const fs::path& path, int frame)
{
    std::ifstream file(path, std::ios::binary);
    std::error_code code;
    const std::uint64_t size = fs::file_size(path, code);
    if (!file || code) throw std::runtime_error(path.string() + " cannot be read");
    try {
        return sample_in(file, size, frame);
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path.string() + ": " + error.what());
    }
}

SampleWritten write_sample(const fs::path& path, const PointCache& cache, std::uint32_t sample,
                           const std::vector<Vec3f>& positions,
                           std::span<const std::uint32_t> coming)
{
    if (positions.size() != cache.points || sample >= cache.samples) {
        throw std::invalid_argument("the point cache holds " + std::to_string(cache.samples) +
                                    " samples of " + std::to_string(cache.points) +
                                    " points: sample " + std::to_string(sample) + " (from 0) of " +
                                    std::to_string(positions.size()) + " points does not fit");
    }
    CacheFile file(path, cache);
    std::string written = file.written();
    std::uint32_t begin = 0, end = cache.samples;
    if (written.empty()) {
        // All of it, so that a cook that is cut short leaves no zeros either.
        written.assign(cache.samples, '\0');
        file.begin();
        file.put_note(written);
    } else {
        std::tie(begin, end) = held(written, sample, coming);
    }
    const bool changes = written[sample] != 0 && !file.holds(sample, positions);
    for (std::uint32_t s = begin; s < end; ++s) file.put(s, positions);
    written[sample] = 1;
    file.put_note(written);
    SampleWritten out;
    for (std::uint32_t s = 0; s < cache.samples; ++s) {
        if (written[s] == 0) out.missing.push_back(s);
        if (written[s] == 0 || s == sample || !changes) continue;
        if (!std::binary_search(coming.begin(), coming.end(), s)) out.outdated.push_back(s);
    }
    return out;
}

}  // namespace geometry

#include "geometry/io/point_cache.hpp"

#include "tests/geometry/files.hpp"

#include <gtest/gtest.h>

#include <numeric>
#include <thread>

namespace {

using geometry::PointCache;
using geometry::Vec3f;
using geometry::write_sample;
using Samples = std::vector<std::uint32_t>;

std::vector<Vec3f> sample_at(std::size_t points, std::uint32_t sample)
{
    std::vector<Vec3f> out;
    for (std::size_t i = 0; i < points; ++i) out.emplace_back(float(i), float(sample), 0.5f);
    return out;
}

// The file as a reader of the format sees it.
std::string expected_cache(std::uint32_t points, float start, const Samples& samples)
{
    std::string out("POINTCACHE2\0\1\0\0\0", 16);
    const auto put = [&](const auto& x) { out.append(reinterpret_cast<const char*>(&x), 4); };
    put(points), put(start), put(1.f), put(std::uint32_t(samples.size()));
    for (const std::uint32_t s : samples) {
        for (const Vec3f& p : sample_at(points, s)) put(p.x()), put(p.y()), put(p.z());
    }
    return out;
}

TEST(PointCache, SamplesFromManyThreadsInAnyOrderMakeOneFile)
{
    const files::Folder folder;
    const auto path = folder.path / "deep/a.pc2";
    const PointCache cache{1000, 101, 1, 24};
    std::vector<std::thread> threads;
    for (std::uint32_t k = 0; k < 4; ++k) {
        threads.emplace_back([&, k] {
            for (std::uint32_t i = 0; i < 6; ++i) {
                const std::uint32_t s = (k * 6 + i) * 7 % 24;  // 7 and 24 share no factor
                write_sample(path, cache, s, sample_at(1000, s));
            }
        });
    }
    for (auto& t : threads) t.join();
    Samples all(24);
    std::iota(all.begin(), all.end(), 0u);
    EXPECT_EQ(files::bytes_of(path), expected_cache(1000, 101, all));
}

TEST(PointCache, AnotherCooksSamplesStayUnlessItsHeaderDiffers)
{
    const files::Folder folder;
    const auto path = folder.path / "a.pc2";
    const PointCache cache{3, 1, 1, 2};
    EXPECT_EQ(write_sample(path, cache, 0, sample_at(3, 0)).missing, Samples{1});
    EXPECT_EQ(write_sample(path, cache, 1, sample_at(3, 1)).missing, Samples{});
    EXPECT_EQ(write_sample(path, cache, 1, sample_at(3, 1)).missing, Samples{});
    EXPECT_EQ(files::bytes_of(path), expected_cache(3, 1, {0, 1}));
    const PointCache longer{4, 1, 1, 2};
    EXPECT_EQ(write_sample(path, longer, 0, sample_at(4, 0)).missing, Samples{1});
    EXPECT_EQ(write_sample(path, longer, 1, sample_at(4, 1)).missing, Samples{});
    EXPECT_EQ(files::bytes_of(path), expected_cache(4, 1, {0, 1}));
}

// What a reader sees; behind it is the note of gaps, if there are any.
std::string samples_of(const std::filesystem::path& path, const PointCache& cache)
{
    return files::bytes_of(path).substr(0, 32 + 12 * std::size_t{cache.points} * cache.samples);
}

TEST(PointCache, ASampleThatNobodyWroteHoldsTheNearestOneBeforeItOrElseTheFirst)
{
    const PointCache cache{3, 1, 1, 8};
    const Samples some{2, 4, 7};
    // Whatever the order, and whether the writer says what is to come.
    for (const Samples& order : {Samples{2, 4, 7}, Samples{7, 2, 4}, Samples{4, 7, 2}}) {
        for (const Samples& coming : {Samples{}, some}) {
            const files::Folder folder;
            const auto path = folder.path / "a.pc2";
            Samples missing;
            for (const std::uint32_t s : order) {
                missing = write_sample(path, cache, s, sample_at(3, s), coming).missing;
            }
            EXPECT_EQ(missing, (Samples{0, 1, 3, 5, 6}));
            EXPECT_EQ(samples_of(path, cache), expected_cache(3, 1, {2, 2, 2, 2, 4, 4, 4, 7}));
        }
    }
}

TEST(PointCache, SamplesOfAnotherMotionThanTheOneThatReplacesOneOfThemAreTold)
{
    const files::Folder folder;
    const auto path = folder.path / "a.pc2";
    const PointCache cache{3, 1, 1, 5};
    for (const std::uint32_t s : {0u, 1u, 2u, 4u}) {
        EXPECT_EQ(write_sample(path, cache, s, sample_at(3, s)).outdated, Samples{});
    }
    // The same again is of the same motion; a gap says nothing of the others.
    EXPECT_EQ(write_sample(path, cache, 1, sample_at(3, 1)).outdated, Samples{});
    EXPECT_EQ(write_sample(path, cache, 1, sample_at(3, 9)).outdated, (Samples{0, 2, 4}));
    EXPECT_EQ(write_sample(path, cache, 3, sample_at(3, 9)).outdated, Samples{});
    // Those that are coming will be of the new motion.
    EXPECT_EQ(write_sample(path, cache, 1, sample_at(3, 8), Samples{1, 2}).outdated,
              (Samples{0, 3, 4}));
}

TEST(PointCache, ALaterCookFillsTheGapsAndLeavesNoTraceOfThem)
{
    const files::Folder folder;
    const auto path = folder.path / "a.pc2";
    const PointCache cache{3, 1, 1, 6};
    for (const std::uint32_t s : {0u, 3u}) write_sample(path, cache, s, sample_at(3, s));
    EXPECT_EQ(write_sample(path, cache, 1, sample_at(3, 1)).missing, (Samples{2, 4, 5}));
    EXPECT_EQ(samples_of(path, cache), expected_cache(3, 1, {0, 1, 1, 3, 3, 3}));
    for (const std::uint32_t s : {5u, 2u, 4u}) write_sample(path, cache, s, sample_at(3, s));
    EXPECT_EQ(files::bytes_of(path), expected_cache(3, 1, {0, 1, 2, 3, 4, 5}));
}

TEST(PointCache, ACookThatIsCutShortLeavesNoZeros)
{
    const files::Folder folder;
    const auto path = folder.path / "a.pc2";
    const PointCache cache{3, 1, 1, 4};
    write_sample(path, cache, 1, sample_at(3, 1), Samples{0, 1, 2, 3});
    EXPECT_EQ(samples_of(path, cache), expected_cache(3, 1, {1, 1, 1, 1}));
}

TEST(PointCache, WrongSamplesAreRefused)
{
    const files::Folder folder;
    const auto path = folder.path / "a.pc2";
    EXPECT_THROW(write_sample(path, {3, 1, 1, 2}, 2, sample_at(3, 0)), std::invalid_argument);
    EXPECT_THROW(write_sample(path, {3, 1, 1, 2}, 0, sample_at(4, 0)), std::invalid_argument);
    EXPECT_THROW(write_sample(folder.path, {3, 1, 1, 2}, 0, sample_at(3, 0)), std::runtime_error);
}

}  // namespace

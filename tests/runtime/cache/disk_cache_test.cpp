#include "runtime/cache/disk_cache.hpp"

#include "runtime/cache/whole_file.hpp"
#include "runtime/cook/evaluator.hpp"
#include "tests/runtime/toys.hpp"

#include <gtest/gtest.h>
#include <random>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace runtime;
using toys::number;
using toys::take_runs;
using toys::Wiring;

namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t plenty = std::uintmax_t{1} << 30;

struct Warnings {
    std::vector<std::string> all;
    std::function<void(const std::string&)> take()
    {
        return [this](const std::string& text) { all.push_back(text); };
    }
};

const graph::NodeType& slow()
{
    return *toys::registry().find("Slow");
}

std::shared_ptr<Result> numbers(std::size_t n, double first = 0)
{
    auto result = std::make_shared<Result>();
    toys::Numbers content;
    for (std::size_t i = 0; i < n; ++i) content.all.push_back(first + std::sqrt(double(i)));
    result->values = {graph::Value::of(std::move(content)), graph::Value::of(first)};
    result->seconds = 1;
    result->bytes = n * 8;
    return result;
}

std::vector<double> all_of(const SharedResult& result)
{
    return result->values[0].as<toys::Numbers>()->all;
}

// But for the notes on their size.
std::vector<fs::path> files_in(const fs::path& folder)
{
    std::vector<fs::path> files;
    for (const auto& f : fs::recursive_directory_iterator(folder)) {
        if (f.is_regular_file() && f.path().filename() != "size.txt") files.push_back(f.path());
    }
    std::sort(files.begin(), files.end());
    return files;
}

void flip_bit(const fs::path& path, std::size_t bit)
{
    std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
    file.seekg(static_cast<std::streamoff>(bit / 8));
    char byte = 0;
    file.get(byte);
    file.seekp(static_cast<std::streamoff>(bit / 8));
    file.put(static_cast<char>(byte ^ (1 << bit % 8)));
}

// A graph whose sink-free end is slow enough for its results to be stored.
Wiring slow_simulation(int last)
{
    Wiring w(last);
    const auto clock = w.add("Clock");
    const auto work =
        w.add("Slow", {{"value", {clock}}}, {{"seconds", {4e-3}}, {"size", {std::int64_t{100}}}});
    w.graph.nodes[work].type = toys::registry().find("Slow");
    const auto sum = w.add("Sum");
    w.graph.nodes[sum].inputs[0] = {{work, 1}};
    w.add("Accumulate", {{"value", {sum}}});
    return w;
}

// With the keys under which each of the nodes is looked for at the last frame.
double cook_last(const graph::Graph& graph, const fs::path& folder, std::vector<Key>& keys)
{
    Caches caches;
    caches.disk = std::make_unique<DiskCache>(folder, plenty, nullptr);
    caches.side_files.remember_in(caches.disk.get());
    Options options;
    options.threads = 2;
    const auto last = static_cast<std::uint32_t>(graph.nodes.size() - 1);
    Evaluator evaluator(graph, caches, options);
    const double value = number(evaluator.pull({last, 0}, graph.range.last));
    keys.clear();
    for (std::uint32_t n = 0; n <= last; ++n) {
        keys.push_back(evaluator.keys().at(n, graph.range.last));
    }
    return value;
}
double cook_last(const graph::Graph& graph, const fs::path& folder)
{
    std::vector<Key> keys;
    return cook_last(graph, folder, keys);
}

}  // namespace

TEST(DiskCache, WhatIsStoredComesBack)
{
    const toys::Folder folder;
    for (const unsigned n : {0u, 1u, 100u, 1'000'000u}) {
        const Key key{n, 1};
        {
            DiskCache cache(folder.path, plenty, nullptr);
            EXPECT_FALSE(cache.holds(key));
            EXPECT_EQ(cache.load(key, slow()), nullptr);
            auto result = numbers(n);
            result->warnings = {"careful"};
            result->heard = {{{5, 6}, 7, "rough"}};
            result->files = {{"/a/b.png", {3, 4}}};
            cache.store(key, result);
        }
        DiskCache cache(folder.path, plenty, nullptr);
        EXPECT_TRUE(cache.holds(key));
        const SharedResult back = cache.load(key, slow());
        ASSERT_NE(back, nullptr);
        EXPECT_EQ(all_of(back), all_of(numbers(n)));
        EXPECT_EQ(number(back->values[1]), 0);
        EXPECT_EQ(back->warnings, (std::vector<std::string>{"careful"}));
        EXPECT_EQ(back->heard, (std::vector<Heard>{{{5, 6}, 7, "rough"}}));
        ASSERT_EQ(back->files.size(), 1u);
        EXPECT_EQ(back->files[0].path, "/a/b.png");
        EXPECT_EQ(back->files[0].digest, (Key{3, 4}));
        EXPECT_EQ(back->seconds, 1);
    }
}

TEST(DiskCache, EqualValuesAreOneFile)
{
    const toys::Folder folder;
    DiskCache cache(folder.path, plenty, nullptr);
    for (std::uint64_t k = 0; k < 20; ++k) cache.store({k, 0}, numbers(1000));
    cache.flush();
    const DiskUse use = cache.use();
    EXPECT_EQ(use.records, 20u);
    EXPECT_EQ(use.contents, 2u);  // the numbers and the number
    EXPECT_EQ(cache.load({7, 0}, slow())->values[0].content(),
              cache.load({8, 0}, slow())->values[0].content())
        << "and one object";
}

TEST(DiskCache, AnotherLayoutIsAMissAndNoDamage)
{
    const toys::Folder folder;
    Warnings warnings;
    DiskCache cache(folder.path, plenty, warnings.take());
    cache.store({1, 1}, numbers(10));
    cache.flush();
    graph::NodeType changed = slow();
    graph::WireType other = *changed.outputs[0].wire;
    other.layout = "{vector(f4)}";
    changed.outputs[0].wire = &other;
    EXPECT_EQ(cache.load({1, 1}, changed), nullptr);
    EXPECT_NE(cache.load({1, 1}, slow()), nullptr);
    EXPECT_TRUE(warnings.all.empty());
}

TEST(DiskCache, AFlippedBitAnywhereIsSetAsideAndNeverRead)
{
    const toys::Folder folder, pristine;
    {
        DiskCache cache(pristine.path, plenty, nullptr);
        cache.store({1, 1}, numbers(200));
    }
    std::mt19937 random(3);
    for (int round = 0; round < 200; ++round) {
        fs::remove_all(folder.path);
        fs::copy(pristine.path, folder.path, fs::copy_options::recursive);
        const std::vector<fs::path> files = files_in(folder.path);
        const fs::path& victim = files[random() % files.size()];
        flip_bit(victim, random() % (fs::file_size(victim) * 8));
        Warnings warnings;
        DiskCache cache(folder.path, plenty, warnings.take());
        EXPECT_EQ(cache.load({1, 1}, slow()), nullptr) << victim;
        EXPECT_EQ(warnings.all.size(), 1u) << victim;
        EXPECT_FALSE(fs::exists(victim)) << "set aside";
        if (round % 50 > 0) continue;
        cache.store({1, 1}, numbers(200));
        cache.flush();
        EXPECT_NE(cache.load({1, 1}, slow()), nullptr) << "made again";
    }
}

TEST(DiskCache, AFileCutShortOrGrownIsSetAside)
{
    const toys::Folder folder;
    for (const int change : {-1, 1}) {
        DiskCache cache(folder.path, plenty, nullptr);
        cache.store({1, 1}, numbers(3000));
        cache.flush();
        for (const fs::path& file : files_in(folder.path / "5/contents")) {
            fs::resize_file(file, fs::file_size(file) + static_cast<std::uintmax_t>(change));
        }
        EXPECT_EQ(cache.load({1, 1}, slow()), nullptr);
        EXPECT_EQ(cache.verify().bad, 1u) << "one was set aside by the load, one by this";
    }
}

TEST(DiskCache, VerifyFindsAFileUnderAWrongName)
{
    const toys::Folder folder;
    DiskCache cache(folder.path, plenty, nullptr);
    cache.store({1, 1}, numbers(10));
    cache.flush();
    EXPECT_EQ(cache.verify().good, 3u);
    const fs::path file = files_in(folder.path / "5/contents")[0];
    fs::rename(file, file.string().substr(0, file.string().size() - 4) + "0000");
    const DiskCheck check = cache.verify();
    EXPECT_EQ(check.bad, 1u);
    EXPECT_EQ(cache.use().aside, 1u);
}

// What each node of a small graph gives at each frame, and what its cache warned of.
struct Given {
    std::vector<double> numbers;
    std::vector<std::string> warnings;
};

static Given cook_all(const graph::Graph& graph, const fs::path& folder)
{
    Given given;
    Warnings warnings;
    Caches caches;
    caches.disk = std::make_unique<DiskCache>(folder, plenty, warnings.take());
    caches.side_files.remember_in(caches.disk.get());
    Options options;
    options.threads = 1;
    Evaluator evaluator(graph, caches, options);
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        for (std::uint32_t out = 0; out < graph.nodes[n].type->outputs.size(); ++out) {
            for (int frame = 1; frame <= graph.range.last; ++frame) {
                const graph::Value value = evaluator.pull({n, out}, frame);
                if (*value.type()->type == typeid(double)) {
                    given.numbers.push_back(number(value));
                } else {
                    const auto& all = value.as<toys::Numbers>()->all;
                    given.numbers.insert(given.numbers.end(), all.begin(), all.end());
                }
            }
        }
    }
    caches.disk.reset();
    given.warnings = warnings.all;
    return given;
}

// A copy in which a file of two names is one file, too.
static void copy_cache(const fs::path& from, const fs::path& to)
{
    std::map<ino_t, fs::path> copied;
    for (const fs::path& file : files_in(from)) {
        const fs::path copy = to / file.lexically_relative(from);
        fs::create_directories(copy.parent_path());
        struct stat info = {};
        ASSERT_EQ(::stat(file.c_str(), &info), 0);
        const auto [known, is_new] = copied.try_emplace(info.st_ino, copy);
        is_new ? static_cast<void>(fs::copy_file(file, copy))
               : fs::create_hard_link(known->second, copy);
    }
}

TEST(DiskCache, AFileUnderTheNameOfAnotherIsNotBelieved)
{
    const toys::Folder folder, pristine;
    folder.write("beside.txt", "10");
    const fs::path first = folder.write("a.txt", "5 beside.txt");
    Wiring w(2);
    const auto read = w.add("ReadNumber", {}, {{"path", {first.string()}}});
    const auto clock = w.add("Clock");
    const auto sum = w.add("Sum", {{"values", {read, clock}}});
    w.add("Slow", {{"value", {sum}}}, {{"seconds", {4e-3}}, {"size", {std::int64_t{100}}}});
    w.add("Slow", {{"value", {read}}}, {{"seconds", {4e-3}}, {"size", {std::int64_t{100}}}});

    const Given expected = cook_all(w.graph, pristine.path);
    EXPECT_TRUE(expected.warnings.empty());
    const std::vector<fs::path> files = files_in(pristine.path);
    ASSERT_GE(files.size(), 10u);
    const fs::path cache = folder.path / "cache";
    for (std::size_t i = 0; i < files.size(); ++i) {
        for (std::size_t j = i + 1; j < files.size(); ++j) {
            fs::remove_all(cache);
            copy_cache(pristine.path, cache);
            const fs::path a = cache / files[i].lexically_relative(pristine.path);
            const fs::path b = cache / files[j].lexically_relative(pristine.path);
            // Two names of one record: swapped, they are what they were.
            const bool same = toys::bytes_of(a) == toys::bytes_of(b);
            fs::rename(a, folder.path / "between");
            fs::rename(b, a);
            fs::rename(folder.path / "between", b);
            const Given given = cook_all(w.graph, cache);
            EXPECT_EQ(given.numbers, expected.numbers) << a << " and " << b;
            EXPECT_LE(given.warnings.size(), same ? 0u : 1u);
            DiskCache after(cache, plenty, nullptr);
            const std::size_t found = after.use().aside;
            EXPECT_EQ(found + after.verify().bad > 0, !same) << a << " and " << b;
        }
    }
}

// A record may name contents that another record brought into memory as values of another type.
TEST(DiskCache, AValueOfAnotherTypeIsNotHandedOn)
{
    const toys::Folder folder;
    DiskCache cache(folder.path, plenty, nullptr);
    cache.store({1, 1}, numbers(10));
    cache.flush();
    const SharedResult held = cache.load({1, 1}, slow());
    ASSERT_NE(held, nullptr);
    graph::NodeType changed = slow();
    std::swap(changed.outputs[0].wire, changed.outputs[1].wire);
    EXPECT_EQ(cache.load({1, 1}, changed), nullptr);
}

TEST(DiskCache, AReadOnlyFolderWarnsOnce)
{
    const toys::Folder folder;
    const fs::path blocked = folder.write("file", "a file stands where the folder should");
    Warnings warnings;
    DiskCache cache(blocked, plenty, warnings.take());
    for (std::uint64_t k = 0; k < 5; ++k) cache.store({k, 0}, numbers(10));
    cache.flush();
    EXPECT_EQ(warnings.all.size(), 1u);
    EXPECT_EQ(cache.load({1, 0}, slow()), nullptr);
}

TEST(DiskCache, ShrinkingKeepsWhatIsCostlyAndSmall)
{
    const toys::Folder folder;
    DiskCache cache(folder.path, plenty, nullptr);
    for (std::uint64_t k = 0; k < 10; ++k) {
        auto result = numbers(10'000, static_cast<double>(k) * 1000);
        result->seconds = k == 4 ? 100 : 0.01;
        cache.store({k, 0}, result);
    }
    cache.flush();
    const std::uintmax_t before = cache.use().bytes;
    EXPECT_GT(cache.shrink(before / 3, 0), 0u);
    EXPECT_LE(cache.use().bytes, before / 3);
    EXPECT_TRUE(cache.holds({4, 0}));
    EXPECT_NE(cache.load({4, 0}, slow()), nullptr);
    cache.clear();
    EXPECT_EQ(cache.use().bytes, 0u);
}

// A file takes whole blocks of the disk, and that is what a full disk counts.
TEST(DiskCache, TheSizeIsThatOnDisk)
{
    const toys::Folder folder;
    DiskCache cache(folder.path, plenty, nullptr);
    for (std::uint64_t k = 1; k <= 20; ++k) cache.store({k, 0}, numbers(1, double(k)));
    cache.flush();
    std::uintmax_t blocks = 0;
    for (const char* part : {"5/records", "5/contents"}) {
        for (const fs::path& file : files_in(folder.path / part)) {
            struct stat info = {};
            ASSERT_EQ(::stat(file.c_str(), &info), 0);
            blocks += static_cast<std::uintmax_t>(info.st_blocks) * 512;
        }
    }
    EXPECT_EQ(cache.use().bytes, blocks);
    EXPECT_GE(cache.use().bytes, 60u * 1024) << "files of some hundred bytes";
    cache.shrink(blocks / 2, 0);
    EXPECT_LE(cache.use().bytes, blocks / 2);
}

TEST(DiskCache, OneThatWritesMuchInAMomentKeepsToTheBudget)
{
    const toys::Folder folder;
    constexpr std::uintmax_t budget = 1'000'000, one = 100'000;
    DiskCache cache(folder.path, budget, nullptr);
    for (std::uint64_t k = 0; k < 100; ++k) cache.store({k, 0}, numbers(10'000, double(k) * 1000));
    cache.flush();
    EXPECT_LE(cache.use().bytes, budget + budget / 16 + one);
    // So does one that ends, and one that is told to.
    cache.shrink(budget / 2);
    EXPECT_LE(cache.use().bytes, budget / 2);
    EXPECT_GT(cache.use().records, 0u);
    EXPECT_EQ(cache.verify().bad, 0u);
}

// Contents may be too young to go: those that another process stored again, and that it has not
// named yet. At an age of 0 they are younger than their records.
TEST(DiskCache, ShrinkingDropsNoMoreRecordsThanItHasTo)
{
    for (const int age : {0, 30}) {  // s
        const toys::Folder folder;
        DiskCache cache(folder.path, plenty, nullptr);
        for (std::uint64_t k = 0; k < 12; ++k) {
            auto result = numbers(10'000, static_cast<double>(k) * 1000);
            result->seconds = 1 + static_cast<double>(k);
            cache.store({k, 0}, result);
        }
        cache.flush();
        const std::uintmax_t before = cache.use().bytes;
        for (const fs::path& file : files_in(folder.path / "5/contents")) {
            fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::seconds(age));
        }
        for (int again = 0; again < 3; ++again) {
            cache.shrink(before / 2);
            EXPECT_GE(cache.use().records, 4u) << age;
            EXPECT_LE(cache.use().records, 6u) << age;
            EXPECT_TRUE(cache.holds({11, 0}));
            if (age > 0) {
                EXPECT_LE(cache.use().bytes, before / 2);
            }
        }
        EXPECT_EQ(cache.verify().bad, 0u);
    }
}

TEST(DiskCache, AProcessThatWritesALittleLooksAtNothingThatOthersStored)
{
    // A look at all files finds this one: it sets it aside.
    const toys::Folder folder;
    const auto damaged = [&] {
        return fs::exists(folder.path / "5/aside") ? files_in(folder.path / "5/aside").size() : 0;
    };
    const auto store = [&](std::uint64_t key, std::uintmax_t budget) {
        DiskCache(folder.path, budget, nullptr).store({key, 1}, numbers(1000, double(key)));
    };
    for (std::uint64_t key = 1; key <= 8; ++key) store(key, plenty);
    flip_bit(files_in(folder.path / "5/records").front(), 300);
    store(9, plenty);
    EXPECT_EQ(damaged(), 0u);
    std::uintmax_t bytes = DiskCache(folder.path, plenty, nullptr).use().bytes;
    store(10, bytes * 2);
    EXPECT_EQ(damaged(), 0u);
    // There is more than this one allows.
    store(11, bytes / 2);
    EXPECT_EQ(damaged(), 1u);
    EXPECT_LT(DiskCache(folder.path, plenty, nullptr).use().records, 10u);

    // What is not known is looked at, and so is what was known a day ago.
    for (const std::string note : {"", "100\n", "1000 1700000000\n", "1000 99999999999\nx\n"}) {
        flip_bit(files_in(folder.path / "5/records").front(), 300);
        const std::size_t before = damaged();
        folder.write("5/size.txt", note);
        store(12 + before, plenty);
        EXPECT_EQ(damaged(), before + 1) << note;
    }
}

TEST(DiskCache, WhatOthersWriteDuringALookIsCounted)
{
    const toys::Folder folder;
    const fs::path notes = folder.path / "5/size.txt";
    const auto tell = [&](const char* line) { std::ofstream(notes, std::ios::app) << line; };
    for (std::uint64_t key = 1; key <= 3; ++key) {
        DiskCache(folder.path, plenty, nullptr).store({key, 1}, numbers(1000, double(key)));
    }
    tell("77\n");  // before the look, which finds what it tells of
    // A look warns of this one, and another process writes at that moment.
    flip_bit(files_in(folder.path / "5/records").front(), 300);
    DiskCache cache(folder.path, plenty, [&](const std::string&) { tell("123456\n"); });
    cache.shrink(plenty);
    const std::string text = toys::bytes_of(notes);
    EXPECT_TRUE(text.ends_with("\n123456\n")) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 2) << text;
}

TEST(DiskCache, ManyThatWriteALittleTogetherKeepToTheBudget)
{
    const toys::Folder folder;
    constexpr std::uintmax_t budget = 400'000;
    for (std::uint64_t key = 1; key <= 100; ++key) {
        DiskCache(folder.path, budget, nullptr).store({key, 1}, numbers(1000, double(key)));
    }
    const DiskUse use = DiskCache(folder.path, budget, nullptr).use();
    EXPECT_LE(use.bytes, budget);
    EXPECT_GE(use.bytes, budget / 2);
}

TEST(DiskCache, ASharedContentOutlivesOneOfItsRecords)
{
    const toys::Folder folder;
    DiskCache cache(folder.path, plenty, nullptr);
    auto cheap = numbers(10'000), dear = numbers(10'000);
    cheap->seconds = 0.001, dear->seconds = 100;
    cache.store({1, 0}, cheap);
    cache.store({2, 0}, dear);
    cache.store({3, 0}, numbers(10'000, 5));
    cache.flush();
    cache.shrink(cache.use().bytes - 1, 0);
    EXPECT_FALSE(cache.holds({1, 0}));
    EXPECT_NE(cache.load({2, 0}, slow()), nullptr);
}

TEST(DiskCache, ACookGoesOnFromWhatAnotherProcessLeft)
{
    const toys::Folder folder;
    const Wiring w = slow_simulation(6);
    const double first = cook_last(w.graph, folder.path);
    take_runs("Slow");
    EXPECT_EQ(cook_last(w.graph, folder.path), first);
    EXPECT_EQ(take_runs("Slow"), 0);
}

// Steps of 1 ms are made again quicker than read, but not many of them: whoever scrubs through the
// frames waits for 5 ms of steps at most (and for one more, as that is where it is noticed).
TEST(DiskCache, AnyFrameOfAQuickSimulationIsAFewStepsAway)
{
    const toys::Folder folder;
    Wiring w(60);
    const auto one = w.add("Constant");
    w.add("Accumulate", {{"value", {one}}}, {{"seconds", {1e-3}}});
    cook_last(w.graph, folder.path);
    for (const int frame : {60, 59, 37, 12, 3}) {
        w.graph.range.last = frame;
        take_runs("Accumulate");
        EXPECT_EQ(cook_last(w.graph, folder.path), frame);
        EXPECT_LE(take_runs("Accumulate"), 6) << frame;
    }
}

// 2 = 1 + 1: what stands downstream is found by the bytes it would be made of.
TEST(DiskCache, AnEditThatYieldsEqualBytesRecomputesNothingInTheNextProcess)
{
    const toys::Folder folder;
    Wiring w;
    const auto two = w.add("Constant", {}, {{"value", {2.0}}});
    const auto slow = w.add("Slow", {{"value", {two}}}, {{"seconds", {4e-3}}});
    const auto sum = w.add("Sum");
    w.graph.nodes[sum].inputs[0] = {{slow, 1}};
    std::vector<Key> before, after;
    EXPECT_EQ(cook_last(w.graph, folder.path, before), 2);
    take_runs("Slow");
    w.graph.nodes[two].params[Wiring::param(*w.graph.nodes[two].type, "value")] = {1.0};
    w.graph.nodes[two].params[Wiring::param(*w.graph.nodes[two].type, "whole")] = {std::int64_t{1}};
    EXPECT_EQ(cook_last(w.graph, folder.path, after), 2);
    EXPECT_EQ(take_runs("Slow"), 0) << "found by content";
    take_runs("Constant");
    EXPECT_EQ(cook_last(w.graph, folder.path), 2);
    EXPECT_EQ(take_runs("Constant"), 0) << "and from now on by its key";
    DiskCache cache(folder.path, plenty, nullptr);
    EXPECT_NE(before[slow], after[slow]);
    EXPECT_TRUE(cache.holds(before[slow]) && cache.holds(after[slow])) << "one result, two keys";
    // Of the others there is what a busy machine held up for as long as what is worth storing.
    std::size_t others = 0;
    for (const Key& key : {before[two], after[two], before[sum], after[sum]}) {
        others += cache.holds(key);
    }
    EXPECT_EQ(cache.use().records, 2 + others);
    EXPECT_EQ(cache.verify().bad, 0u);
    cache.shrink(0, 0);
    EXPECT_EQ(cache.use().records, 0u);
    EXPECT_TRUE(files_in(folder.path / "5/same").empty());
}

// Each writes it before it hears of the other's, and tidies up when it ends.
TEST(DiskCache, AResultOfTwoProcessesKeepsBothItsNames)
{
    const toys::Folder folder;
    const Key key{1, 1}, same{2, 2};
    {
        DiskCache one(folder.path, plenty, nullptr), two(folder.path, plenty, nullptr);
        for (DiskCache* cache : {&one, &two}) {
            cache->store(key, numbers(10), same);
            cache->flush();
        }
    }
    DiskCache cache(folder.path, plenty, nullptr);
    EXPECT_NE(cache.load(key, slow()), nullptr);
    EXPECT_NE(cache.load_same(same, slow()), nullptr);
}

// Numbers that pack well, by fours and by eights, and such that do not, over chunk borders.
TEST(DiskCache, ContentsComeBackHoweverTheyPack)
{
    const toys::Folder folder;
    ReadBuffers buffers;
    std::mt19937 random(7);
    for (const unsigned size : {0u, 1u, 255u, 256u, 262'143u, 262'144u, 262'145u, 3'000'001u}) {
        for (int kind = 0; kind < 4; ++kind) {
            std::string bytes(size, '\0');
            for (std::size_t i = 0; i < size; ++i) {
                const bool high = kind == 0 ? i % 4 == 3 : kind == 1 ? i % 8 > 1 : kind == 2;
                bytes[i] = static_cast<char>(high ? 'x' : random());
            }
            const fs::path path = folder.path / "file";
            const Wrote wrote = write_cache_file(path, FileKind::content, {{7, 8}, {}}, bytes);
            EXPECT_EQ(wrote.error, 0);
            EXPECT_EQ(wrote.size, size_on_disk(path));
            std::string damage;
            const auto back = read_cache_file(path, FileKind::content, {7, 8}, buffers, damage);
            ASSERT_TRUE(back) << damage;
            EXPECT_EQ(back->view(), bytes) << size << ' ' << kind;
            EXPECT_FALSE(read_cache_file(path, FileKind::content, {7, 9}, buffers, damage));
            EXPECT_EQ(damage, "stored under another name");
            const bool packs = size > 1'000'000 && (kind == 1 || kind == 2);
            EXPECT_TRUE(!packs || wrote.size < size / 2) << wrote.size;
        }
    }
}

TEST(DiskCache, ADamagedCacheChangesNoResult)
{
    std::mt19937 random(5);
    const toys::Folder folder;
    const Wiring w = slow_simulation(4);
    const double first = cook_last(w.graph, folder.path);
    for (int round = 0; round < 10; ++round) {
        for (const fs::path& file : files_in(folder.path)) {
            if (random() % 2) flip_bit(file, random() % (fs::file_size(file) * 8));
        }
        EXPECT_EQ(cook_last(w.graph, folder.path), first);
    }
}

TEST(DiskCache, ManyProcessesShareOneFolder)
{
    const toys::Folder folder;
    const Wiring w = slow_simulation(5);
    const double expected = cook_last(w.graph, folder.path / "alone");
    std::vector<pid_t> children;
    for (int i = 0; i < 4; ++i) {
        const pid_t child = ::fork();
        if (child == 0) {
            // Threads do not live on in a forked child: it starts afresh with a cache of its own.
            DiskCache cache(folder.path / "shared", plenty, nullptr);
            bool good = true;
            for (std::uint64_t k = 0; k < 50; ++k) {
                if (const SharedResult found = cache.load({k, 9}, slow())) {
                    good = good && all_of(found) == all_of(numbers(500, double(k)));
                }
                cache.store({k, 9}, numbers(500, double(k)));
            }
            cache.flush();
            ::_exit(good ? 0 : 1);
        }
        children.push_back(child);
    }
    for (const pid_t child : children) {
        int status = 0;
        ::waitpid(child, &status, 0);
        EXPECT_EQ(status, 0);
    }
    DiskCache cache(folder.path / "shared", plenty, nullptr);
    EXPECT_EQ(cache.verify().bad, 0u);
    EXPECT_EQ(cache.use().records, 50u);
    EXPECT_EQ(cook_last(w.graph, folder.path / "shared"), expected);
}

TEST(DiskCache, AKilledWriterLeavesNothingHalf)
{
    const toys::Folder folder;
    std::mt19937 random(1);
    for (int round = 0; round < 10; ++round) {
        const pid_t child = ::fork();
        if (child == 0) {
            DiskCache cache(folder.path, plenty, nullptr);
            for (std::uint64_t k = 0;; ++k) cache.store({k, 0}, numbers(20'000, double(k)));
        }
        ::usleep(1000 + static_cast<unsigned>(random() % 20'000));
        ::kill(child, SIGKILL);
        ::waitpid(child, nullptr, 0);
    }
    Warnings warnings;
    DiskCache cache(folder.path, plenty, warnings.take());
    for (std::uint64_t k = 0; k < 1000; ++k) {
        if (const SharedResult found = cache.load({k, 0}, slow())) {
            EXPECT_EQ(all_of(found), all_of(numbers(20'000, double(k))));
        }
    }
    EXPECT_TRUE(warnings.all.empty());
}

TEST(DiskCache, SideFilesAreKnownToTheNextProcess)
{
    const toys::Folder folder;
    const auto path = folder.write("a.txt", "5 b.txt");
    folder.write("b.txt", "10");
    Wiring w;
    const auto read = w.add("ReadNumber", {}, {{"path", {path.string()}}});
    w.add("Slow", {{"value", {read}}}, {{"seconds", {4e-3}}});
    const auto sum = w.add("Sum");
    w.graph.nodes[sum].inputs[0] = {{1, 1}};
    EXPECT_EQ(cook_last(w.graph, folder.path / "cache"), 15);
    take_runs("ReadNumber"), take_runs("Slow");
    EXPECT_EQ(cook_last(w.graph, folder.path / "cache"), 15);
    EXPECT_EQ(take_runs("Slow"), 0);
    EXPECT_EQ(take_runs("ReadNumber"), 0);
    folder.write("b.txt", "20");
    EXPECT_EQ(cook_last(w.graph, folder.path / "cache"), 25);
}

TEST(DiskCache, SideFilesOfAnotherNameAreNotTakenForThoseOfAFile)
{
    const toys::Folder folder;
    folder.write("red.more", "10");
    folder.write("green.more", "20");
    take_runs("ReadNumber");
    for (int again = 0; again < 2; ++again) {
        for (const char* name : {"red", "green"}) {
            const auto path = folder.write(std::string(name) + ".txt", "5 *.more");
            Wiring w;
            const auto read = w.add("ReadNumber", {}, {{"path", {path.string()}}});
            const auto slow = w.add("Slow", {{"value", {read}}}, {{"seconds", {4e-3}}});
            const auto sum = w.add("Sum");
            w.graph.nodes[sum].inputs[0] = {{slow, 1}};
            EXPECT_EQ(cook_last(w.graph, folder.path / "cache"), name[0] == 'r' ? 15 : 25);
        }
        EXPECT_EQ(take_runs("ReadNumber"), again == 0 ? 2 : 0);
    }
}

TEST(DiskCache, AProcessOfTheSameNumberOnAnotherMachineIsNotInTheWay)
{
    // Two machines that share a folder both have a process of this number: the other one is writing
    // the same file, under the names that this one would take next.
    const toys::Folder folder;
    const fs::path file = folder.path / "file";
    for (int n = 0; n < 3000; ++n) {
        std::ofstream(file.string() + ".aspic-" + std::to_string(::getpid()) + "-" +
                      std::to_string(n) + "~")
            << "theirs";
    }
    const std::string_view mine = "mine";
    EXPECT_EQ(write_whole_file(file, {{mine}}).error, 0);
    EXPECT_EQ(toys::bytes_of(file), "mine");
    EXPECT_EQ(files_in(folder.path).size(), 3001u) << "theirs are all there";
}

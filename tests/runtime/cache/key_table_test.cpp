#include "runtime/cache/key_table.hpp"

#include "runtime/cache/memory_cache.hpp"
#include "runtime/cook/short_list.hpp"

#include <gtest/gtest.h>

#include <map>
#include <random>

using namespace runtime;

TEST(KeyTable, RandomInsertionsAndRemovalsAreThoseOfAMap)
{
    std::mt19937 random(5);
    std::map<Key, std::uint32_t> expected;
    std::vector<Key> keys;  // by place
    KeyTable table;
    const auto find = [&](const Key& key) {
        return table.find(key, [&](std::uint32_t place) { return keys[place]; });
    };
    for (int i = 0; i < 20'000; ++i) {
        // Few different low halves, so that runs of slots are long and marks collide.
        const Key key{random() % 97, random() % 7};
        const auto known = expected.find(key);
        ASSERT_EQ(find(key), known == expected.end() ? KeyTable::none : known->second);
        if (known != expected.end()) {
            table.erase(key, known->second);
            expected.erase(known);
        } else if (i % 3000 < 2000) {
            expected[key] = static_cast<std::uint32_t>(keys.size());
            table.insert(key, static_cast<std::uint32_t>(keys.size()));
            keys.push_back(key);
        }
        ASSERT_EQ(table.size(), expected.size());
    }
    for (const auto& [key, place] : expected) EXPECT_EQ(find(key), place);
}

TEST(KeyTable, AnEmptyOneFindsNothing)
{
    EXPECT_EQ(KeyTable().find({1, 2}, [](std::uint32_t) { return Key{}; }), KeyTable::none);
}

TEST(ShortList, HoldsAnyNumberAndMoves)
{
    for (int count = 0; count < 40; ++count) {
        ShortList<int> few;
        for (int i = 0; i < count; ++i) few.push_back(i);
        ShortList<int> moved = std::exchange(few, {});
        EXPECT_TRUE(few.empty());
        ASSERT_EQ(moved.size(), static_cast<std::size_t>(count));
        for (int i = 0; i < count; ++i) EXPECT_EQ(moved[static_cast<std::size_t>(i)], i);
        few = std::move(moved);
        EXPECT_EQ(few.end() - few.begin(), count);
        few.clear();
        EXPECT_TRUE(few.empty());
    }
}

TEST(MemoryCache, ResultsThatAreCostlyForTheirSizeStay)
{
    const auto result = [](double seconds, std::size_t bytes) {
        auto made = std::make_shared<Result>();
        made->seconds = seconds, made->bytes = bytes;
        return made;
    };
    MemoryCache cache(100'000);
    const Key dear{1, 1};
    EXPECT_TRUE(cache.insert(dear, result(1, 1000)).empty());
    for (std::uint64_t i = 0; i < 1000; ++i) {
        const Key key{i * 7919, 2};
        for (const auto& gone : cache.insert(key, result(1e-6, 500))) {
            EXPECT_EQ(gone->bytes, 500u);
        }
        EXPECT_TRUE(cache.holds(key)) << "what just came is the last to go";
        EXPECT_LE(cache.bytes(), cache.budget());
    }
    EXPECT_TRUE(cache.find(dear));
    EXPECT_FALSE(cache.find({0, 2}));
    // Another result of the same key takes the place of the first.
    EXPECT_EQ(cache.insert(dear, result(2, 1000)).size(), 1u);
    EXPECT_EQ(cache.find(dear)->seconds, 2);
}

#include "graph/types/codec.hpp"
#include "tests/graph/content_shelf.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace {

struct Inner {
    std::string name;
    std::vector<Eigen::Vector3f> points;
    bool operator==(const Inner&) const = default;
};
enum class Kind : std::uint8_t { a, b };
struct Outer {
    int number = 0;
    Kind kind = Kind::a;
    bool yes = false;
    double real = 0;
    std::array<std::uint32_t, 2> pair{};
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<Inner> inners;
    std::shared_ptr<const Inner> shared, none;
    std::optional<double> maybe, nothing;
    std::map<std::string, int> tree;
    Eigen::Affine3d pose = Eigen::Affine3d::Identity();
    std::filesystem::path path;
    std::vector<bool> bits;
};
struct OneMore {
    std::string name;
    std::vector<Eigen::Vector3f> points;
    int more = 0;
};

// Nothing but what was worked out from its numbers.
class Summed {
public:
    using Source = std::vector<int>;
    Summed() = default;
    explicit Summed(Source numbers) : numbers_(std::move(numbers))
    {
        for (const int n : numbers_) sum_ += n;
    }
    const Source& source() const { return numbers_; }
    int sum() const { return sum_; }

private:
    Source numbers_;
    int sum_ = 0;
};

template <class T> T round_trip(const T& value, ContentShelf& shelf)
{
    graph::Encoder e = shelf.encoder();
    encode(value, e);
    graph::Decoder d = shelf.decoder(e.bytes);
    T back;
    decode(d, back);
    EXPECT_EQ(d.left(), 0u) << "everything written is read";
    return back;
}

std::string layout(auto value)
{
    std::string text;
    graph::layout_of<decltype(value)>(text);
    return text;
}

}  // namespace

TEST(Codec, AStructOfEverythingComesBackAsItWas)
{
    Outer o;
    o.number = -7, o.kind = Kind::b, o.yes = true, o.real = 1e-300;
    o.pair = {3, 4}, o.triangles = {{1, 2, 3}, {4, 5, 6}};
    o.inners = {{"x", {{1, 2, 3}}}, {"", {}}};
    o.shared = std::make_shared<const Inner>(Inner{"shared", {{4, 5, 6}, {7, 8, 9}}});
    o.maybe = 0.5, o.tree = {{"a", 1}, {"b", 2}}, o.path = "a/b.txt";
    o.pose.translation() = Eigen::Vector3d(1, 2, 3);
    o.bits = {true, false, true};
    ContentShelf shelf;
    const Outer back = round_trip(o, shelf);
    EXPECT_EQ(back.number, -7);
    EXPECT_EQ(back.kind, Kind::b);
    EXPECT_TRUE(back.yes);
    EXPECT_EQ(back.real, 1e-300);
    EXPECT_EQ(back.pair, o.pair);
    EXPECT_EQ(back.triangles, o.triangles);
    EXPECT_EQ(back.inners, o.inners);
    EXPECT_EQ(*back.shared, *o.shared);
    EXPECT_EQ(back.none, nullptr);
    EXPECT_EQ(back.maybe, 0.5);
    EXPECT_FALSE(back.nothing.has_value());
    EXPECT_EQ(back.tree, o.tree);
    EXPECT_EQ(back.pose.matrix(), o.pose.matrix());
    EXPECT_EQ(back.path, o.path);
    EXPECT_EQ(back.bits, o.bits);
}

TEST(Codec, WhatIsWorkedOutIsWorkedOutAnewAndNotStored)
{
    ContentShelf shelf;
    EXPECT_EQ(round_trip(Summed({3, 4, 5}), shelf).sum(), 12);
    const auto shared = std::make_shared<const Summed>(std::vector<int>{1, 2});
    EXPECT_EQ(round_trip(shared, shelf)->sum(), 3);
    graph::Encoder made = shelf.encoder(), source = shelf.encoder();
    encode(Summed({3, 4, 5}), made);
    encode(std::vector<int>{3, 4, 5}, source);
    EXPECT_EQ(made.bytes, source.bytes);
    EXPECT_NE(layout(Summed()), layout(std::vector<int>()));
}

TEST(Codec, NumbersKeepEveryBit)
{
    const std::vector<double> odd{0.0, -0.0, std::nan("1"), INFINITY, 5e-324};
    ContentShelf shelf;
    const auto back = round_trip(odd, shelf);
    EXPECT_EQ(std::memcmp(back.data(), odd.data(), sizeof(double) * odd.size()), 0);
}

TEST(Codec, ArraysOfAnyLengthComeBack)
{
    ContentShelf shelf;
    for (const unsigned n : {0u, 1u, 15u, 4095u, 4096u, 4097u, 700'000u}) {
        std::vector<Eigen::Vector3f> v(n);
        for (std::size_t i = 0; i < n; ++i) v[i].setConstant(static_cast<float>(i) * 0.37f);
        EXPECT_EQ(round_trip(v, shelf), v) << n;
        std::vector<std::uint16_t> u(n, 0x1234);
        EXPECT_EQ(round_trip(u, shelf), u) << n;
        std::vector<std::uint8_t> b(n, 7);
        EXPECT_EQ(round_trip(b, shelf), b) << n;
    }
}

// A sink sees the bytes that would have gathered, however they are cut.
TEST(Codec, ASinkGetsTheSameBytes)
{
    ContentShelf shelf;
    for (const unsigned n : {0u, 3u, 4000u, 5000u, 100'000u}) {
        const std::vector<Inner> value{{std::string(n, 'x'), {{1, 2, 3}}}, {"y", {n, {4, 5, 6}}}};
        graph::Encoder whole = shelf.encoder(), cut = shelf.encoder();
        std::string taken;
        cut.sink = [&](const void* data, std::size_t size) {
            taken.append(static_cast<const char*>(data), size);
        };
        encode(value, whole);
        encode(value, cut);
        cut.drain();
        EXPECT_EQ(taken, whole.bytes) << n;
    }
}

TEST(Codec, AnyCutShortIsAnErrorAndNeverACrash)
{
    ContentShelf shelf;
    graph::Encoder e = shelf.encoder();
    encode(std::vector<Inner>{{"name", {{1, 2, 3}}}, {"other", {}}}, e);
    for (std::size_t n = 0; n < e.bytes.size(); ++n) {
        graph::Decoder d = shelf.decoder(std::string_view(e.bytes).substr(0, n));
        std::vector<Inner> back;
        EXPECT_THROW(decode(d, back), std::runtime_error) << n;
    }
}

TEST(Codec, AClaimOfMoreThanThereIsAllocatesNothing)
{
    const std::uint64_t huge = std::uint64_t{1} << 62;
    std::string bytes(8, '\0');
    std::memcpy(bytes.data(), &huge, 8);
    ContentShelf shelf;
    graph::Decoder d = shelf.decoder(bytes);
    std::vector<double> back;
    EXPECT_THROW(decode(d, back), std::runtime_error);
    graph::Decoder text = shelf.decoder(bytes);
    std::string s;
    EXPECT_THROW(decode(text, s), std::runtime_error);
}

TEST(Codec, TheLayoutTellsStructsApart)
{
    EXPECT_NE(layout(Inner{}), layout(OneMore{}));
    EXPECT_NE(layout(std::vector<float>()), layout(std::vector<double>()));
    EXPECT_NE(layout(std::vector<int>()), layout(std::vector<unsigned>()));
    EXPECT_EQ(layout(Inner{}), layout(Inner{}));
    EXPECT_EQ(layout(std::vector<Eigen::Vector3f>()), "vector(eigen(f4)3x1)");
}

TEST(Codec, WhatIsNotPlainIsNotStorable)
{
    static_assert(graph::Storable<Outer>);
    static_assert(!graph::Storable<std::unique_ptr<int>>);
    static_assert(!graph::Storable<std::function<void()>>);
    static_assert(!graph::Storable<int*>);
}

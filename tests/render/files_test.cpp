// Pictures as files: PNG, contact sheets, video.

#include "render/contact_sheet.hpp"
#include "render/png.hpp"
#include "render/video.hpp"

#include <cstdlib>
#include <fstream>
#include <gtest/gtest.h>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace {

namespace fs = std::filesystem;
using render::Image;

// A picture in which no two pixels are alike.
Image pattern(int width, int height)
{
    Image image{width, height, {}};
    for (int y = 0; y < height; ++y) {
        for (int x = 0; x < width; ++x) {
            for (const int v : {x, y, x * 7 + y * 13, 255}) {
                image.rgba.push_back(static_cast<std::uint8_t>(v));
            }
        }
    }
    return image;
}

Image flat(int width, int height, std::uint8_t level)
{
    Image image{width, height, {}};
    image.rgba.assign(std::size_t(4 * width * height), level);
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    return image;
}

Image decoded(const std::vector<std::uint8_t>& bytes)
{
    Image image;
    int channels = 0;
    stbi_uc* pixels = stbi_load_from_memory(bytes.data(), int(bytes.size()), &image.width,
                                            &image.height, &channels, 4);
    if (!pixels) return {};
    image.rgba.assign(pixels, pixels + 4 * image.width * image.height);
    stbi_image_free(pixels);
    return image;
}

// A folder of one test's own, gone at its end.
struct Folder {
    fs::path path;
    explicit Folder(const std::string& name)
        : path(fs::temp_directory_path() / ("aspic_" + name + std::to_string(std::rand())))
    {
        fs::create_directories(path);
    }
    ~Folder() { fs::remove_all(path); }
};

TEST(Png, GivesBackEveryPixel)
{
    for (const auto& [w, h] : {std::pair{1, 1}, {3, 2}, {257, 130}}) {
        const Image image = pattern(w, h);
        const Image back = decoded(render::encode_png(image));
        EXPECT_EQ(back.width, w);
        EXPECT_EQ(back.rgba, image.rgba);
    }
    Image clear = pattern(31, 17);
    clear.rgba[7] = 100;  // an alpha
    EXPECT_EQ(decoded(render::encode_png(clear)).rgba, clear.rgba);
}

TEST(Png, RefusesWhatHasNoPixels)
{
    EXPECT_THROW(render::encode_png({}), std::invalid_argument);
    EXPECT_THROW(render::encode_png({4, 4, {1, 2, 3}}), std::invalid_argument);
    EXPECT_THROW(render::encode_png({-1, 4, {}}), std::invalid_argument);
}

// Before it looks at them: 4 x 8,192 x 61,100 bytes are 2.002e9.
TEST(Png, RefusesMorePixelsThanCanBeCounted)
{
    const auto told = [](int width, int height) {
        try {
            render::encode_png({width, height, {}});
        } catch (const std::invalid_argument& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(told(8192, 61'100).find("8192 x 61100 pixels has more than the 2 GB"),
              std::string::npos);
    EXPECT_NE(told(8192, 61'100).find("more columns or a smaller width"), std::string::npos);
    EXPECT_NE(told(1, 500'000'000).find("2 GB"), std::string::npos) << "each row has a filter";
    EXPECT_NE(told(8192, 61'000).find("bytes to be written, it has 0"), std::string::npos);
}

TEST(Png, MakesFoldersAndLeavesNothingBesideTheFile)
{
    const Folder folder("png");
    const fs::path path = folder.path / "a" / "b.png";
    render::write_png(path, pattern(9, 9));
    render::write_png(path, pattern(5, 5));  // over it
    EXPECT_EQ(std::distance(fs::directory_iterator(path.parent_path()), {}), 1);
    std::ifstream file(path, std::ios::binary);
    const std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(decoded(bytes).rgba, pattern(5, 5).rgba);
    // A file stands where a folder would have to be.
    EXPECT_THROW(render::write_png(path / "c.png", pattern(2, 2)), std::runtime_error);
}

TEST(ContactSheet, SpreadsFramesEvenlyWithBothEnds)
{
    EXPECT_EQ(render::spread_frames(1, 120, 4), (std::vector<int>{1, 41, 80, 120}));
    EXPECT_EQ(render::spread_frames(5, 7, 12), (std::vector<int>{5, 6, 7}));
    EXPECT_EQ(render::spread_frames(3, 3, 4), (std::vector<int>{3}));
    EXPECT_EQ(render::spread_frames(1, 10, 1), (std::vector<int>{1}));
    EXPECT_TRUE(render::spread_frames(2, 1, 4).empty());
}

// A study's labels say settings, error and time: several times as much as a tile is wide.
TEST(ContactSheet, ALongLabelTakesMoreLinesAndStaysBelowItsTile)
{
    const Image dark = flat(64, 32, 40);
    const std::string label = "sim.step.substeps=2 sim.lattice.half_width=1  error 0.17 (37 %)";
    const Image alone = render::contact_sheet({{&dark, label}, {&dark, ""}}, 2, 400);
    const Image sheet = render::contact_sheet({{&dark, ""}, {&dark, ""}}, 2, 400);
    EXPECT_GT(alone.height, sheet.height);
    // Tiles are 197 wide with gaps of 2, as high as 98 or 99: nothing but the ground below the
    // second one, which has no label.
    for (int y = 102; y < alone.height; ++y) {
        for (int x = 201; x < 400; ++x) {
            ASSERT_LT(int(alone.rgba[std::size_t(4 * (y * 400 + x))]), 40) << x << ' ' << y;
        }
    }
    int lit = 0;
    for (int y = 102; y < alone.height; ++y) {
        for (int x = 2; x < 199; ++x) lit += alone.rgba[std::size_t(4 * (y * 400 + x))] > 99;
    }
    EXPECT_GT(lit, 500) << "it is below its own";
    // One word that is wider than the tile is cut.
    const Image cut = render::contact_sheet({{&dark, std::string(200, 'm')}, {&dark, ""}}, 2, 400);
    EXPECT_EQ(cut.height, sheet.height);
    EXPECT_LT(int(cut.rgba[std::size_t(4 * (110 * 400 + 300))]), 40);
}

TEST(ContactSheet, HoldsItsTilesInRows)
{
    const Image dark = flat(64, 32, 40), light = flat(64, 32, 220);
    const Image sheet = render::contact_sheet({{&dark, "a"}, {&light, "b"}, {&light, ""}}, 2, 320);
    EXPECT_EQ(sheet.width, 320);
    const auto at = [&](int x, int y) { return int(sheet.rgba[std::size_t(4 * (y * 320 + x))]); };
    EXPECT_EQ(at(80, 40), 40);  // tiles are 157 wide with gaps of 2, so 78 or 79 high
    EXPECT_EQ(at(240, 40), 220);
    EXPECT_EQ(at(80, sheet.height - 40), 220);
    EXPECT_LT(at(240, sheet.height - 40), 40);  // there is no fourth
    EXPECT_THROW(render::contact_sheet({}, 2, 320), std::invalid_argument);
    EXPECT_THROW(render::contact_sheet({{&dark, "a"}, {&dark, "b"}}, 2, 12), std::invalid_argument);
}

// Black and white lines a pixel wide turn into the grey that sends out half the light: sRGB 188.
TEST(ContactSheet, ScalesInLinearLight)
{
    Image lines = flat(64, 64, 0);
    for (int i = 0; i < 64 * 64; ++i) {
        if (i % 2) lines.rgba[std::size_t(4 * i)] = 255;
    }
    EXPECT_NEAR(render::resized(lines, 16, 16).rgba[4 * (8 * 16 + 8)], 188, 3);
}

TEST(Video, IsMadeOfOddPicturesToo)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const Folder folder("video");
    std::vector<fs::path> pictures;
    for (int i = 0; i < 5; ++i) {
        pictures.push_back(folder.path / ("it's " + std::to_string(i) + ".png"));
        render::write_png(pictures.back(), pattern(33, 21));
    }
    const fs::path path = folder.path / "out" / "video.mp4";
    ASSERT_TRUE(render::write_video(path, pictures, 24, 23));
    EXPECT_GT(fs::file_size(path), 500u);
    EXPECT_EQ(std::distance(fs::directory_iterator(path.parent_path()), {}), 1);
    const std::string count = "test \"$(ffprobe -v error -count_frames -show_entries "
                              "stream=nb_read_frames,width,height,r_frame_rate -of csv=p=0 '" +
                              path.string() + "')\" = 32,20,24/1,5";
    EXPECT_EQ(std::system(count.c_str()), 0);
}

// The pixels of all frames, red, green and blue, as the video's own tags say; none where it cannot
// be decoded.
std::vector<char> decoded(const fs::path& video)
{
    const fs::path raw = video.string() + ".raw";
    const std::string decode =
        "ffmpeg -loglevel error -i '" + video.string() +
        "' -vf scale=in_color_matrix=bt709:in_range=tv -f rawvideo -pix_fmt rgb24 '" +
        raw.string() + "'";
    if (std::system(decode.c_str()) != 0) return {};
    std::ifstream in(raw, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

TEST(Video, OfOddPicturesKeepsThePixelsThatItHolds)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const Folder folder("stripes");
    render::Image image{33, 21, {}};
    for (int i = 0; i < 33 * 21; ++i) {
        const std::uint8_t grey = i % 33 % 2 == 0 ? 220 : 40;
        image.rgba.insert(image.rgba.end(), {grey, grey, grey, 255});
    }
    const fs::path picture = folder.path / "0.png", video = folder.path / "v.mp4";
    render::write_png(picture, image);
    ASSERT_TRUE(render::write_video(video, {picture}, 24, 1));
    const std::vector<char> bytes = decoded(video);
    ASSERT_EQ(bytes.size(), std::size_t(32 * 20 * 3));
    for (std::size_t x = 0; x < 32; ++x) {
        EXPECT_NEAR(std::uint8_t(bytes[(10 * 32 + x) * 3 + 1]), x % 2 == 0 ? 220 : 40, 6) << x;
    }
}

// Five plain colours, decoded as the video's own tags say: 8-bit video levels are 255 / 219 of a
// level wide, so each of them comes back within 2 of 255.
TEST(Video, HasTheColoursOfItsPictures)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const Folder folder("colours");
    const std::array<std::array<std::uint8_t, 3>, 5> colours{
        {{200, 40, 30}, {30, 160, 60}, {40, 60, 190}, {230, 200, 60}, {128, 128, 128}}};
    std::vector<fs::path> pictures;
    for (const auto& c : colours) {
        render::Image image{32, 32, {}};
        for (int i = 0; i < 32 * 32; ++i)
            image.rgba.insert(image.rgba.end(), {c[0], c[1], c[2], 255});
        pictures.push_back(folder.path / (std::to_string(pictures.size()) + ".png"));
        render::write_png(pictures.back(), image);
    }
    const fs::path video = folder.path / "v.mp4";
    ASSERT_TRUE(render::write_video(video, pictures, 24, 4));
    const std::string tags =
        "test \"$(ffprobe -v error -show_entries stream=color_space,color_range "
        "-of csv=p=0 '" +
        video.string() + "')\" = tv,bt709";
    EXPECT_EQ(std::system(tags.c_str()), 0);
    const std::vector<char> bytes = decoded(video);
    ASSERT_EQ(bytes.size(), colours.size() * 32 * 32 * 3);
    for (std::size_t i = 0; i < colours.size(); ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            const auto found = std::uint8_t(bytes[(i * 32 * 32 + 16 * 32 + 16) * 3 + k]);
            EXPECT_NEAR(found, colours[i][k], 2) << i << ' ' << k;
        }
    }
}

TEST(Video, SaysWhatFfmpegSays)
{
    if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) GTEST_SKIP() << "there is no ffmpeg";
    const Folder folder("novideo");
    try {
        render::write_video(folder.path / "v.mp4", {folder.path / "missing.png"}, 24, 23);
        FAIL();
    } catch (const std::runtime_error& error) {
        EXPECT_NE(std::string(error.what()).find("missing.png"), std::string::npos) << error.what();
    }
    EXPECT_TRUE(fs::is_empty(folder.path));
    EXPECT_THROW(render::write_video(folder.path / "v.mp4", {}, 24, 23), std::invalid_argument);
    EXPECT_THROW(render::write_video(folder.path / "v.mp4", {"x.png"}, 0, 23),
                 std::invalid_argument);
}

TEST(Video, WithoutFfmpegThereIsNone)
{
    const Folder folder("nopath");
    const std::string path = std::getenv("PATH");
    setenv("PATH", folder.path.c_str(), 1);
    EXPECT_FALSE(render::write_video(folder.path / "v.mp4", {"x.png"}, 24, 23));
    setenv("PATH", path.c_str(), 1);
}

}  // namespace

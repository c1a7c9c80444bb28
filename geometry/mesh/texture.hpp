#pragma once

// A picture that lies on faces, kept as the bytes of its file: they are what is written again, what
// says whether two are the same, and a tenth of the pixels.

#include "geometry/base/picture_file.hpp"
#include "geometry/mesh/texture_use.hpp"

#include <memory>
#include <string>

namespace geometry {

class Texture {
public:
    struct Source {
        std::string name;  // of the file, without folders: "wood.png"
        std::string file;  // its bytes
    };

    Texture() = default;
    // Throws std::runtime_error as picture_size() does.
    explicit Texture(Source source);

    const Source& source() const { return source_; }
    const PictureSize& size() const { return size_; }
    std::uint64_t digest() const { return digest_; }  // of the file's bytes
    // Read once, when first asked for. Throws std::runtime_error where the file is damaged.
    const Picture& picture() const;
    // What the cache budget counts: nothing more, as all frames of a mesh share it.
    std::size_t bytes() const { return 0; }

private:
    struct Read;

    Source source_;
    PictureSize size_;
    std::uint64_t digest_ = 0;
    std::shared_ptr<Read> read_;
};

// How the alpha of a picture is best used: ignored where all of it is opaque, cutout where nearly
// all is either opaque or not there, else blended.
TextureUse::Alpha alpha_of(const Picture& picture);

// What the colours of a picture stand for, as far as they tell. heights: all are grey. normals: as
// directions, 2 c - 1, nearly all have the length 1 to within a fifth and point outwards.
enum class PictureOf { normals, heights, anything };
PictureOf told_by(const Picture& picture);

// "image/png", "image/jpeg", "image/bmp", "image/x-tga".
std::string media_type(const Texture& texture);

}  // namespace geometry

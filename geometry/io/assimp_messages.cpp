#include "geometry/io/assimp_messages.hpp"

#include "geometry/io/imported_volume.hpp"

#include <cstring>
#include <stdexcept>

namespace geometry {
namespace {

// One list of members serves both directions.
template <class Archive> void pass(Archive& a, ImportedMesh& m)
{
    a(m.name), a(m.material), a(m.positions), a(m.normals), a(m.colours), a(m.uvs), a(m.triangles),
        a(m.points), a(m.lines), a(m.segments), a(m.polygon);
}
template <class Archive> void pass(Archive& a, ImportedMaterial& m)
{
    a(m.name), a(m.colour), a(m.opacity), a(m.roughness), a(m.metallic);
    a(m.picture.path), a(m.picture.embedded), a(m.picture.wrap), a(m.picture.turned),
        a(m.opacity_picture);
    a(m.alpha), a(m.cutoff);
    a(m.normals.path), a(m.normals.embedded), a(m.normals.wrap), a(m.bump_map),
        a(m.normals_elsewhere), a(m.bump);
}
template <class Archive> void pass(Archive& a, EmbeddedPicture& p)
{
    a(p.name), a(p.file);
}
template <class Archive> void pass(Archive& a, ImportedNode& n)
{
    a(n.name), a(n.mesh), a(n.to_world), a(n.node);
}
template <class Archive> void pass(Archive& a, ImportedCamera& c)
{
    a(c.name), a(c.position), a(c.ahead), a(c.up), a(c.width_angle), a(c.half_width), a(c.aspect),
        a(c.to_world);
}
template <class Archive> void pass(Archive& a, ImportedFile& f)
{
    a(f.path), a(f.found);
}
template <class Archive> void pass(Archive& a, std::string& s)
{
    a(s);
}
template <class Archive> void pass(Archive& a, ImportedScene& s)
{
    std::uint64_t format = 0x3533'6369'7073'6120;  // another build's importer is not understood
    a(format);
    if (format != 0x3533'6369'7073'6120) throw std::runtime_error("not a scene of this version");
    a(s.meshes), a(s.materials), a(s.embedded), a(s.nodes), a(s.cameras), a(s.linear_colours),
        a(s.unit), a(s.has_axes), a(s.to_y_up), a(s.files), a(s.textures), a(s.error);
}

template <class Archive> void pass(Archive& a, ExportedFile& f)
{
    a(f.name), a(f.bytes);
}
template <class Archive> void pass(Archive& a, ExportedFiles& f)
{
    a(f.files), a(f.error);
}

template <class Archive> void pass(Archive& a, ImportedVolume& v)
{
    std::uint64_t format = 0x3130'6d75'6c6f'7620;  // as of scenes
    a(format);
    if (format != 0x3130'6d75'6c6f'7620) throw std::runtime_error("not a volume of this version");
    a(v.grid), a(v.level_set), a(v.positions), a(v.triangles), a(v.points), a(v.values), a(v.error);
}

// What is sent as its bytes.
template <class T> constexpr bool is_flat = std::is_arithmetic_v<T> || std::is_enum_v<T>;
template <class T, int R> constexpr bool is_flat<Eigen::Matrix<T, R, 1>> = true;
template <class T, std::size_t N> constexpr bool is_flat<std::array<T, N>> = true;

struct Packing {
    std::string bytes;

    template <class T> void operator()(T& value)
    {
        if constexpr (is_flat<T>) {
            bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
        } else if constexpr (requires { typename T::value_type; }) {
            std::uint64_t count = value.size();
            (*this)(count);
            if constexpr (is_flat<typename T::value_type>) {
                bytes.append(reinterpret_cast<const char*>(value.data()),
                             count * sizeof(typename T::value_type));
            } else {
                for (auto& element : value) pass(*this, element);
            }
        }
    }
};

struct Unpacking {
    const char* at;
    const char* end;

    void take(void* to, std::size_t size)
    {
        if (size > static_cast<std::size_t>(end - at)) throw std::runtime_error("it is cut short");
        if (size > 0) std::memcpy(to, at, size);
        at += size;
    }
    template <class T> void operator()(T& value)
    {
        if constexpr (std::is_same_v<T, bool>) {
            char byte = 0;
            take(&byte, 1);
            value = byte != 0;
        } else if constexpr (is_flat<T>) {
            take(&value, sizeof(T));
        } else {
            using Element = typename T::value_type;
            std::uint64_t count = 0;
            (*this)(count);
            // Every element takes a byte at least: a wrong count must not allocate the world.
            constexpr std::size_t least = is_flat<Element> ? sizeof(Element) : 1;
            if (count > static_cast<std::size_t>(end - at) / least) {
                throw std::runtime_error("it is cut short");
            }
            if constexpr (is_flat<Element>) {
                value.resize(count);
                take(value.data(), count * sizeof(Element));
            } else {
                for (std::uint64_t i = 0; i < count; ++i) pass(*this, value.emplace_back());
            }
        }
    }
};

}  // namespace

template <class T> std::string pack(const T& value)
{
    Packing packing;
    pass(packing, const_cast<T&>(value));  // packing does not change it
    return std::move(packing.bytes);
}

template <class T> T unpack(const char* bytes, std::size_t size)
{
    T value;
    Unpacking unpacking{bytes, bytes + size};
    pass(unpacking, value);
    if (unpacking.at != unpacking.end) throw std::runtime_error("something follows its end");
    return value;
}

template std::string pack(const ImportedScene&);
template std::string pack(const ExportedFiles&);
template std::string pack(const ImportedVolume&);
template ImportedScene unpack(const char*, std::size_t);
template ExportedFiles unpack(const char*, std::size_t);
template ImportedVolume unpack(const char*, std::size_t);

}  // namespace geometry

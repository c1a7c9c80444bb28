// Graphs of any nodes, changed at random, cooked for two frames: failures and warnings, never a
// crash, and nothing that is not finite.

#include "geometry/mesh/mesh.hpp"
#include "graph/document/document.hpp"
#include "nodes/registry.hpp"
#include "nodes/wire_types.hpp"
#include "runtime/cook/evaluator.hpp"
#include "runtime/cook/interrupt.hpp"
#include "tests/fuzz/change_document.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <span>
#include <stdexcept>
#include <stop_token>

namespace {

namespace fs = std::filesystem;
using fuzz::Json;

// Drawn by a process of its own, which takes most of a second under a sanitizer.
const std::set<std::string> left_out{"Render", "WriteVideo", "ContactSheet"};

// A folder with files to read, which goes when the program ends.
struct Folder {
    Folder()
    {
        path = fs::temp_directory_path() / ("cook_fuzz." + std::to_string(getpid()));
        fs::create_directories(path);
        write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
        write("open.ply",
              "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float "
              "y\nproperty float z\nelement face 1\nproperty list uchar int "
              "vertex_indices\nend_header\n0 0 0\n1 0 0\n1 0 1\n0 0 1\n4 0 1 2 3\n");
        write("points.xyz", "0 0 0\n1 0 0\n0 1 0\n0.5 0.5 0.5\n");
        write("lines.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nl 1 2 3\n");
        write("empty.obj", "");
    }
    ~Folder()
    {
        std::error_code none;
        fs::remove_all(path, none);
    }
    void write(const char* name, const char* text) const { std::ofstream(path / name) << text; }

    fs::path path;
};

const Folder& folder()
{
    static const Folder it;
    return it;
}

template <class Points> void check_finite(const Points& points, const char* what)
{
    for (const auto& p : points) {
        if (p.allFinite()) continue;
        std::cerr << what << " is not finite\n";
        std::abort();
    }
}

void check(const graph::Value& value)
{
    if (!value) return;
    const std::string type = value.type_name();
    if (type == "mesh") {
        check_finite(value.as<geometry::TriMesh>()->positions, "a mesh");
        check_finite(value.as<geometry::TriMesh>()->normals, "a normal");
    }
    if (type == "points") check_finite(value.as<geometry::Samples>()->positions, "a sample");
    if (type == "state") {
        check_finite(value.as<physics::State>()->x, "a state");
        check_finite(value.as<physics::State>()->v, "a velocity");
    }
}

struct Told : runtime::Observer {
    bool sane = false;  // no number of the document is very large

    void failed(const runtime::Failure& failure) override
    {
        // A mesh may be too large; of numbers of any use, no vertex is at no place at all.
        const std::string& what = failure.what;
        const bool nowhere = sane && what.find("is not finite: vertex") != std::string::npos &&
                             what.find("nan") != std::string::npos;
        if (what.empty() || nowhere) {
            std::cerr << what << '\n';
            std::abort();
        }
    }
    void warned(const runtime::Warning& warning) override
    {
        if (warning.text.empty()) std::abort();
    }
};

// The largest number in a document, without regard to its sign.
double largest(const Json& json)
{
    if (json.is_number()) return std::abs(json.get<double>());
    double most = 0;
    if (json.is_structured()) {
        for (const Json& child : json) most = std::max(most, largest(child));
    }
    if (json.is_string() && json.get_ref<const std::string&>().find("e200") != std::string::npos) {
        return 1e200;  // of an expression
    }
    return most;
}

void cook(const graph::Graph& graph, bool sane)
{
    static std::stop_source never;
    const runtime::Deadline deadline(1.5, never.get_token());
    runtime::Options options;
    options.threads = 2;
    options.keep_going = true;
    options.output_folder = folder().path / "out";
    options.stop = deadline.token();
    runtime::Caches caches;
    Told told;
    told.sane = sane;
    std::vector<runtime::Want> wants;
    const int first = graph.range.first;
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        if (left_out.contains(graph.nodes[n].type->name)) continue;
        for (const int frame : {first, first + 1}) wants.push_back({n, frame});
    }
    runtime::Evaluator(graph, caches, options, &told)
        .cook(wants, [](const runtime::Want&, std::span<const graph::Value> values) {
            for (const graph::Value& value : values) check(value);
        });
}

graph::Loaded load(const std::string& text)
{
    graph::LoadOptions options;
    options.max_frames = 1000;
    return graph::load_text(text, folder().path / "fuzz.json", nodes::registry(), options);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size)
{
    const graph::Loaded loaded = load({reinterpret_cast<const char*>(data), size});
    if (!loaded.ok()) return 0;
    constexpr double large = 1e9;
    const double most = largest(Json::parse(data, data + size, nullptr, false, true));
    try {
        cook(loaded.graph, most < large);
    } catch (const std::invalid_argument&) {
    } catch (const std::runtime_error&) {
    }
    return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t max_size, unsigned seed)
{
    constexpr unsigned tries = 12;  // until a document loads: the others are for document_fuzz
    const Json before = Json::parse(data, data + size, nullptr, false);
    std::string text;
    for (unsigned i = 0; i < tries; ++i) {
        Json document = before.is_object() ? before : Json{{"aspic", 1}};
        fuzz::Changes changes(nodes::registry(), left_out, seed + 7919 * i);
        for (unsigned n = 1 + seed % 3; n > 0; --n) changes.change(document);
        text = document.dump(1);
        if (text.size() <= max_size && load(text).ok()) break;
    }
    if (text.size() > max_size) return size;
    std::copy(text.begin(), text.end(), data);
    return text.size();
}

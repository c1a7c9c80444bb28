#pragma once

// Small node types and a way to wire them by hand, so that the runtime is tested without files,
// meshes or a loader.

#include "graph/document/graph.hpp"
#include "graph/types/node_builder.hpp"
#include "graph/types/standard_wires.hpp"
#include "graph/types/wire_type.hpp"
#include "runtime/cook/evaluator.hpp"

#include <atomic>
#include <fstream>
#include <map>
#include <mutex>

namespace toys {

using graph::Context;
using graph::Wire;

struct Numbers {
    std::vector<double> all;
};

}  // namespace toys

template <> inline constexpr const char* graph::wire_name<toys::Numbers> = "numbers";

namespace toys {

// How often each toy ran, by type name. The one thing in these tests that is not pure.
class Counts {
public:
    std::atomic<int>& operator[](const std::string& type)
    {
        std::lock_guard lock(mutex_);
        return counts_[type];
    }

private:
    std::mutex mutex_;
    std::map<std::string, std::atomic<int>> counts_;
};
struct Runs {
    Counts of;
};
inline Runs& runs()
{
    static Runs all;
    return all;
}
inline int take_runs(const std::string& type)
{
    return runs().of[type].exchange(0);
}

// Works for so long, or until told to stop.
inline void burn(double seconds, const std::stop_token& stop)
{
    const auto start = std::chrono::steady_clock::now();
    while (std::chrono::steady_clock::now() - start < std::chrono::duration<double>(seconds)) {
        if (stop.stop_requested()) throw graph::Cancelled();
    }
}

struct NoInputs {};
struct Number {
    double value = 0;
};

struct Constant {
    struct Inputs {
        double value = 1;
        std::int64_t whole = 0;
        Eigen::Vector3d vector{0, 0, 0};
        std::string text;
    };
    static Number run(const Inputs& in, const Context&)
    {
        ++runs().of["Constant"];
        return {in.value + static_cast<double>(in.whole) + in.vector.sum() +
                static_cast<double>(in.text.size())};
    }
};

struct Sum {
    struct Inputs {
        std::vector<Wire<double>> values;
        double bias = 0;
    };
    static Number run(const Inputs& in, const Context&)
    {
        ++runs().of["Sum"];
        double sum = in.bias;
        for (const auto& v : in.values) sum += *v;
        return {sum};
    }
};

// The frame's number, and the time.
struct Clock {
    static Number run(const NoInputs&, const Context& context)
    {
        ++runs().of["Clock"];
        return {context.frame() + 1000 * context.time()};
    }
};

// Adds its input to what it gave a frame ago, starting from `start`.
struct Accumulate {
    struct Inputs {
        Wire<double> value;
        Wire<double> before;
        double start = 0, seconds = 0;
    };
    static Number run(const Inputs& in, const Context&)
    {
        ++runs().of["Accumulate"];
        burn(in.seconds, {});
        return {(in.before ? *in.before : in.start) + *in.value};
    }
};

// How far its input went since the frame before.
struct Moved {
    struct Inputs {
        Wire<double> value;
        double scale = 1;
        Wire<double> before;
    };
    struct Outputs {
        double moved = 0, value = 0;
    };
    static Outputs run(const Inputs& in, const Context&)
    {
        ++runs().of["Moved"];
        const double value = in.scale * *in.value;
        return {in.before ? value - *in.before : 0, value};
    }
};

// All values of its input at every `step`th frame of the cook.
struct Collect {
    struct Inputs {
        std::vector<Wire<double>> values;
        std::int64_t step = 1;
    };
    struct Outputs {
        Numbers numbers;
    };
    static std::vector<int> frames(const Inputs& in, const graph::FrameRange& range)
    {
        std::vector<int> all;
        for (int f = range.first; f <= range.last; f += static_cast<int>(in.step)) all.push_back(f);
        return all;
    }
    static Outputs run(const Inputs& in, const Context& context)
    {
        ++runs().of["Collect"];
        Outputs out;
        for (std::size_t i = 0; i < in.values.size(); ++i) {
            out.numbers.all.push_back(context.gathered.at(i) * 1e6 + *in.values[i]);
        }
        return out;
    }
};

// The prepared square of `base`, times the input.
struct Scale {
    struct Inputs {
        Wire<double> base, value;
        double exponent = 2;
        std::shared_ptr<const double> power;
    };
    static double prepare(const Inputs& in)
    {
        ++runs().of["Scale.prepare"];
        return std::pow(*in.base, in.exponent);
    }
    static Number run(const Inputs& in, const Context&)
    {
        ++runs().of["Scale"];
        return {*in.power * *in.value};
    }
};

struct Fail {
    struct Inputs {
        Wire<double> value;
        double above = 0;  // fails for larger values
        std::string kind = "runtime_error";
    };
    static Number run(const Inputs& in, const Context&)
    {
        ++runs().of["Fail"];
        if (*in.value <= in.above) return {*in.value};
        if (in.kind == "bad_alloc") throw std::bad_alloc();
        if (in.kind == "int") throw 7;
        throw std::runtime_error("value " + std::to_string(static_cast<int>(*in.value)) +
                                 " is too large");
    }
};

// Reads the frame without saying so.
struct Undeclared {
    static Number run(const NoInputs&, const Context& context)
    {
        return {static_cast<double>(context.frame())};
    }
};

// Depends on something that nothing knows of.
inline std::atomic<int>& hidden()
{
    static std::atomic<int> number{1};
    return number;
}
struct Hidden {
    static Number run(const NoInputs&, const Context&) { return {double(hidden())}; }
};

// Warns of values above `above`.
struct Warns {
    struct Inputs {
        Wire<double> value;
        double above = 0;
        std::string text = "a bit thin";
    };
    static Number run(const Inputs& in, const Context& context)
    {
        const double value = in.value ? *in.value : 1;
        if (value > in.above) context.warn(in.text);
        return {value};
    }
};

// Reads a number from a file, and adds that of the file named after it: "*.more" is the one that
// is called as the file itself.
struct ReadNumber {
    struct Inputs {
        std::filesystem::path path;
    };
    static Number run(const Inputs& in, const Context& context)
    {
        ++runs().of["ReadNumber"];
        std::ifstream file(in.path);
        double number = 0;
        std::string beside;
        if (!(file >> number)) throw std::runtime_error("no number in " + in.path.string());
        if (file >> beside) {
            const auto named = std::filesystem::path(in.path).replace_extension(".more");
            const auto other = beside == "*.more" ? named : in.path.parent_path() / beside;
            context.opened(other);
            std::ifstream more(other);
            double second = 0;
            if (more >> second) number += second;
        }
        return {number};
    }
};

// Somebody edits a file while a cook goes on.
struct Rewrites {
    struct Inputs {
        Wire<double> value;
        std::string path;
    };
    static Number run(const Inputs& in, const Context&)
    {
        std::ofstream(in.path) << *in.value + 1;
        return {*in.value};
    }
};

struct WriteNumber {
    struct Inputs {
        Wire<double> value;
        std::filesystem::path path = "number.txt";
    };
    struct Outputs {
        graph::WrittenFile file;
    };
    static Outputs run(const Inputs& in, const Context& context)
    {
        ++runs().of["WriteNumber"];
        const auto path =
            context.output_folder / (std::to_string(context.frame()) + in.path.string());
        std::ofstream(path) << *in.value;
        return {{path.string()}};
    }
};

// Writes a file, and one that it is of no use without.
struct WritePair {
    static WriteNumber::Outputs run(const WriteNumber::Inputs& in, const Context& context)
    {
        auto out = WriteNumber::run(in, context);
        out.file.beside.push_back(out.file.path + ".note");
        std::ofstream(out.file.beside[0]) << "of " << *in.value;
        return out;
    }
};

// All frames in one file, each at its own place.
struct WriteRow {
    static WriteNumber::Outputs run(const WriteNumber::Inputs& in, const Context& context)
    {
        ++runs().of["WriteRow"];
        static std::mutex one;
        const std::lock_guard lock(one);
        const auto path = context.output_folder / in.path;
        {
            const std::ofstream made(path, std::ios::app);
        }  // so that it is there
        std::fstream file(path);
        file.seekp(8 * context.frame());
        file << std::to_string(*in.value).substr(0, 7) << '\n';
        return {{path.string(), {}, true}};
    }
};

// Burns `seconds` or until told to stop, and gives a value of `size` numbers.
struct Slow {
    struct Inputs {
        Wire<double> value;
        std::int64_t size = 1;
        double seconds = 0;
    };
    struct Outputs {
        Numbers numbers;
        double first = 0;
    };
    static Outputs run(const Inputs& in, const Context& context)
    {
        ++runs().of["Slow"];
        burn(in.seconds, context.stop);
        Outputs out;
        out.numbers.all.assign(static_cast<std::size_t>(in.size), *in.value);
        out.first = *in.value;
        return out;
    }
};

inline const graph::Registry& registry()
{
    static const graph::Registry all = [] {
        using graph::Variable;
        graph::Registry r;
        r.add("Constant", 1, Constant::run)
            .param("value", &Constant::Inputs::value, "A number.")
            .param("whole", &Constant::Inputs::whole, "A whole number.")
            .param("vector", &Constant::Inputs::vector, "A vector.")
            .param("text", &Constant::Inputs::text, "A text.")
            .output("value", &Number::value, "Their sum.");
        r.add("Sum", 1, Sum::run)
            .inputs("values", &Sum::Inputs::values, "Numbers.")
            .param("bias", &Sum::Inputs::bias, "Added.")
            .output("value", &Number::value, "Sum.");
        r.add("Clock", 1, Clock::run)
            .reads(Variable::frame)
            .output("value", &Number::value, "Frame.");
        r.add("Accumulate", 1, Accumulate::run)
            .input("value", &Accumulate::Inputs::value, "Added each frame.")
            .param("start", &Accumulate::Inputs::start, "Before the first frame.")
            .param("seconds", &Accumulate::Inputs::seconds, "How long a step takes.")
            .output("value", &Number::value, "Sum.")
            .previous("value", &Accumulate::Inputs::before);
        r.add("Moved", 1, Moved::run)
            .input("value", &Moved::Inputs::value, "Compared with the frame before.")
            .param("scale", &Moved::Inputs::scale, "Times this.")
            .output("moved", &Moved::Outputs::moved, "Difference.")
            .output("value", &Moved::Outputs::value, "The value.")
            .previous("value", &Moved::Inputs::before, graph::Memory::of_motion);
        r.add("Collect", 1, Collect::run)
            .gather("values", &Collect::Inputs::values, Collect::frames, "Numbers.")
            .param("step", &Collect::Inputs::step, "Every which frame.", {.min = 1})
            .output("numbers", &Collect::Outputs::numbers, "All.");
        r.add("Scale", 1, Scale::run)
            .input("base", &Scale::Inputs::base, "Prepared.")
            .input("value", &Scale::Inputs::value, "Scaled.")
            .param("exponent", &Scale::Inputs::exponent, "Of the base.")
            .prepare("power", &Scale::Inputs::power, Scale::prepare, {"base", "exponent"})
            .output("value", &Number::value, "Product.");
        r.add("Fail", 1, Fail::run)
            .input("value", &Fail::Inputs::value, "Checked.")
            .param("above", &Fail::Inputs::above, "Largest good value.")
            .param("kind", &Fail::Inputs::kind, "What is thrown.")
            .output("value", &Number::value, "The value.");
        r.add("Undeclared", 1, Undeclared::run).output("value", &Number::value, "Frame.");
        r.add("Warns", 1, Warns::run)
            .input("value", &Warns::Inputs::value, "Looked at.", graph::Need::optional)
            .param("above", &Warns::Inputs::above, "Largest value that is good.")
            .param("text", &Warns::Inputs::text, "What is said of others.")
            .output("value", &Number::value, "The value, or one.");
        r.add("Hidden", 1, Hidden::run).output("value", &Number::value, "Who knows.");
        r.add("ReadNumber", 1, ReadNumber::run)
            .path_in("path", &ReadNumber::Inputs::path, "The file.")
            .output("value", &Number::value, "What is in it.");
        r.add("Rewrites", 1, Rewrites::run)
            .input("value", &Rewrites::Inputs::value, "Handed on.")
            .param("path", &Rewrites::Inputs::path, "The file that gets the value and 1.")
            .output("value", &Number::value, "The value.");
        r.add("WriteNumber", 1, WriteNumber::run)
            .reads(Variable::frame)
            .input("value", &WriteNumber::Inputs::value, "Written.")
            .path_out("path", &WriteNumber::Inputs::path, "The file.")
            .output("file", &WriteNumber::Outputs::file, "The file.")
            .sink();
        r.add("WritePair", 1, WritePair::run)
            .reads(Variable::frame)
            .input("value", &WriteNumber::Inputs::value, "Written.")
            .path_out("path", &WriteNumber::Inputs::path, "The file.")
            .output("file", &WriteNumber::Outputs::file, "The file.")
            .sink();
        r.add("WriteRow", 1, WriteRow::run)
            .reads(Variable::frame)
            .input("value", &WriteNumber::Inputs::value, "Written.")
            .path_out("path", &WriteNumber::Inputs::path, "The file.")
            .output("file", &WriteNumber::Outputs::file, "The file.")
            .sink();
        r.add("Slow", 1, Slow::run)
            .input("value", &Slow::Inputs::value, "Repeated.")
            .param("size", &Slow::Inputs::size, "How often.", {.min = 0})
            .param("seconds", &Slow::Inputs::seconds, "How long it takes.")
            .output("numbers", &Slow::Outputs::numbers, "Copies.")
            .output("first", &Slow::Outputs::first, "The value.");
        return r;
    }();
    return all;
}

// Builds a graph node by node; inputs are named and must exist already.
class Wiring {
public:
    explicit Wiring(int last = 1) { graph.range.last = last; }

    // {"values", {a, b}}
    using Links = std::vector<std::pair<std::string, std::vector<std::uint32_t>>>;
    using Sets = std::vector<std::pair<std::string, graph::ParamValue>>;

    std::uint32_t add(const std::string& type, const Links& links = {}, const Sets& sets = {})
    {
        graph::Node node;
        node.name = type + std::to_string(graph.nodes.size());
        node.type = registry().find(type);
        node.inputs.resize(node.type->inputs.size());
        for (const auto& [port, from] : links) {
            for (std::size_t i = 0; i < node.inputs.size(); ++i) {
                if (node.type->inputs[i].name != port) continue;
                for (const std::uint32_t n : from) node.inputs[i].push_back({n, 0});
            }
        }
        for (const auto& p : node.type->params) node.params.push_back(p.fallback);
        for (const auto& [name, value] : sets) node.params[param(*node.type, name)] = value;
        graph.nodes.push_back(std::move(node));
        return static_cast<std::uint32_t>(graph.nodes.size() - 1);
    }

    void animate(std::uint32_t n, const std::string& name, std::function<double(int, double)> value,
                 int component = -1)
    {
        graph::Animated a;
        const std::size_t p = param(*graph.nodes[n].type, name);
        a.where = {static_cast<std::uint32_t>(p)};
        a.component = component;
        a.kind = graph.nodes[n].type->params[p].kind;
        a.limits = graph.nodes[n].type->params[p].limits;
        a.value = std::move(value);
        graph.nodes[n].animated.push_back(std::move(a));
    }

    static std::size_t param(const graph::NodeType& type, const std::string& name)
    {
        for (std::size_t i = 0; i < type.params.size(); ++i) {
            if (type.params[i].name == name) return i;
        }
        throw std::logic_error("no parameter " + name);
    }

    graph::Graph graph;
};

inline double number(const graph::Value& value)
{
    return *value.as<double>();
}

inline std::string bytes_of(const std::filesystem::path& file)
{
    std::ifstream in(file, std::ios::binary);
    return std::string(std::istreambuf_iterator<char>(in), {});
}

// A folder of its own for a test's files, gone when the test ends.
struct Folder {
    std::filesystem::path path;
    Folder()
    {
        std::string pattern = (std::filesystem::temp_directory_path() / "aspic-XXXXXX").string();
        if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
        path = pattern;
    }
    ~Folder()
    {
        std::error_code ignored;
        std::filesystem::remove_all(path, ignored);
    }
    std::filesystem::path write(const std::string& name, const std::string& text) const
    {
        std::filesystem::create_directories((path / name).parent_path());
        std::ofstream(path / name) << text;
        return path / name;
    }
};

// A block of cubes falls on the floor for so many frames; each frame's mesh goes to a file.
inline std::string falling_block(int last, double cube)
{
    return R"({ "aspic": 1, "frames": { "first": 1, "last": )" + std::to_string(last) +
           R"(, "fps": 24 },
  "nodes": {
    "block": { "type": "Primitive@1", "params": { "shape": "box", "centre": [0, 0.8, 0] } },
    "cubes": { "type": "Voxelize@1", "inputs": { "mesh": "block.mesh" },
               "params": { "method": "solid", "size": )" +
           std::to_string(cube) + R"(,
                           "matter": { "density": 300, "young": 300000 } } },
    "floor": { "type": "Ground@1" },
    "sim": { "type": "Simulate@3", "inputs": { "cubes": "cubes.cubes",
               "colliders": ["floor.collider"], "surface": "block.mesh" } },
    "shape": { "type": "Embed@3", "inputs": { "cubes": "cubes.cubes", "mesh": "block.mesh",
               "state": "sim.state" } },
    "files": { "type": "WriteMesh@1", "inputs": { "mesh": "shape.mesh" },
               "params": { "path": "block.####.ply" } } } })";
}

}  // namespace toys

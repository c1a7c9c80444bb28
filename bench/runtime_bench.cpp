// What the runtime itself costs, on 10,000 nodes that do next to nothing.

#include "runtime/cook/evaluator.hpp"

#include "graph/types/node_builder.hpp"
#include "graph/types/standard_wires.hpp"
#include "graph/types/wire_type.hpp"

#include <benchmark/benchmark.h>

#include <fstream>
#include <unistd.h>

namespace {

namespace fs = std::filesystem;
using graph::Wire;

struct Leaf {
    double value = 1;
};
struct Two {
    Wire<double> a, b;
    double bias = 0;
};
struct Step {
    Wire<double> a, before;
};
struct Number {
    double value = 0;
};
struct Block {
    std::vector<float> numbers;
};
struct Size {
    std::int64_t size = 1;
};
struct Blocks {
    Block block;
};

}  // namespace

template <> inline constexpr const char* graph::wire_name<Block> = "block";

namespace {

const graph::Registry& registry()
{
    static const graph::Registry all = [] {
        graph::Registry r;
        r.add<Leaf, Number>(
             "Leaf", 1, [](const Leaf& in, const graph::Context&) -> Number { return {in.value}; })
            .param("value", &Leaf::value, "")
            .output("value", &Number::value, "");
        r.add<Two, Number>("Two", 1,
                           [](const Two& in, const graph::Context&) -> Number {
                               return {*in.a + *in.b + in.bias};
                           })
            .input("a", &Two::a, "")
            .input("b", &Two::b, "")
            .param("bias", &Two::bias, "")
            .output("value", &Number::value, "");
        r.add<Step, Number>("Step", 1,
                            [](const Step& in, const graph::Context&) -> Number {
                                return {*in.a + (in.before ? *in.before : 0)};
                            })
            .input("a", &Step::a, "")
            .output("value", &Number::value, "")
            .previous("value", &Step::before);
        r.add<Size, Blocks>("Block", 1,
                            [](const Size& in, const graph::Context&) -> Blocks {
                                return {
                                    {std::vector<float>(static_cast<std::size_t>(in.size), 1.0f)}};
                            })
            .param("size", &Size::size, "")
            .output("block", &Blocks::block, "");
        return r;
    }();
    return all;
}

void add(graph::Graph& g, const char* type, std::vector<std::uint32_t> from, double parameter)
{
    graph::Node node;
    node.type = registry().find(type);
    node.name = std::string(type) + std::to_string(g.nodes.size());
    for (const std::uint32_t n : from) node.inputs.push_back({{n, 0}});
    if (!node.type->params.empty()) node.params = {{parameter}};
    g.nodes.push_back(std::move(node));
}

// Each node takes its neighbour and one further back: depth n, width as wide as it gets.
graph::Graph mesh_of(std::uint32_t n)
{
    graph::Graph g;
    add(g, "Leaf", {}, 1);
    for (std::uint32_t i = 1; i < n; ++i) add(g, "Two", {i - 1, i / 2}, i);
    return g;
}
// Each node takes its neighbour.
graph::Graph chain_of(std::uint32_t n)
{
    graph::Graph g;
    add(g, "Leaf", {}, 1);
    for (std::uint32_t i = 1; i < n; ++i) add(g, "Two", {i - 1, i - 1}, i);
    return g;
}
// All nodes independent but for the last, which sums pairs of pairs.
graph::Graph tree_of(std::uint32_t leaves)
{
    graph::Graph g;
    for (std::uint32_t i = 0; i < leaves; ++i) add(g, "Leaf", {}, i);
    for (std::uint32_t i = 0; g.nodes.size() < 2 * leaves - 1; i += 2) add(g, "Two", {i, i + 1}, 0);
    return g;
}

constexpr std::uint32_t many = 10'000;

runtime::Options threads(std::int64_t n)
{
    runtime::Options options;
    options.threads = static_cast<int>(n);
    return options;
}

void per_node(benchmark::State& state, std::size_t nodes)
{
    state.counters["per_node"] = benchmark::Counter(static_cast<double>(nodes),
                                                    benchmark::Counter::kIsIterationInvariantRate |
                                                        benchmark::Counter::kInvert);
}

// Keys of all nodes from nothing. Wanted: < 50 ns a node.
void all_keys(benchmark::State& state)
{
    const graph::Graph g = mesh_of(many);
    runtime::FileDigests files;
    runtime::SideFiles side_files;
    for (auto _ : state) {
        runtime::Keys keys(g, files, side_files, {});
        keys.aim({many - 1}, {1});
        benchmark::DoNotOptimize(keys.at(many - 1, 1));
    }
    per_node(state, many);
}
BENCHMARK(all_keys)->Unit(benchmark::kMicrosecond);

// Keys again after the first node changed, so that all of them change.
void keys_again(benchmark::State& state)
{
    graph::Graph g = mesh_of(many);
    runtime::FileDigests files;
    runtime::SideFiles side_files;
    runtime::Keys keys(g, files, side_files, {});
    double value = 0;
    for (auto _ : state) {
        g.nodes[0].params[0] = {value += 1};
        keys.edited(0);
        keys.aim({many - 1}, {1});
        benchmark::DoNotOptimize(keys.at(many - 1, 1));
    }
    per_node(state, many);
}
BENCHMARK(keys_again)->Unit(benchmark::kMicrosecond);

// Wanted: < 1 us a node beyond what the nodes do.
void cold_cook(benchmark::State& state)
{
    const graph::Graph g = state.range(1) ? tree_of(many / 2) : mesh_of(many);
    const auto last = static_cast<std::uint32_t>(g.nodes.size() - 1);
    for (auto _ : state) {
        auto caches = std::make_unique<runtime::Caches>();
        runtime::Evaluator evaluator(g, *caches, threads(state.range(0)));
        benchmark::DoNotOptimize(evaluator.pull({last, 0}, 1));
        state.PauseTiming();
        caches.reset();
        state.ResumeTiming();
    }
    per_node(state, g.nodes.size());
}

// Wanted: < 1 ms.
void nothing_changed(benchmark::State& state)
{
    const graph::Graph g = mesh_of(many);
    runtime::Caches caches;
    runtime::Evaluator evaluator(g, caches, threads(2));
    evaluator.pull({many - 1, 0}, 1);
    for (auto _ : state) benchmark::DoNotOptimize(evaluator.pull({many - 1, 0}, 1));
}
BENCHMARK(nothing_changed)->Unit(benchmark::kMicrosecond);

// The same by a new evaluator, which knows no keys yet. Wanted: < 1 ms.
void nothing_changed_anew(benchmark::State& state)
{
    const graph::Graph g = mesh_of(many);
    runtime::Caches caches;
    runtime::Evaluator(g, caches, threads(2)).pull({many - 1, 0}, 1);
    for (auto _ : state) {
        benchmark::DoNotOptimize(runtime::Evaluator(g, caches, threads(2)).pull({many - 1, 0}, 1));
    }
}
BENCHMARK(nothing_changed_anew)->Unit(benchmark::kMicrosecond);

// Wanted: < 10 us.
void edit_of_the_last_node(benchmark::State& state)
{
    graph::Graph g = mesh_of(many);
    runtime::Caches caches;
    runtime::Evaluator evaluator(g, caches, threads(2));
    evaluator.pull({many - 1, 0}, 1);
    double value = 0;
    for (auto _ : state) {
        g.nodes[many - 1].params[0] = {value += 1};
        evaluator.edited(many - 1);
        benchmark::DoNotOptimize(evaluator.pull({many - 1, 0}, 1));
    }
}
BENCHMARK(edit_of_the_last_node)->Unit(benchmark::kMicrosecond);

// Wanted: < 150 ns.
void memory_hit(benchmark::State& state)
{
    runtime::MemoryCache cache(std::size_t{1} << 30);
    std::vector<runtime::Key> keys;
    for (std::uint64_t i = 0; i < many; ++i) {
        keys.push_back(runtime::hash_bytes(&i, sizeof i));
        auto result = std::make_shared<runtime::Result>();
        result->values = {graph::Value::of(1.0)};
        [[maybe_unused]] const auto gone = cache.insert(keys.back(), result);
    }
    std::size_t i = 0;
    for (auto _ : state) {
        benchmark::DoNotOptimize(cache.find(keys[i]));
        i = (i + 7919) % many;
    }
}
BENCHMARK(memory_hit);

// Wanted: a node of a chain costs the same however long the chain is.
void deep_chain(benchmark::State& state)
{
    const graph::Graph g = chain_of(static_cast<std::uint32_t>(state.range(0)));
    const auto last = static_cast<std::uint32_t>(g.nodes.size() - 1);
    for (auto _ : state) {
        auto caches = std::make_unique<runtime::Caches>();
        runtime::Evaluator evaluator(g, *caches, threads(1));
        benchmark::DoNotOptimize(evaluator.pull({last, 0}, 1));
        state.PauseTiming();
        caches.reset();
        state.ResumeTiming();
    }
    per_node(state, g.nodes.size());
}

// The last frame of a simulation, from nothing. Wanted: a step costs the same however many.
void deep_simulation(benchmark::State& state)
{
    graph::Graph g;
    g.range.last = static_cast<int>(state.range(0));
    add(g, "Leaf", {}, 1);
    add(g, "Step", {0}, 0);
    for (auto _ : state) {
        runtime::Caches caches;
        runtime::Evaluator evaluator(g, caches, threads(1));
        benchmark::DoNotOptimize(evaluator.pull({1, 0}, g.range.last));
    }
    per_node(state, static_cast<std::size_t>(state.range(0)));
}

// Wanted for 16 MiB: < 5 ms, from the page cache, checksums included.
void disk_hit(benchmark::State& state)
{
    std::string folder = (fs::temp_directory_path() / "aspic-bench-XXXXXX").string();
    if (!mkdtemp(folder.data())) return state.SkipWithError("no folder");
    {
        runtime::DiskCache cache(folder, std::uintmax_t{1} << 40, nullptr);
        auto result = std::make_shared<runtime::Result>();
        Block block;
        for (std::int64_t i = 0; i < state.range(0) / 4; ++i) {
            // A smooth path with noise in the last bits, as positions have.
            const auto x = static_cast<double>(i) * 1e-4;
            block.numbers.push_back(static_cast<float>(std::sin(x) + 1e-3 * std::sin(x * 9973)));
        }
        result->values = {graph::Value::of(std::move(block))};
        result->bytes = static_cast<std::size_t>(state.range(0));
        cache.store({1, 1}, result);
        cache.flush();
        const graph::NodeType& type = *registry().find("Block");
        for (auto _ : state) {
            auto back = cache.load({1, 1}, type);
            if (!back) return state.SkipWithError("not stored");
            benchmark::DoNotOptimize(back);
        }
        state.SetBytesProcessed(state.iterations() * state.range(0));
        state.counters["packed"] =
            static_cast<double>(cache.use().bytes) / static_cast<double>(state.range(0));
    }
    fs::remove_all(folder);
}
BENCHMARK(disk_hit)->Arg(1 << 10)->Arg(1 << 24)->Unit(benchmark::kMicrosecond);

// Memory that the process holds for a graph and its cooked results. Wanted: < 1 kB a node.
std::size_t resident()
{
    std::size_t total = 0, pages = 0;
    std::ifstream("/proc/self/statm") >> total >> pages;
    return pages * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}
void memory_of_a_node(benchmark::State& state)
{
    for (auto _ : state) {
        const std::size_t before = resident();
        const graph::Graph g = mesh_of(100'000);
        runtime::Caches caches;
        runtime::Evaluator evaluator(g, caches, threads(1));
        evaluator.pull({99'999, 0}, 1);
        state.counters["bytes_a_node"] = static_cast<double>(resident() - before) / 100'000;
    }
}

BENCHMARK(cold_cook)
    ->ArgNames({"threads", "tree"})
    ->Args({1, 0})
    ->Args({2, 0})
    ->Args({1, 1})
    ->Args({2, 1})
    ->UseRealTime()
    ->Unit(benchmark::kMillisecond);
// Beyond 10,000 the nodes are no longer in the processor's cache; a million says whether it is that
// alone.
BENCHMARK(deep_chain)
    ->Arg(1'000)
    ->Arg(10'000)
    ->Arg(100'000)
    ->Arg(1'000'000)
    ->Unit(benchmark::kMillisecond);
BENCHMARK(deep_simulation)->Arg(1'000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond);
BENCHMARK(memory_of_a_node)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace

BENCHMARK_MAIN();

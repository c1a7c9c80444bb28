// Reading documents: text to a checked graph.

#include "graph/document/curve.hpp"
#include "graph/document/document.hpp"
#include "graph/document/expression.hpp"
#include "nodes/registry.hpp"

#include <benchmark/benchmark.h>
#include <fmt/format.h>

namespace {

// A chain of `count` moves of one grid, every tenth keyframed and every tenth an expression.
std::string chain(std::int64_t count)
{
    std::string text = R"({ "aspic": 1, "nodes": { "n0": { "type": "Primitive@1" })";
    for (std::int64_t i = 1; i < count; ++i) {
        const char* value = i % 10 == 0   ? R"({ "keys": [[1, [0, 0, 0]], [9, [1, 2, 3]]] })"
                            : i % 10 == 5 ? R"#([0, "=sin(time)", 0])#"
                                          : "[0, 1, 0]";
        text += fmt::format(",\n\"n{}\": {{ \"type\": \"Transform@1\", \"inputs\": {{ \"mesh\": "
                            "\"n{}.mesh\" }}, \"params\": {{ \"translate\": {} }} }}",
                            i, i - 1, value);
    }
    return text + " } }";
}

void load_chain(benchmark::State& state)
{
    const std::string text = chain(state.range(0));
    for (auto _ : state) {
        const graph::Loaded loaded = graph::load_text(text, "chain.json", nodes::registry());
        if (!loaded.ok()) state.SkipWithError("the chain does not load");
        benchmark::DoNotOptimize(loaded.graph.nodes.data());
    }
    state.counters["per_node"] = benchmark::Counter(static_cast<double>(state.range(0)),
                                                    benchmark::Counter::kIsIterationInvariantRate |
                                                        benchmark::Counter::kInvert);
}
BENCHMARK(load_chain)->Arg(1'000)->Arg(10'000)->Arg(100'000)->Unit(benchmark::kMillisecond);

void evaluate_expression(benchmark::State& state)
{
    const graph::Expression e = graph::Grammar().compile("0.5 * sin(2 * pi * time) + frame");
    int frame = 0;
    for (auto _ : state) {
        ++frame;
        benchmark::DoNotOptimize(e.value(frame, frame / 24.0));
    }
}
BENCHMARK(evaluate_expression);

void evaluate_curve(benchmark::State& state)
{
    std::vector<double> times, values;
    for (int i = 0; i < 100; ++i) {
        times.push_back(i * 5);
        values.push_back((i * 37) % 11);
    }
    const graph::Curve curve = graph::curve_through(times, values);
    int frame = 0;
    for (auto _ : state) benchmark::DoNotOptimize(curve.at(++frame % 500));
}
BENCHMARK(evaluate_curve);

}  // namespace

BENCHMARK_MAIN();

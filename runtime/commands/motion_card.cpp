#include "runtime/commands/motion_card.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace runtime {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

const std::vector<graph::Link>& linked(const graph::Node& node, const char* input)
{
    static const std::vector<graph::Link> none;
    for (std::size_t i = 0; i < node.type->inputs.size(); ++i) {
        if (node.type->inputs[i].name == input) return node.inputs[i];
    }
    return none;
}

// Whether a node, or one that it depends on, is another one at another frame.
bool changes(const graph::Graph& graph, std::uint32_t n)
{
    const graph::Node& node = graph.nodes[n];
    if (!node.animated.empty() || node.type->reads != 0) return true;
    for (const auto& links : node.inputs) {
        for (const graph::Link& link : links) {
            if (changes(graph, link.node)) return true;
        }
    }
    return false;
}

// Whether gravity is all that does work on the body: what holds it stays, and so does what it
// touches.
bool is_left_alone(const graph::Graph& graph, const graph::Node& node)
{
    if (!node.animated.empty() || !linked(node, "forces").empty()) return false;
    for (const char* input : {"pins", "colliders"}) {
        for (const graph::Link& link : linked(node, input)) {
            if (changes(graph, link.node)) return false;
        }
    }
    return true;
}

// Figures by frame, as Console::motion_figures has them.
using Figures = std::map<int, std::array<double, 4>>;

// Of one model more: the energies add up.
void add(const std::array<double, 4>& figures, std::array<double, 4>& all)
{
    for (std::size_t i = 0; i < 2; ++i) {
        if (!(figures[i] <= all[i])) all[i] = figures[i];  // not a number stays
    }
    for (std::size_t i = 2; i < 4; ++i) all[i] += figures[i];
}

double largest(const Figures& figures, std::size_t which)
{
    double most = 0;
    for (const auto& [frame, f] : figures) {
        if (!(f[which] <= most)) most = f[which];  // not a number stays
    }
    return most;
}

// What the energy rose by in frames in which it rose, and fell by in the others, as shares of the
// most that the body had in its motion and deformation.
std::array<double, 2> balance(const Figures& figures)
{
    double gained = 0, lost = 0, most = 0, before = unknown;
    int last = figures.empty() ? 0 : figures.begin()->first - 1;
    for (const auto& [frame, f] : figures) {
        if (frame != std::exchange(last, frame) + 1) return {unknown, unknown};  // left some out
        const double now = f[2] + f[3], step = now - before;
        most = std::max(most, f[2]);
        before = now;
        if (std::isnan(now)) return {unknown, unknown};
        if (step > 0) gained += step;
        if (step < 0) lost -= step;
    }
    return most > 0 ? std::array{gained / most, lost / most} : std::array{0.0, 0.0};
}

}  // namespace

std::vector<MotionCard> motion_cards(Evaluator& evaluator, const CookRequest& request,
                                     const Console& console, Cooked& cooked)
{
    const graph::Graph& graph = evaluator.graph();
    std::vector<MotionCard> cards;
    for (std::uint32_t n = 0; n < graph.nodes.size(); ++n) {
        const graph::Node& node = graph.nodes[n];
        if (node.type->name != "Simulate" || linked(node, "cubes").empty()) continue;
        std::vector<graph::Value> models;
        for (const graph::Link& from : linked(node, "cubes")) {
            models.push_back(evaluator.pull(from, graph.range.first));
        }
        std::vector<Want> wants;
        for (const int frame : chosen_frames(graph, request)) wants.push_back({n, frame});
        Figures figures;
        cooked = evaluator.cook(std::move(wants), [&](const Want& want,
                                                      std::span<const graph::Value> values) {
            auto& all = figures[want.frame];
            for (const graph::Value& cubes : models) {
                add(console.motion_figures(*node.type, node.params, cubes, values.front()), all);
            }
        });
        if (cooked.cancelled || figures.empty()) return {};
        auto [gained, lost] = balance(figures);
        if (!is_left_alone(graph, node)) gained = lost = unknown;
        cards.push_back({node.name,
                         figures.size(),
                         {{"solver residual, of the forces at work", largest(figures, 0)},
                          {"energy gained, of the most there was", gained},
                          {"energy lost, of the most there was", lost},
                          {"contact depth, m", largest(figures, 1)}}});
    }
    return cards;
}

}  // namespace runtime

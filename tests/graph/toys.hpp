#pragma once

// A small registry of toy node types, for tests of what is true of any node types.

#include "graph/document/document.hpp"
#include "graph/types/node_builder.hpp"
#include "graph/types/standard_wires.hpp"
#include "graph/types/wire_type.hpp"

namespace toys {

struct Dough {
    double weight = 0;
};
struct Crumbs {
    double count = 0;
};

}  // namespace toys

namespace graph {
template <> inline constexpr const char* wire_name<toys::Dough> = "dough";
template <> inline constexpr const char* wire_name<toys::Crumbs> = "crumbs";
}  // namespace graph

namespace toys {

enum class Oven { gas, wood };
enum class Grain { wheat, rye, oats };

struct Gas {
    double pressure = 2;
    int burners = 4;
};
struct Wood {
    std::string kind = "beech";
};
struct Raisin {
    Eigen::Vector3d at{0, 0, 0};
    double size = 1;
};

// Source: no inputs, every kind of plain parameter.
struct MillIn {
    double weight = 1;
    int sacks = 3;
    bool sieve = false;
    std::string label = "flour";
    Eigen::Vector3d place{0, 0, 0};
    Eigen::Vector3f tint{1, 1, 1};
    Grain grain = Grain::wheat;
    std::filesystem::path recipe;
};
struct MillOut {
    Dough dough;
    Crumbs crumbs;
};
struct KneadIn {
    graph::Wire<Dough> dough;
    graph::Wire<Crumbs> salt;
    std::vector<Raisin> raisins;
    double time = 10;
};
struct DoughOut {
    Dough dough;
};
struct BakeIn {
    std::vector<graph::Wire<Dough>> loaves;
    Oven oven = Oven::gas;
    Gas gas;
    Wood wood;
    std::filesystem::path report;
};
struct WeighIn {
    graph::Wire<Dough> dough;
};
struct WeighOut {
    double weight = 0;
};

inline MillOut mill(const MillIn& in, const graph::Context&)
{
    return {{in.weight * in.sacks}, {in.weight}};
}
inline DoughOut knead(const KneadIn& in, const graph::Context&)
{
    return {{in.dough->weight}};
}
inline DoughOut bake(const BakeIn& in, const graph::Context&)
{
    DoughOut out;
    for (const auto& loaf : in.loaves) out.dough.weight += loaf->weight;
    return out;
}
inline WeighOut weigh(const WeighIn& in, const graph::Context&)
{
    return {in.dough->weight};
}

inline graph::Registry make_registry()
{
    graph::Registry r;
    r.add("Mill", 1, mill)
        .summary("Grinds grain.", {"flour maker", "mix"})
        .param("weight", &MillIn::weight, "Of a sack.", {.min = 0, .max = 100, .unit = "kg"})
        .param("sacks", &MillIn::sacks, "How many sacks.", {.min = 1, .max = 1000})
        .param("sieve", &MillIn::sieve, "Whether the bran goes.")
        .param("label", &MillIn::label, "What stands on the sacks.")
        .param("place", &MillIn::place, "Where it stands.", {.unit = "m"})
        .colour("tint", &MillIn::tint, "The colour of the flour.")
        .choice("grain", &MillIn::grain, {"wheat", "rye", "oats"}, "What is ground.")
        .path_in("recipe", &MillIn::recipe, "How to do it.")
        .output("dough", &MillOut::dough, "All the flour.")
        .output("crumbs", &MillOut::crumbs, "What was left over.");
    r.add("Knead", 1, knead)
        .summary("Works the dough.", {"mix"})
        .input("dough", &KneadIn::dough, "What to work.")
        .input("salt", &KneadIn::salt, "What to strew in.", graph::Need::optional)
        .list(
            "raisins", &KneadIn::raisins,
            +[](graph::ParamsOf<Raisin>& p) {
                p.param("at", &Raisin::at, "Where it sits.", {.unit = "m"})
                    .param("size", &Raisin::size, "How large it is.", {.min = 0});
            },
            "Raisins to put in.")
        .param("time", &KneadIn::time, "How long.", {.min = 0, .unit = "s"})
        .output("dough", &DoughOut::dough, "The worked dough.");
    r.add("Bake", 1, bake)
        .summary("Bakes loaves.")
        .inputs("loaves", &BakeIn::loaves, "What to bake.")
        .choice("oven", &BakeIn::oven, {"gas", "wood"}, "Which oven.")
        .block("gas", &BakeIn::gas,
               +[](graph::ParamsOf<Gas>& p) {
                   p.param("pressure", &Gas::pressure, "Of the gas.", {.min = 0, .unit = "bar"})
                       .param("burners", &Gas::burners, "How many are lit.", {.min = 1, .max = 8});
               },
               "The gas oven.", {"oven", {"gas"}})
        .block("wood", &BakeIn::wood,
               +[](graph::ParamsOf<Wood>& p) { p.param("kind", &Wood::kind, "Of wood."); },
               "The wood oven.", {"oven", {"wood"}})
        .path_out("report", &BakeIn::report, "Where to write what was baked.")
        .output("bread", &DoughOut::dough, "The bread.")
        .sink();
    r.add("Weigh", 1, weigh)
        .summary("Weighs dough.")
        .input("dough", &WeighIn::dough, "What to weigh.")
        .output("weight", &WeighOut::weight, "Its weight in kg.");
    return r;
}

inline const graph::Registry& registry()
{
    static const graph::Registry r = make_registry();
    return r;
}

inline graph::Loaded load(std::string text, const graph::LoadOptions& options = {})
{
    return graph::load_text(std::move(text), "toy.json", registry(), options);
}

// All problems, one a line.
inline std::string told(const graph::Loaded& loaded)
{
    std::string text;
    for (const graph::Problem& p : loaded.problems) text += describe(p) + "\n";
    return text;
}

}  // namespace toys

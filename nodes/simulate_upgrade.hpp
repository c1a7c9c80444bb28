#pragma once

// What documents of Simulate@1 mean.

#include "graph/document/json.hpp"

namespace nodes::simulate {

inline constexpr auto bends_before = "the default of lattice.calibrate was bending";

// Version 1: a lattice was calibrated for a bend of the whole body by default.
inline void keep_bending(graph::Json& node)
{
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object());
    const graph::Json* const method = params ? params->find("method") : nullptr;
    if (!method || !method->text() || *method->text() != "lattice") return;
    graph::Json& lattice = graph::child(*params, "lattice", *method);
    const graph::Json* const stiffness = lattice.find("stiffness");
    if (stiffness && stiffness->text() && *stiffness->text() == "rate") return;
    graph::put_missing(lattice, "calibrate", std::string("bending"));
}

inline constexpr auto one_step_before = "the default of step.substeps was 1";

inline void keep_one_step(graph::Json& node)
{
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object());
    graph::Json* const step =
        params ? graph::put_missing(*params, "step", graph::Json::Object()) : nullptr;
    if (step) graph::put_missing(*step, "substeps", std::int64_t{1});
}

}  // namespace nodes::simulate

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

}  // namespace nodes::simulate

#pragma once

// The limits of a process that reads a file, as parameters of the nodes that read files.

#include "geometry/io/library_process.hpp"
#include "graph/types/node_builder.hpp"

namespace nodes {

inline void describe_import_limits(graph::ParamsOf<geometry::ProcessLimits>& params)
{
    params
        .param("seconds", &geometry::ProcessLimits::seconds, "Time limit.",
               {.min = 0.1, .max = 86400, .unit = "s"})
        .param("gigabytes", &geometry::ProcessLimits::gigabytes, "Memory limit of the importer.",
               {.min = 0.1, .max = 1024, .unit = "GiB"});
}

}  // namespace nodes

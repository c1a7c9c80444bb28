#pragma once

// What may have been meant by a parameter that a struct does not have.

#include "graph/document/param_reading.hpp"

namespace graph {

// "did you mean 'camera.eye'?" for `key`, a member of `given` that is none of its `params`: what
// the field calls so first, then slips of spelling. Of blocks, those that have no effect with the
// choices of `given` come last.
std::string suggest_param(const ParamReading& reading, const std::vector<Param>& params,
                          const Json& given, const std::string& key);

}  // namespace graph

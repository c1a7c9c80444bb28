#pragma once

// Parameters that name files: one to read, a sequence of those, or one to write.

#include "graph/document/param_reading.hpp"

namespace graph {

// The file as an absolute path; of a sequence, "walk.####.obj", the pattern, and one more entry in
// Node::animated. The default after a report. `json` is a text.
ParamValue read_path_in(const ParamReading& reading, const Param& param, const Json& json);

// A path inside of the output folder; the default after a report. `json` is a text.
ParamValue read_path_out(const ParamReading& reading, const Param& param, const Json& json);

}  // namespace graph

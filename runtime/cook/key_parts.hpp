#pragma once

// What of one node goes into its keys: parameters by their values, files by their bytes, variables
// where the node declares that it reads them.

#include "graph/document/graph.hpp"
#include "runtime/cache/file_digests.hpp"
#include "runtime/cache/key.hpp"

#include <string>
#include <vector>

namespace runtime {

// The value that an animation drives, by the place that it names.
graph::ParamValue& animated_value(graph::ParamValues& values,
                                  const std::vector<std::uint32_t>& where);

// The node's parameters with the same placeholder in all that is animated: the document's constants
// hold anything there.
graph::ParamValues without_animated(const graph::Node& node);

// Whether a parameter, or one inside of it, names a file to read.
bool has_path_in(const std::vector<graph::Param>& params);

// A file counts by its bytes, and by its extension because that says how they are read.
void add_file(KeyBuilder& builder, const std::string& text, FileDigests& files);

// A value; paths of files to read count as add_file() says.
void add_param(KeyBuilder& builder, const graph::Param& param, const graph::ParamValue& value,
               FileDigests& files);

// The first file that the parameters name; its folder is where side files are looked for.
const std::string* first_path(const std::vector<graph::Param>& params,
                              const graph::ParamValues& values);

inline bool declares(const graph::Node& node, graph::Variable variable)
{
    return (node.type->reads & static_cast<unsigned>(variable)) != 0;
}

}  // namespace runtime

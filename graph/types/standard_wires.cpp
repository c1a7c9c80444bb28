#include "graph/types/standard_wires.hpp"

#include "graph/types/wire_type.hpp"

namespace graph {

template const WireType& wire_type<double>();
template const WireType& wire_type<WrittenFile>();

}  // namespace graph

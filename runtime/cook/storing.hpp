#pragma once

// Which results go to the disk cache, and what is kept with them.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Whether the disk cache can hold what the port gives, or all that a node of the type gives.
bool storable(const graph::OutputPort& port);
bool storable(const graph::NodeType& type);

// A sink's result is good only as long as its files are what it wrote. Of one that all frames share
// nobody can tell, and to read it all for each frame would take long.
bool still_there(const Result& result, FileDigests& files);

// Seconds of a simulation since its last frame on disk, up to the frame before.
double since_stored(const Task& task);

// On disk goes what is read back quicker than made again, and what a sink wrote. Of simulations
// also a frame every so often however cheap their steps are, since a late frame costs all those
// before it; and not every frame when all together would fill the disk's budget. Called with or
// without the lock.
bool worth_storing(const CookState& cook, const Task& task, const Result& result);

// What the results that the task runs on warned of, and what they had heard. Takes the lock.
std::vector<Heard> warnings_before(CookState& cook, const Task& task);

// What the results that the task runs on told of their accuracy, and what its own result does.
std::vector<std::shared_ptr<const Told>> told_with(const CookState& cook, const Task& task,
                                                   const graph::Figures& own);

// Whether two lists tell the same, of the same results.
bool tell_the_same(const std::vector<std::shared_ptr<const Told>>& a,
                   const std::vector<std::shared_ptr<const Told>>& b);

}  // namespace runtime

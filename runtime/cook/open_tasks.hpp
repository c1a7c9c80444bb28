#pragma once

// From what is wanted up to what it depends on: each task is looked up in the caches, and where
// they do not hold it, all that it runs on is wanted in turn. Nothing recurses: what is wanted
// stands in a list until it is settled.
//
// All of these are called with the lock held.

#include "runtime/cook/cook_state.hpp"

namespace runtime {

// Opens wants and demands, lowest frame first, as long as few enough are under way. Those in
// flight may wait for demands that are not open yet: then nothing runs, and one more is opened.
void open_more(CookState& cook);

// Goes on with a task whose result no cache has: wants what it runs on. Its own past comes first,
// from the last frame of it that is there or under way: what lies between is opened a frame at a
// time on the way up.
void begin_task(CookState& cook, Task& task);

// The task has its inputs, and has to run after all: it waits for its preparations.
void want_preparations(CookState& cook, Task& task);

// Whether a result that was found is to be made again, see Options::recheck.
bool rechecked(const CookState& cook, const Task& task);

}  // namespace runtime

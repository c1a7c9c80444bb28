#pragma once

// Any plain value as bytes and back, without a line of code per type: numbers, enums, texts, paths,
// containers, fixed Eigen types, optional, pair, shared_ptr<const T>, and plain structs of these
// (fields.hpp finds their members). How the bytes look:
//
//   double, enum        as in memory
//   text, path          count, characters
//   vector<Vec3f>       count, padding to a multiple of 8 bytes, the scalars as they are in memory
//   vector, map, set    count, elements
//   optional            whether it holds something, the content
//   struct              its members in order of declaration
//   Remade              what it was made from; it is made anew when read: a search tree of a mesh
//   shared_ptr<const T> the name of the content, which is stored elsewhere: what many values share
//                       is stored once, and read back as one object again
//
//   storable.hpp        which types can be stored
//   layout.hpp          the text that says how a type is laid out
//   encode.hpp, decode.hpp     to bytes (encoder.hpp) and back (decoder.hpp)

#include "graph/types/decode.hpp"
#include "graph/types/encode.hpp"
#include "graph/types/layout.hpp"

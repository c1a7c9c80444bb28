#pragma once

// The rules for what is inside a mesh.

namespace geometry {

// When a point is inside a mesh. Six rays go out from it, one each way along the axes; each counts
// what it crosses and casts a vote; a point is inside when more than half of the six say so. Rays
// of open meshes start a little beside it, so that narrow slits do not matter (crossings.hpp).
// On a closed mesh all rays agree and the rule is exact. Where a mesh is open, those rays that
// leave through the hole are outvoted as long as it is no larger than most of the rays' view.
enum class Inside {
    // A ray adds 1 where it leaves and takes 1 where it enters, by the faces' orientation, and
    // votes by the sign of the sum. Right for pieces that overlap, for faces named several times
    // and for pieces turned inside out as a whole; a piece turned inside out within another one is
    // a cavity. Wrong where neighbouring faces disagree on what is outside.
    winding,
    // A ray votes inside when it crosses an odd number of faces. Needs no orientation; parts
    // where two pieces overlap count as outside.
    parity,
};

}  // namespace geometry

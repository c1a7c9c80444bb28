#pragma once

// What Plane and Sheet say of the parameters that both have.

namespace nodes {

inline constexpr const char* sheet_thickness_text =
    "Thickness of the sheet. Mass and resistance to stretch grow with it, resistance to bending "
    "with its cube. Colliders, and other sheets, stay half of it away from what is drawn (or half "
    "of a thousandth of a cell, if that is more).";

}  // namespace nodes

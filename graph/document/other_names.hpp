#pragma once

// What other tools and the field call node types, parameters and choices, and what answers to it
// here. Letter case, '_', '-' and spaces of these names are free: "lookAt" is "look_at".

#include <span>
#include <string_view>
#include <vector>

namespace graph {

class Registry;

// Of the candidates, those that other tools call `name` ("oak" and "pine" for "wood").
std::vector<std::string_view> own_names_of(std::string_view name,
                                           std::span<const std::string_view> candidates);

// What to do about a parameter of that name beside these, where no one parameter replaces it;
// empty: nothing is known.
std::string_view advice_on_param(std::string_view name, std::span<const std::string_view> beside);

// What to use for a node type of that name, where it is more than a type by its synonyms: "use
// 'camera' of 'Render'". Empty: nothing is known, or what it is about is not registered.
std::string_view advice_on_type(std::string_view name, const Registry&);

// Whether two names are equal but for letter case, '_', '-' and spaces.
bool same_name(std::string_view a, std::string_view b);

}  // namespace graph

#pragma once

// The parameters of Simulate on contact: between parts and sheets, and between bodies of a lattice.

#include "graph/types/node_builder.hpp"
#include "physics/body/part_shapes.hpp"
#include "physics/lattice/lattice_options.hpp"

namespace nodes::simulate {

inline void describe_part_contact(graph::ParamsOf<physics::PartContactOptions>& p)
{
    using physics::PartContactOptions;
    p.param(
         "on", &PartContactOptions::on,
         "Whether parts of the model that no cubes link collide, and with them the sheets among "
         "several `cubes` (method bricks). Parts that overlap at rest do "
         "not, and a warning says where. "
         "Of sheets: whether those of several `cubes` collide with each other. They "
         "keep half of their thickness on either side of what is drawn, and what comes fast does "
         "not pass through. Sheets that lie in one plane and meet rim to rim are not kept apart.")
        .param(
            "self", &PartContactOptions::self,
            "Whether each part also collides with itself where it folds. Cubes less than three "
            "cubes apart along the part do not. The search takes about 1 ms per 1,000 cubes "
            "and step. Of sheets: whether each collides with itself, and its "
            "pieces with each other; places less than twice the thickness apart along the sheet "
            "do not. Steps take up to 1.2 times as long where nothing touches, and many times as "
            "long while a heap of folds comes to rest. Cells should be at most 20 thicknesses "
            "wide.")
        .param("friction", &PartContactOptions::friction,
               "Coulomb coefficient of friction between them.", {.min = 0, .max = 100})
        .param("bounce", &PartContactOptions::bounce,
               "Share of the speed of an impact that they separate with (coefficient of "
               "restitution). Slow impacts do not bounce.",
               {.min = 0, .max = 1});
}

inline void describe_contact(graph::ParamsOf<physics::BodyContactOptions>& p)
{
    using physics::BodyContactOptions;
    p.param("on", &BodyContactOptions::on, "Whether bodies that are not linked collide.")
        .param("self", &BodyContactOptions::self,
               "With `on`: whether each body also collides with itself where it folds, and with "
               "what is torn off it. Corners at most five cubes apart along the body as it was "
               "made do not, nor those that rest nearer to each other than `distance`. Where "
               "nothing touches, a step takes 1.1 times as long.")
        .param("distance", &BodyContactOptions::distance,
               "Distance between corners at which they touch, as balls; 0: the edge of a cube.",
               {.min = 0, .unit = "m"})
        .param("friction", &BodyContactOptions::friction,
               "Coulomb coefficient of friction between them.", {.min = 0, .max = 100});
}

}  // namespace nodes::simulate

#include "geometry/cubes/sheet.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/doubled_faces.hpp"
#include "nodes/material_rules.hpp"
#include "nodes/sheet_texts.hpp"
#include "nodes/wire_types.hpp"

#include <fmt/format.h>

namespace nodes::sheet {

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    double thickness = 0.002;
    double longest_side = 0;
    ChosenMatter matter;
};
struct Outputs {
    geometry::Cubes cubes;
    geometry::TriMesh mesh;
};

static Outputs run(const Inputs& in, const graph::Context& context)
{
    geometry::SheetOfMesh made =
        geometry::make_sheet(*in.mesh, in.thickness, matter_of(in.matter), in.longest_side);
    if (made.left_out > 0) {
        context.warn(fmt::format("{} of {} faces are left out: they have no area. Their vertices "
                                 "move with the faces nearby.",
                                 made.left_out, in.mesh->triangles().size()));
    }
    warn_of_doubled_faces(made.doubled, in.mesh->triangles().size(), context);
    if (made.joints > 0) {
        context.warn(fmt::format(
            "{} edges have more than two faces: there the two that run on most straightly bend as "
            "one, and the others turn freely, as by a hinge. If that is not meant, remove inner "
            "faces from the mesh.",
            made.joints));
    }
    return {std::move(made.cubes), *in.mesh};
}

void add_to(graph::Registry& registry)
{
    registry.add("Sheet", 1, run)
        .summary("Makes an elastic sheet of any mesh: its faces become a thin shell for Simulate's "
                 "method shell, or beside solids for method bricks, with the shape that the mesh "
                 "has at rest.",
                 {"cloth", "garment", "fabric", "shell", "paper", "sheet metal", "balloon"})
        .input("mesh", &Inputs::mesh,
               "The surface: any triangles, open or closed, of any shape. Its edges are as fine as "
               "the sheet can bend. Vertices at one place are one, and so are a face and its back.")
        .param("thickness", &Inputs::thickness, sheet_thickness_text, {1e-12, 1e6, "m"})
        .param("longest_side", &Inputs::longest_side,
               "Faces are cut until none has a longer side, so that a coarse mesh can bend within "
               "its faces; Embed carries the mesh as it is. 0: the faces of the mesh.",
               {0, 1e6, "m"})
        .block("matter", &Inputs::matter, describe_matter<ChosenMatter>, "Material of the sheet.")
        .output("cubes", &Outputs::cubes, "One cell for each face, for Pin, Simulate and Embed.")
        .output("mesh", &Outputs::mesh,
                "The same mesh, for Embed and Render. Any other mesh can be embedded in the cells "
                "instead: it goes with the faces nearest to it.");
}

}  // namespace nodes::sheet

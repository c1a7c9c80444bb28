#include "geometry/embed/embed.hpp"
#include "geometry/cubes/plane.hpp"
#include "geometry/embed/carried_numbers.hpp"
#include "geometry/embed/cut_torn.hpp"
#include "geometry/embed/smooth_normals.hpp"
#include "geometry/embed/torn_faces.hpp"
#include "geometry/mesh/triangle_bvh.hpp"

#include "graph/document/json.hpp"
#include "graph/types/node_builder.hpp"
#include "nodes/wire_types.hpp"
#include "physics/state/state_models.hpp"

#include <fmt/format.h>
#include <tbb/collaborative_call_once.h>

namespace nodes::embed {

using Attributes = geometry::CarriedNumbers;
enum class Torn { cut, hide, stretch };
enum class Inside { open, material, surface };
enum class Normals { cube, smooth };

// The tree of a mesh at rest, made when something is cut for the first time.
class TreeOnDemand {
public:
    explicit TreeOnDemand(graph::Wire<geometry::TriMesh> mesh) : mesh_(std::move(mesh)) {}

    const geometry::TriangleBvh& get() const
    {
        tbb::collaborative_call_once(made_->once,
                                     [&] { made_->tree = geometry::TriangleBvh(*mesh_); });
        return made_->tree;
    }
    std::size_t bytes() const { return sizeof(Made); }  // when it is asked for, there is no tree

private:
    struct Made {
        tbb::collaborative_once_flag once;
        geometry::TriangleBvh tree;
    };
    graph::Wire<geometry::TriMesh> mesh_;
    std::unique_ptr<Made> made_ = std::make_unique<Made>();
};

struct Inputs {
    graph::Wire<geometry::TriMesh> mesh;
    graph::Wire<geometry::Cubes> cubes;
    graph::Wire<physics::State> state;
    Attributes attributes;
    Normals normals = Normals::cube;
    Torn torn = Torn::cut;
    Inside inside = Inside::material;
    geometry::Vec3f inside_colour{0.55f, 0.4f, 0.3f};
    std::shared_ptr<const geometry::Binding> binding;
    std::shared_ptr<const TreeOnDemand> tree;
};
struct Outputs {
    geometry::TriMesh mesh;
};

static geometry::Binding bind(const Inputs& in)
{
    return geometry::bind(*in.mesh, *in.cubes);
}

static TreeOnDemand tree_on_demand(const Inputs& in)
{
    return TreeOnDemand(in.mesh);
}

// A detail may stand off from a sheet by about a face; what is farther off is another mesh.
static void warn_of_far_sheet(const Inputs& in, const graph::Context& context)
{
    constexpr double far = 3;  // mean sides of the sheet's triangles
    if (!in.cubes->is_sheet() || in.binding->farthest <= far * in.cubes->size) return;
    context.warn(fmt::format("the mesh lies up to {:.3g} m from the sheet that carries it: is it "
                             "the mesh of this sheet, where it rests?",
                             in.binding->farthest));
}

static void warn_of_strays(const Inputs& in, const graph::Context& context)
{
    warn_of_far_sheet(in, context);
    const std::string text = geometry::warning_of_strays(*in.binding);
    if (!text.empty()) context.warn(text);
}

// The mesh where links have broken: cut there, or without the faces there.
static geometry::TriMesh torn_mesh(const Inputs& in, const physics::State& state,
                                   geometry::TriMesh mesh,
                                   std::span<const geometry::PartedCube> parted)
{
    if (in.torn == Torn::cut) {
        // Planes stay open: they need no tree.
        geometry::Closing closing;
        if (in.inside != Inside::open && !parted.empty() && geometry::flat_axis(*in.cubes) < 0) {
            closing.solid = &in.tree->get();
        }
        if (in.inside == Inside::material) {
            closing.material = geometry::Material{"inside", in.inside_colour};
        }
        return geometry::cut_torn(*in.binding, *in.mesh, std::move(mesh), *in.cubes, state.x,
                                  state.broken, parted, closing);
    }
    if (in.torn == Torn::hide && !state.broken.empty()) {
        const auto gone = geometry::torn_faces(*in.binding, *in.mesh, *in.cubes, state.broken);
        return geometry::without_faces(std::move(mesh), gone);
    }
    return mesh;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    warn_of_strays(in, context);
    const auto own = physics::state_of(in.state, *in.cubes);
    const physics::State& state = *own;
    const auto parted = in.torn == Torn::cut ? geometry::find_parted(*in.cubes, state.broken)
                                             : std::vector<geometry::PartedCube>{};
    const auto torn =
        parted.empty() ? std::vector<std::uint8_t>{} : geometry::marked(*in.cubes, parted);
    geometry::TriMesh mesh = geometry::embed(*in.binding, *in.mesh, *in.cubes, state.x, torn);
    if (in.normals == Normals::smooth) {
        geometry::smooth_normals(mesh, *in.binding, *in.mesh, *in.cubes, state.x, torn);
    }
    geometry::add_carried_numbers(mesh, in.attributes, *in.mesh, *in.binding, *in.cubes,
                                  {state.v, state.stress, state.plastic_strain});
    return {torn_mesh(in, state, std::move(mesh), parted)};
}

static void describe_attributes(graph::ParamsOf<Attributes>& p)
{
    p.param("displacement", &Attributes::displacement, "How far each vertex is from its rest, m.")
        .param("speed", &Attributes::speed, "How fast each vertex moves, m/s.")
        .param("stress", &Attributes::stress,
               "Von Mises stress of the cubes around, Pa; only from methods that compute it.")
        .param("plastic_strain", &Attributes::plastic_strain,
               "Strain that the rest shape of the cubes around has come to for good; only of "
               "simulations with a yield strain (`plastic.yield`).")
        .param("component", &Attributes::component,
               "The number of the component that carries each vertex; only after "
               "ConnectedComponent.")
        .param("cubes", &Attributes::cubes,
               "Properties of the cubes around each vertex: names, with commas between them. young "
               "(Pa), density (kg/m^3), poisson, mass_damping (1/s), stiffness_damping (s), fill, "
               "of a Plane or a Sheet thickness (m), or one of their own (LocalMatter, Voxelize), "
               "of which * means all. Empty: none. "
               "Attributes that the mesh itself has stay, but for those of these names.");
}

// Version 1 left faces out, or not.
static void keep_hiding(graph::Json& node)
{
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object());
    if (!params) return;
    const graph::Json* const hide = params->find("hide_torn");
    const bool* const hidden = hide ? std::get_if<bool>(&hide->is) : nullptr;
    graph::put_missing(*params, "torn", std::string(hidden && !*hidden ? "stretch" : "hide"));
    graph::erase(*params, "hide_torn");
}

// Version 2 left open what it cut.
static void keep_open(graph::Json& node)
{
    graph::Json* const params = graph::put_missing(node, "params", graph::Json::Object());
    if (!params) return;
    const graph::Json* const torn = params->find("torn");
    const std::string* const what = torn ? std::get_if<std::string>(&torn->is) : nullptr;
    if (!torn || (what && *what == "cut")) {
        graph::put_missing(*params, "inside", std::string("open"));
    }
}

void add_to(graph::Registry& registry)
{
    registry.add("Embed", 3, run)
        .summary("Deforms a mesh with its cubes: vertices by trilinear interpolation, normals by "
                 "the deformation gradient.",
                 {"point deform", "deform", "deformer", "bind", "wrap", "lattice deform",
                  "mesh deform", "cage deform"})
        .upgrade(1, "hide_torn became torn = hide or stretch; the default is now cut", keep_hiding)
        .upgrade(2, "cuts are now closed unless inside = open", keep_open)
        .input("mesh", &Inputs::mesh,
               "The mesh at rest, at the place of the undeformed cubes. It need not be the mesh "
               "that the cubes were made from.")
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input("state", &Inputs::state, "State of the cubes at this frame.")
        .block("attributes", &Inputs::attributes, describe_attributes,
               "Attributes to compute at each vertex, for colouring or export.")
        .choice("normals", &Inputs::normals, {"cube", "smooth"},
                "How normals turn. cube: with the deformation gradient of their own cube, which "
                "changes abruptly at its faces, so that cubes show as tiles in the light. smooth: "
                "with a gradient that changes continuously from cube to cube. On a Sheet both are "
                "the same: smooth.")
        .choice("torn", &Inputs::torn, {"cut", "hide", "stretch"},
                "What happens to faces where links have broken (`lattice.tear` of Simulate). cut: "
                "faces are cut between the corners that have separated, which adds vertices. hide: "
                "faces in cubes that have lost a link are removed; the number of vertices stays "
                "the same, as point caches need. stretch: faces are stretched across the gap.")
        .choice(
            "inside", &Inputs::inside, {"open", "material", "surface"},
            "How cuts are closed if the mesh encloses a volume. open: not at all. material: by "
            "faces with a material \"inside\". surface: by faces that look like the nearest "
            "part of the surface. The new faces are in the group \"inside\". A closed mesh stays "
            "closed where it lies within the cubes and its pieces do not overlap.",
            {"torn", {"cut"}})
        .colour("inside_colour", &Inputs::inside_colour, "Colour of the material \"inside\".",
                {"inside", {"material"}})
        .prepare("binding", &Inputs::binding, bind, {"mesh", "cubes"})
        .prepare("tree", &Inputs::tree, tree_on_demand, {"mesh"})
        .output("mesh", &Outputs::mesh, "The deformed mesh.");
}

}  // namespace nodes::embed

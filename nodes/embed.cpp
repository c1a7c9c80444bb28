#include "geometry/embed.hpp"
#include "geometry/cut_torn.hpp"
#include "geometry/plane.hpp"
#include "geometry/torn_faces.hpp"

#include "graph/json.hpp"
#include "graph/node_type.hpp"
#include "nodes/wire_types.hpp"

#include <tbb/collaborative_call_once.h>

#include <cstdio>

namespace nodes::embed {

struct Attributes {
    bool displacement = true;
    bool speed = true;
    bool stress = true;
    bool component = true;
};

enum class Torn { cut, hide, stretch };
enum class Inside { open, material, surface };

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

static void warn_of_strays(const Inputs& in, const graph::Context& context)
{
    if (in.binding->strays.empty()) return;
    char text[160];
    std::snprintf(text, sizeof text,
                  "%zu of %zu vertices lie in no cube and go with the nearest one, at most %.3g m "
                  "away",
                  in.binding->strays.size(), in.mesh->positions.size(), in.binding->farthest);
    context.warn(text);
}

static std::vector<float> displacement(const geometry::TriMesh& rest, const geometry::TriMesh& mesh)
{
    std::vector<float> out(rest.positions.size());
    for (std::size_t v = 0; v < out.size(); ++v) {
        out[v] = (mesh.positions[v] - rest.positions[v]).norm();
    }
    return out;
}

static std::vector<float> per_cube(const Inputs& in, std::span<const float> values)
{
    return geometry::interpolate(*in.binding, *in.cubes, geometry::at_corners(*in.cubes, values));
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    warn_of_strays(in, context);
    const physics::State& state = *in.state;
    const auto parted = in.torn == Torn::cut ? geometry::find_parted(*in.cubes, state.broken)
                                             : std::vector<geometry::PartedCube>{};
    const auto torn =
        parted.empty() ? std::vector<std::uint8_t>{} : geometry::marked(*in.cubes, parted);
    Outputs out{geometry::embed(*in.binding, *in.mesh, *in.cubes, state.x, torn)};
    const auto add = [&](const char* name, const char* unit, std::vector<float> values) {
        std::erase_if(out.mesh.attributes, [&](const auto& a) { return a.name == name; });
        out.mesh.attributes.push_back({name, unit, std::move(values)});
    };
    if (in.attributes.displacement) add("displacement", "m", displacement(*in.mesh, out.mesh));
    if (in.attributes.speed && state.v.size() == in.cubes->corner_count()) {
        std::vector<double> speeds(state.v.size());
        for (std::size_t k = 0; k < speeds.size(); ++k) speeds[k] = state.v[k].norm();
        add("speed", "m/s", geometry::interpolate(*in.binding, *in.cubes, speeds));
    }
    if (in.attributes.stress && state.stress.size() == in.cubes->count()) {
        add("stress", "Pa", per_cube(in, state.stress));
    }
    if (in.attributes.component && in.cubes->component.size() == in.cubes->count()) {
        std::vector<float> component(in.mesh->positions.size());
        for (std::size_t v = 0; v < component.size(); ++v) {
            component[v] =
                static_cast<float>(in.cubes->component[in.binding->used[in.binding->cube[v]]]);
        }
        add("component", "", std::move(component));
    }
    if (in.torn == Torn::cut) {
        // Planes stay open: they need no tree.
        geometry::Closing closing;
        if (in.inside != Inside::open && !parted.empty() && geometry::flat_axis(*in.cubes) < 0) {
            closing.solid = &in.tree->get();
        }
        if (in.inside == Inside::material) {
            closing.material = geometry::Material{"inside", in.inside_colour};
        }
        out.mesh = geometry::cut_torn(*in.binding, *in.mesh, std::move(out.mesh), *in.cubes,
                                      state.x, state.broken, parted, closing);
    } else if (in.torn == Torn::hide && !state.broken.empty()) {
        const auto gone = geometry::torn_faces(*in.binding, *in.mesh, *in.cubes, state.broken);
        out.mesh = geometry::without_faces(std::move(out.mesh), gone);
    }
    return out;
}

static void describe_attributes(graph::ParamsOf<Attributes>& p)
{
    p.param("displacement", &Attributes::displacement, "How far each vertex is from its rest, m.")
        .param("speed", &Attributes::speed, "How fast each vertex moves, m/s.")
        .param("stress", &Attributes::stress,
               "Von Mises stress of the cubes around, Pa; only from methods that compute it.")
        .param("component", &Attributes::component,
               "The number of the component that carries each vertex; only after "
               "ConnectedComponent.");
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
        .summary("Carries a mesh along with deformed cubes: vertices by trilinear interpolation, "
                 "normals by the deformation's gradient.")
        .upgrade(1, "hide_torn is torn: hide, or stretch; unless said it is cut now", keep_hiding)
        .upgrade(2, "what is cut is closed, unless inside is open", keep_open)
        .input("mesh", &Inputs::mesh,
               "The mesh at rest, where the undeformed cubes are. It need not be the one that the "
               "cubes were made from.")
        .input("cubes", &Inputs::cubes, "The cubes at rest.")
        .input("state", &Inputs::state, "Where the corners of the cubes are now.")
        .block("attributes", &Inputs::attributes, describe_attributes,
               "Which numbers to leave at each vertex, to colour by or to export.")
        .choice("torn", &Inputs::torn, {"cut", "hide", "stretch"},
                "What becomes of faces where links have broken (`lattice.tear` of Simulate). cut: "
                "they are cut between the corners that have parted; vertices are added. hide: "
                "those in cubes that have lost a link are left out; vertices stay the same, as "
                "point caches want them. stretch: they are drawn out across the gap.")
        .choice(
            "inside", &Inputs::inside, {"open", "material", "surface"},
            "What closes the mesh where it is cut, if it encloses a volume: nothing, faces with "
            "a material \"inside\" of their own, or faces that look like the surface nearest "
            "to them. They are of the group \"inside\".",
            {"torn", {"cut"}})
        .colour("inside_colour", &Inputs::inside_colour, "The colour of that material.",
                {"inside", {"material"}})
        .prepare("binding", &Inputs::binding, bind, {"mesh", "cubes"})
        .prepare("tree", &Inputs::tree, tree_on_demand, {"mesh"})
        .output("mesh", &Outputs::mesh, "The mesh as the cubes carry it.");
}

}  // namespace nodes::embed

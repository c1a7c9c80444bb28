#include "graph/document/other_names.hpp"

#include "graph/types/registry.hpp"

#include <algorithm>
#include <cctype>
#include <string>

namespace graph {

namespace {

struct OtherName {
    std::string_view other, own;
    std::string_view beside = {};  // only among names with this one; empty: always
};
constexpr OtherName other_names[] = {
    // materials
    {"elasticity", "young"},
    {"elastic_modulus", "young"},
    {"modulus", "young"},
    {"youngs_modulus", "young"},
    {"young_modulus", "young"},
    {"stiffness", "young"},
    {"hardness", "young"},
    {"poissons_ratio", "poisson"},
    {"poisson_ratio", "poisson"},
    {"damping", "mass_damping"},
    {"damping", "stiffness_damping"},
    {"rho", "density"},
    {"wood", "oak"},
    {"wood", "pine"},
    {"timber", "oak"},
    {"timber", "pine"},
    {"metal", "steel"},
    {"metal", "aluminium"},
    {"iron", "steel"},
    {"plastic", "nylon"},
    {"polymer", "nylon"},
    {"stone", "concrete"},
    {"rock", "concrete"},
    {"brick", "concrete"},
    {"ceramic", "glass"},
    {"ceramic", "concrete"},
    {"cloth", "leather"},
    {"fabric", "leather"},
    {"sponge", "foam"},
    {"silicone", "rubber"},
    {"skin", "flesh"},
    {"muscle", "flesh"},
    {"gelatin", "jelly"},
    {"gel", "jelly"},
    // contact
    {"restitution", "bounce"},
    {"bounciness", "bounce"},
    // shapes
    {"cube", "box"},
    {"ball", "sphere"},
    {"block", "box"},
    {"uv_sphere", "sphere"},
    {"ico_sphere", "sphere"},
    {"tube", "cylinder"},
    {"pipe", "cylinder"},
    {"rod", "beam", "torus"},
    {"bar", "beam", "torus"},
    {"plane", "grid", "torus"},
    {"donut", "torus"},
    {"ring", "torus"},
    // methods
    {"fem", "bricks"},
    {"finite_elements", "bricks"},
    {"cloth", "shell", "bricks"},
    {"mass_spring", "springs"},
    {"shape_matching", "lattice"},
    {"pbd", "lattice"},
    // cubes
    {"voxel_size", "size"},
    {"cube_size", "size"},
    {"cell_size", "size"},
    {"divisions", "resolution"},
    {"mass", "total_mass"},
    // places and motions
    {"rotate", "rotate_degrees"},
    {"rotation", "rotate_degrees"},
    {"rotate_deg", "rotate_degrees"},
    {"euler", "rotate_degrees"},
    {"r", "rotate_degrees", "pivot"},
    {"translation", "translate"},
    {"position", "translate"},
    {"location", "translate"},
    {"move", "translate"},
    {"offset", "translate"},
    {"t", "translate", "pivot"},
    {"scaling", "scale", "pivot"},
    {"size", "scale", "pivot"},
    {"s", "scale", "pivot"},
    {"position", "centre", "uv_sphere"},
    {"location", "centre", "uv_sphere"},
    {"translate", "centre", "uv_sphere"},
    {"position", "height", "bounce"},
    {"location", "height", "bounce"},
    {"elevation", "height", "bounce"},
    {"level", "height", "bounce"},
    {"y", "height", "bounce"},
    {"velocity", "initial_velocity"},
    {"size", "radius"},
    // cameras
    {"position", "eye"},
    {"location", "eye"},
    {"from", "eye", "target"},
    {"look_at", "target"},
    {"at", "target", "eye"},
    {"to", "target", "eye"},
    {"aim", "target"},
    {"fov", "field_of_view"},
    {"angle_of_view", "field_of_view"},
    {"focal_length", "field_of_view"},
    {"orthographic", "parallel"},
    {"orbit", "turntable"},
    {"fixed", "look_at"},
    {"color", "colour"},
    // steps
    {"fps", "dt"},
    {"time_step", "dt"},
    {"iterations", "solver_iterations"},
};

struct ParamAdvice {
    std::string_view other, beside, says;
};
constexpr std::string_view of_contact =
    "it is no material's: set it where things touch, on Ground, Collider or 'contact' of Simulate";
constexpr ParamAdvice param_advice[] = {
    {"mass", "young", "use 'density', or 'total_mass' of the node that makes the cubes"},
    {"weight", "young", "use 'density', or 'total_mass' of the node that makes the cubes"},
    {"bounce", "young", of_contact},
    {"bounciness", "young", of_contact},
    {"restitution", "young", of_contact},
    {"friction", "young", of_contact},
    {"resolution", "burn_in", "use 'width' and 'height'"},
    {"size", "burn_in", "use 'width' and 'height'"},
    {"scale", "uv_sphere", "link a Transform behind this node"},
    {"rotate", "uv_sphere", "link a Transform behind this node"},
    {"rotation", "uv_sphere", "link a Transform behind this node"},
};

struct TypeAdvice {
    std::string_view other, about, says;
};
constexpr std::string_view of_rigid_bodies =
    R"(use 'Simulate' with "bodies": [{ "rigid": true }], or 'Collider' for what does not move)";
constexpr std::string_view of_fracture =
    R"(use 'Voxelize' with "pieces": "each" for a mesh that is cut already, or 'tear' of the )"
    R"(block 'lattice' of 'Simulate')";
constexpr std::string_view of_cloth =
    R"(use 'Plane' or 'Sheet' for the cloth and 'Simulate' with "method": "shell")";
constexpr std::string_view of_soft_bodies =
    R"(use 'Voxelize' for the body and 'Simulate', which moves soft and rigid bodies together)";
constexpr std::string_view of_hinges =
    "use 'Joint' between two bodies, or 'Pin' with \"hold\": \"corners\" on a rigid body: one line "
    "of corners is a hinge to the world, one corner a ball joint. Joints of characters are those "
    "of 'Figure'";
constexpr std::string_view of_glue =
    R"(use 'Merge' and one 'Voxelize', with "materials" for the parts: what touches or overlaps )"
    R"(moves as one body. 'Joint' with "kind": "glue" keeps bodies together wherever they touch. )"
    R"('Pin' holds a body to the world, or with 'follow' a sheet to a body)";
constexpr std::string_view of_ropes =
    R"(use a thin 'Primitive' and 'Voxelize' for a rope, and 'Joint' for what hangs on it. )"
    R"(Rings of a chain are bodies ("pieces": "each") that 'Simulate' keeps rigid ("bodies": [{ "rigid": true }]))";
constexpr std::string_view of_attributes =
    "use 'Attributes' for numbers on a mesh, or 'LocalMatter' for materials that vary";
constexpr std::string_view of_pins =
    "use 'Pin', which holds a part of a body, moves it, or lets it follow a mesh";
constexpr std::string_view of_pictures = "use 'Render', and 'WriteImage' for its files";
constexpr std::string_view of_editing =
    "meshes are not edited here: do it in a modelling program, and read the result by 'ReadMesh'";
constexpr std::string_view of_parts =
    R"(use 'Split' with "parts": [{ "name": "leaf*" }], the names of groups or materials)";
constexpr std::string_view of_fluids =
    "fluids, gases and hair are not simulated; 'Simulate' moves solids and sheets";
constexpr std::string_view of_spheres = R"(use 'Primitive' with "shape": "sphere")";
constexpr TypeAdvice type_advice[] = {
    {"rigid_body", "Simulate", of_rigid_bodies},
    {"rigid_bodies", "Simulate", of_rigid_bodies},
    {"rigid", "Simulate", of_rigid_bodies},
    {"rbd", "Simulate", of_rigid_bodies},
    {"rbd_object", "Simulate", of_rigid_bodies},
    {"rbd_solver", "Simulate", of_rigid_bodies},
    {"rigid_body_solver", "Simulate", of_rigid_bodies},
    {"rigid_body_world", "Simulate", of_rigid_bodies},
    {"rigid_solver", "Simulate", of_rigid_bodies},
    {"bullet_solver", "Simulate", of_rigid_bodies},
    {"vellum", "Simulate", of_soft_bodies},
    {"vellum_solver", "Simulate", of_soft_bodies},
    {"soft_body_solver", "Simulate", of_soft_bodies},
    {"vellum_cloth", "Plane", of_cloth},
    {"cloth_solver", "Plane", of_cloth},
    {"cloth_object", "Plane", of_cloth},
    {"hinge", "Joint", of_hinges},
    {"ball_joint", "Joint", of_hinges},
    {"rigid_body_constraint", "Joint", of_hinges},
    {"constraint_network", "Joint", of_hinges},
    {"glue", "Merge", of_glue},
    {"weld", "Merge", of_glue},
    {"attach", "Merge", of_glue},
    {"vellum_constraints", "Merge", of_glue},
    {"rope", "Voxelize", of_ropes},
    {"chain", "Voxelize", of_ropes},
    {"cable", "Voxelize", of_ropes},
    {"wind", "Force", R"(use 'Force' with "kind": "wind")"},
    {"gravity", "Force", R"(use 'gravity' of 'Simulate', or 'Force' with "kind": "gravity")"},
    {"mesh", "ReadMesh", "use 'ReadMesh' for a file, or 'Primitive' for a simple shape"},
    {"alembic", "ReadMesh", "Alembic is not read: export glTF, FBX, PLY or OBJ for 'ReadMesh'"},
    {"usd", "ReadMesh", "USD is not read: export glTF, FBX, PLY or OBJ for 'ReadMesh'"},
    {"fbx", "ReadMesh", "use 'ReadMesh', or 'ReadCamera' for its cameras"},
    {"import", "ReadMesh", "use 'ReadMesh' for a mesh or points, or another of the Read nodes"},
    {"camera", "Render", "use 'camera' of 'Render', or 'ReadCamera' for one of a file"},
    {"light", "Render", "use 'light' of 'Render'"},
    {"material", "Voxelize",
     "use 'matter' and 'materials' of 'Voxelize' for what is simulated, and 'colour' and "
     "'material' of 'Primitive' for looks"},
    {"output", "WriteImage", "use 'WriteImage', 'WriteVideo' or 'WriteMesh'"},
    {"cache", "WriteScene",
     "results are kept without a node; to write files, use 'WriteMesh' or 'WriteScene'"},
    {"fracture", "Voxelize", of_fracture},
    {"voronoi_fracture", "Voxelize", of_fracture},
    {"shatter", "Voxelize", of_fracture},
    {"bullet", "Simulate", of_rigid_bodies},
    {"fem_solver", "Simulate", of_soft_bodies},
    {"fem_object", "Simulate", of_soft_bodies},
    {"fem_solid_object", "Simulate", of_soft_bodies},
    {"solid_object", "Simulate", of_soft_bodies},
    {"nucleus", "Simulate", of_soft_bodies},
    {"dop_net", "Simulate", of_soft_bodies},
    {"dop_network", "Simulate", of_soft_bodies},
    {"tetrahedralize", "Voxelize", of_soft_bodies},
    {"solid_conform", "Voxelize", of_soft_bodies},
    {"solid_embed", "Voxelize", of_soft_bodies},
    {"tet_embed", "Voxelize", of_soft_bodies},
    {"vdb_from_polygons", "Voxelize", of_soft_bodies},
    {"ncloth", "Plane", of_cloth},
    {"nrigid", "Collider", "use 'Collider'"},
    {"static_object", "Collider", "use 'Collider', or 'Ground' for a floor"},
    {"pop_force", "Force", "use 'Force'"},
    {"pop_wind", "Force", R"(use 'Force' with "kind": "wind")"},
    {"vellum_constraint", "Merge", of_glue},
    {"attach_constraint", "Merge", of_glue},
    {"vellum_pin", "Pin", of_pins},
    {"pin_to_target", "Pin", of_pins},
    {"pin_constraint", "Pin", of_pins},
    {"goal", "Pin", of_pins},
    {"uv_sphere", "Primitive", of_spheres},
    {"ico_sphere", "Primitive", of_spheres},
    {"poly_sphere", "Primitive", of_spheres},
    {"poly_cube", "Primitive", R"(use 'Primitive' with "shape": "box")"},
    {"poly_plane", "Primitive", R"(use 'Primitive' with "shape": "grid")"},
    {"tube", "Primitive", R"(use 'Primitive' with "shape": "cylinder")"},
    {"poly_cylinder", "Primitive", R"(use 'Primitive' with "shape": "cylinder")"},
    {"cone", "Primitive", "no shape of 'Primitive' is one: use 'ReadMesh'"},
    {"capsule", "Primitive", "no shape of 'Primitive' is one: use 'ReadMesh'"},
    {"attrib_wrangle", "Attributes", of_attributes},
    {"attribute_wrangle", "Attributes", of_attributes},
    {"attrib_create", "Attributes", of_attributes},
    {"attrib_noise", "Attributes", of_attributes},
    {"copy_to_points", "Copies", "use 'Copies'"},
    {"mash", "Copies", "use 'Copies'"},
    {"bone", "Figure", "use 'Figure'"},
    {"ik_handle", "Reach", "use 'Reach'"},
    {"skin_cluster", "Embed", "use 'Embed' for a mesh that cubes move, or 'Skin' of 'Layered'"},
    {"surface_deform", "Embed", "use 'Embed'"},
    {"lattice", "Simulate",
     R"(use 'Voxelize' and 'Embed', and 'Simulate' with "method": "lattice")"},
    {"jiggle", "Vibrate", "use 'Vibrate', or 'Simulate'"},
    {"mantra", "Render", of_pictures},
    {"karma", "Render", of_pictures},
    {"arnold", "Render", of_pictures},
    {"cycles", "Render", of_pictures},
    {"eevee", "Render", of_pictures},
    {"playblast", "Render", of_pictures},
    {"turntable", "Render", R"(use 'Render' with "camera": { "kind": "turntable" })"},
    {"rop_geometry", "WriteMesh", "use 'WriteMesh'"},
    {"remesh", "ReadMesh", of_editing},
    {"subdivide", "ReadMesh", of_editing},
    {"subsurf", "ReadMesh", of_editing},
    {"separate_geometry", "Split", of_parts},
    {"delete_geometry", "Split", of_parts},
    {"boolean", "ReadMesh", of_editing},
    {"decimate", "ReadMesh", of_editing},
    {"solidify", "Voxelize", "use `thickness` of 'Voxelize' or 'Sheet'"},
    {"fluid", "Simulate", of_fluids},
    {"fluid_solver", "Simulate", of_fluids},
    {"flip_solver", "Simulate", of_fluids},
    {"pyro", "Simulate", of_fluids},
    {"smoke", "Simulate", of_fluids},
    {"ocean", "Simulate", of_fluids},
    {"hair", "Simulate", of_fluids},
    {"nhair", "Simulate", of_fluids},
};

std::string plain(std::string_view name)
{
    std::string out;
    for (const char c : name) {
        if (c == ' ' || c == '_' || c == '-') continue;
        out += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
    return out;
}

bool contains(std::span<const std::string_view> names, std::string_view name)
{
    return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

bool same_name(std::string_view a, std::string_view b)
{
    return plain(a) == plain(b);
}

std::vector<std::string_view> own_names_of(std::string_view name,
                                           std::span<const std::string_view> candidates)
{
    std::vector<std::string_view> found;
    for (const OtherName& known : other_names) {
        if (!contains(candidates, known.own) || !same_name(known.other, name)) continue;
        if (known.beside.empty() || contains(candidates, known.beside)) found.push_back(known.own);
    }
    return found;
}

std::string_view advice_on_param(std::string_view name, std::span<const std::string_view> beside)
{
    for (const ParamAdvice& known : param_advice) {
        if (contains(beside, known.beside) && same_name(known.other, name)) return known.says;
    }
    return {};
}

std::string_view advice_on_type(std::string_view name, const Registry& registry)
{
    for (const TypeAdvice& known : type_advice) {
        if (same_name(known.other, name) && registry.find(std::string(known.about))) {
            return known.says;
        }
    }
    return {};
}

}  // namespace graph

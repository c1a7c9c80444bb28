#include "geometry/cubes/voxelize.hpp"
#include "geometry/cubes/bodies.hpp"
#include "geometry/cubes/mean_attributes.hpp"
#include "geometry/cubes/sample_points.hpp"
#include "geometry/mesh/doubled_faces.hpp"
#include "geometry/mesh/split.hpp"

#include "graph/types/node_builder.hpp"
#include "nodes/body_doubts.hpp"
#include "nodes/body_figures.hpp"
#include "nodes/calibrated_cubes.hpp"
#include "nodes/cube_quality.hpp"
#include "nodes/doubled_faces.hpp"
#include "nodes/dust.hpp"
#include "nodes/filled_between.hpp"
#include "nodes/filled_hollow.hpp"
#include "nodes/filled_shell.hpp"
#include "nodes/large_cubes.hpp"
#include "nodes/material_rules.hpp"
#include "nodes/no_volume.hpp"
#include "nodes/orientation.hpp"
#include "nodes/voxelize_texts.hpp"
#include "nodes/wire_types.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace nodes::voxelize {

enum class Method { samples, surface, solid };
enum class Align { fit, origin };
enum class Stiffness { filled, calibrated };
enum class Pieces { merge, apart, each, groups };

struct Inputs {
    std::vector<graph::Wire<geometry::Samples>> points;
    graph::Wire<geometry::TriMesh> mesh;
    Method method = Method::samples;
    Quality quality = Quality::by_size;
    double error = 0.05;
    double size = 0;
    int resolution = 32;
    Align align = Align::fit;
    geometry::Vec3 origin{0, 0, 0};
    geometry::Inside inside = geometry::Inside::winding;
    Pieces pieces = Pieces::merge;
    double join = 0;
    double thickness = 0;
    Stiffness stiffness = Stiffness::filled;
    CalibrationParams calibration;
    ChosenMatter matter;
    std::vector<MaterialRule> materials;
    std::string attributes;
    double total_mass = 0;
    double min_fill = geometry::VoxelOptions{}.min_fill;
    std::int64_t max_cubes = static_cast<std::int64_t>(geometry::VoxelOptions{}.max_cubes);
};
struct Outputs {
    geometry::Cubes cubes;
};

static geometry::VoxelGrid grid_of_size(const Inputs& in, const geometry::Box& box, double size)
{
    if (in.align == Align::origin) return {size, in.origin, geometry::Vec3i::Zero()};
    return geometry::fit_grid(box, size);
}

static geometry::Box box_of_points(const Inputs& in)
{
    geometry::Box box;
    for (const auto& set : in.points) box.add(geometry::finite_bounds(set->positions));
    return box;
}

// Of what places the grid.
static geometry::Box box_of(const Inputs& in)
{
    if (in.mesh && !in.mesh->triangles().empty()) return geometry::triangle_bounds(*in.mesh);
    geometry::Box box;
    if (in.mesh) box = geometry::finite_bounds(in.mesh->positions);
    return in.method == Method::samples && box.empty() ? box_of_points(in) : box;
}

static geometry::VoxelGrid grid_for(const Inputs& in)
{
    const geometry::Box box = box_of(in);
    const double size =
        in.size > 0 || box.empty() ? in.size : geometry::size_for(box, in.resolution);
    geometry::VoxelGrid grid = grid_of_size(in, box, size);
    if (in.method != Method::samples) return grid;
    // Samples beyond the mesh that places the grid have cubes there.
    const geometry::Box points = box_of_points(in);
    for (int k = 0; k < 3; ++k) {
        const double rounding = 0.01 * size, end = grid.origin[k] + size * grid.cells[k];
        const bool within =
            points.lo[k] >= grid.origin[k] - rounding && points.hi[k] <= end + rounding;
        if (!within) grid.cells[k] = 0;
    }
    return grid;
}

static graph::Faults check(const Inputs& in, const graph::Setting& setting)
{
    const bool samples = in.method == Method::samples;
    graph::Faults faults;
    if (!setting.links(samples ? "points" : "mesh")) {
        faults.push_back({"method", samples ? needs_points : needs_mesh});
    }
    if (in.quality != Quality::by_size && samples) faults.push_back({"quality", no_quality});
    if (in.method != Method::solid || in.stiffness != Stiffness::calibrated) return faults;
    if (in.thickness > 0) faults.push_back({"thickness", calibrated_solids});
    if (in.quality != Quality::by_size) faults.push_back({"quality", calibrated_by_size});
    return faults;
}

// A mesh, or one body of it, and what its faces are made of.
struct Solid {
    const geometry::TriMesh& mesh;
    const geometry::FaceMatter& matter;
};

// What becomes of it.
struct Body {
    geometry::Cubes cubes;
    std::vector<physics::ThinPart> thin;
    std::size_t bodies = 1;
    std::size_t doubled = 0;  // triangles that are there twice, where that would count
    NoVolume no_volume = {};
};

static geometry::Cubes cubes_of(const Inputs& in, const Solid& of, const geometry::VoxelGrid& grid,
                                const geometry::VoxelOptions& options)
{
    return in.method == Method::surface
               ? geometry::voxelize_surface(of.mesh, of.matter, in.thickness, grid, options)
               : geometry::voxelize_solid(of.mesh, of.matter, in.inside, in.thickness, grid,
                                          options);
}

static geometry::NearPieces near_pieces_of(const Inputs& in)
{
    return in.pieces == Pieces::apart ? geometry::NearPieces::apart : geometry::NearPieces::merge;
}

// Cubes with attributes, and calibrated where that is asked for. `walls`: whether thin ones are
// looked for, and volumes measured.
static Body body_of(const Inputs& in, const Solid& of, const geometry::VoxelGrid& grid,
                    const geometry::VoxelOptions& options, bool walls,
                    const graph::Context& context)
{
    const bool solid = in.method == Method::solid;
    const auto attributes = geometry::chosen_attributes(in.attributes, of.mesh.attributes);
    Body out{cubes_of(in, of, grid, options), {}, 1};
    if (solid && !(in.thickness > 0) && in.total_mass == 0) {
        out.no_volume = no_volume_of(of.mesh, in.inside, out.cubes, in.min_fill, walls);
    }
    out.cubes = solid ? geometry::with_means_of_solid(std::move(out.cubes), of.mesh, attributes)
                      : geometry::with_means_of_surface(std::move(out.cubes), of.mesh, attributes);
    if (!solid || in.stiffness != Stiffness::calibrated) {
        if (walls) out.thin = physics::thin_parts(of.mesh, out.cubes, {solid, in.thickness});
        return out;
    }
    const auto fine_of = [&](int ratio) {
        const geometry::VoxelGrid fine{grid.size / ratio, grid.origin, ratio * grid.cells};
        geometry::VoxelOptions all;
        all.min_fill = 1e-3;
        all.pieces = options.pieces;
        all.join = in.join;
        return cubes_of(in, of, fine, all);
    };
    out.cubes = with_calibrated_stiffness(of.mesh, out.cubes, in.calibration, fine_of, context);
    return out;
}

static void scale_mass(geometry::Cubes& cubes, double total)
{
    const double scale = total / geometry::total_mass(cubes);
    for (double& mass : cubes.mass) mass *= scale;
}

// By `make`: of faces with a thickness those that are there twice count once.
template <class Make>
static Body make_once(const Inputs& in, const Solid& of, const geometry::VoxelOptions& options,
                      const Make& make)
{
    if (!(in.thickness > 0)) return make(of, options);
    if (in.method == Method::solid) {
        Body out = make(of, options);
        out.doubled = geometry::count_sheet_backs(of.mesh, of.matter.face);
        return out;
    }
    const auto once = geometry::without_doubled(of.mesh, of.matter.face);
    if (!once) return make(of, options);
    Body out = make(Solid{once->mesh, geometry::matter_of_some(of.matter, once->faces)}, options);
    out.doubled = once->doubled;
    return out;
}

// The whole mesh, or each of its bodies by `make`, side by side.
template <class Make>
static Body by_bodies(const Inputs& in, const geometry::FaceMatter& matter,
                      geometry::VoxelOptions options, const Make& make)
{
    if (in.pieces != Pieces::each && in.pieces != Pieces::groups) {
        return make_once(in, Solid{*in.mesh, matter}, options, make);
    }
    const geometry::FaceBodies bodies = in.pieces == Pieces::each
                                            ? geometry::bodies_of_pieces(*in.mesh)
                                            : geometry::bodies_of_groups(*in.mesh);
    if (bodies.count < 2) return make_once(in, Solid{*in.mesh, matter}, options, make);
    const double total = std::exchange(options.total_mass, 0);
    Body out{{}, {}, bodies.count};
    std::vector<geometry::Cubes> all;
    std::size_t cubes = 0;
    for (const geometry::SplitMesh& part : geometry::split(*in.mesh, bodies.of, bodies.count)) {
        const geometry::FaceMatter own = geometry::matter_of_some(matter, part.faces);
        Body body = make_once(in, Solid{part.mesh, own}, options, make);
        out.doubled += body.doubled;
        out.no_volume += body.no_volume;
        cubes += body.cubes.count();
        if (cubes > options.max_cubes) {
            throw std::invalid_argument(
                fmt::format("the first {} of {} bodies have {} cubes, which exceeds max_cubes = "
                            "{}: use larger cubes, or raise max_cubes",
                            all.size() + 1, bodies.count, cubes, options.max_cubes));
        }
        for (physics::ThinPart& thin : body.thin) {
            if (thin.name.empty()) thin.name = fmt::format("body {}", all.size() + 1);
            out.thin.push_back(std::move(thin));
        }
        all.push_back(std::move(body.cubes));
    }
    std::stable_sort(out.thin.begin(), out.thin.end(),
                     [](const auto& a, const auto& b) { return a.factor > b.factor; });
    out.cubes = geometry::side_by_side(all);
    if (total > 0) scale_mass(out.cubes, total);
    return out;
}

// The coarsest cubes that are within the error, and what is said of them.
static geometry::VoxelGrid grid_of_quality(const Inputs& in, const geometry::FaceMatter& matter,
                                           const geometry::VoxelOptions& options,
                                           const graph::Context& context)
{
    if (in.method == Method::surface && in.thickness <= 0) {
        throw std::invalid_argument(surface_needs_thickness);
    }
    const geometry::Box box = geometry::triangle_bounds(*in.mesh);
    if (box.empty()) return grid_for(in);
    const auto cubes_by = [&](double size) {
        const auto make = [&](const Solid& of, const geometry::VoxelOptions& its) {
            return Body{cubes_of(in, of, grid_of_size(in, box, size), its), {}, 1};
        };
        return by_bodies(in, matter, options, make).cubes;
    };
    return grid_of_size(in, box,
                        size_of_quality(*in.mesh, in.method == Method::solid,
                                        {in.quality, in.error, options.max_cubes}, cubes_by,
                                        context));
}

// Cubes of a mesh without faces: one wherever a point lies.
static Outputs of_cloud(const Inputs& in, const geometry::VoxelOptions& options,
                        const graph::Context& context)
{
    if (in.method == Method::solid) {
        throw std::invalid_argument("the mesh is a point cloud: it has no faces that could enclose "
                                    "anything; use method = surface, which makes a cube wherever a "
                                    "point lies");
    }
    if (in.quality != Quality::by_size) throw std::invalid_argument(no_quality);
    if (!in.materials.empty() || in.thickness > 0 || in.pieces != Pieces::merge) {
        context.warn("materials, thickness and pieces have no effect, because the mesh is a point "
                     "cloud: it has no faces");
    }
    geometry::Samples points = geometry::sample_points(*in.mesh, matter_of(in.matter), {});
    geometry::add_attributes(points, *in.mesh,
                             geometry::chosen_attributes(in.attributes, in.mesh->attributes));
    Outputs out{geometry::voxelize_samples(points, grid_for(in), options)};
    warn_of_dust(out.cubes, context);
    context.tell(body_figures(nullptr, out.cubes, false, graph::Figure::unknown));
    return out;
}

static Outputs run(const Inputs& in, const graph::Context& context)
{
    const geometry::VoxelOptions options{static_cast<std::size_t>(in.max_cubes), in.min_fill,
                                         in.total_mass, near_pieces_of(in), in.join};
    if (in.method == Method::samples) {
        if (in.points.empty()) throw std::invalid_argument(needs_points);
        std::vector<const geometry::Samples*> sets;
        for (const auto& set : in.points) sets.push_back(set.get());
        Outputs out{geometry::voxelize_samples(sets, grid_for(in), options)};
        warn_of_dust(out.cubes, context);
        context.tell(body_figures(nullptr, out.cubes, false, graph::Figure::unknown));
        return out;
    }
    if (!in.mesh) throw std::invalid_argument(needs_mesh);
    if (in.mesh->triangles().empty() && !in.mesh->positions.empty()) {
        return of_cloud(in, options, context);
    }
    const geometry::FaceMatter matter =
        face_matter(*in.mesh, matter_of(in.matter), in.materials, context);
    const bool solid = in.method == Method::solid;
    if (solid) warn_of_disagreeing_faces(*in.mesh, in.inside, context);
    if (solid) {
        warn_of_filled_shell(*in.mesh, in.inside, in.thickness, "method = solid",
                             "method = surface", context);
    }
    const bool once = in.pieces == Pieces::merge || in.pieces == Pieces::apart;
    if (solid && once) warn_of_filled_hollow(*in.mesh, matter, in.inside, context);
    if (solid && in.pieces != Pieces::each) warn_of_filled_between(*in.mesh, in.inside, context);
    const geometry::VoxelGrid grid = in.quality == Quality::by_size
                                         ? grid_for(in)
                                         : grid_of_quality(in, matter, options, context);
    constexpr std::size_t looked_at = 256;  // of very many bodies: it takes a millisecond each
    std::size_t made = 0;
    const auto make = [&](const Solid& of, const geometry::VoxelOptions& its) {
        return body_of(in, of, grid, its, made++ < looked_at, context);
    };
    Body body = by_bodies(in, matter, options, make);
    warn_of_doubled_faces(body.doubled, in.mesh->triangles().size(), context);
    warn_of_no_volume(body.no_volume, body.bodies, in.min_fill, context);
    if (in.pieces == Pieces::each) warn_of_welded_groups(*in.mesh, context);
    if (in.pieces == Pieces::groups) warn_of_joined_groups(*in.mesh, body.bodies, context);
    double bending = graph::Figure::unknown, planned = 0;
    if (!solid || in.stiffness != Stiffness::calibrated) {
        planned = warn_of_thin_walls(body.thin, body.cubes, {solid, in.thickness},
                                     options.max_cubes, context);
        if (!body.thin.empty()) bending = body.thin.front().factor;
        const bool seems_right = !(bending > physics::bending_of_thick);
        if (made > looked_at && seems_right) bending = graph::Figure::unknown;
    }
    if (once) {
        warn_of_glued_pieces(*in.mesh, body.cubes, in.pieces == Pieces::apart, in.join, planned,
                             context);
    }
    warn_of_odd_young(body.cubes, context);
    Outputs out{std::move(body.cubes)};
    context.tell(body_figures(in.mesh.get(), out.cubes, solid, bending, once, in.total_mass,
                              once && in.inside == geometry::Inside::parity));
    return out;
}

constexpr const char* how_inside =
    "How inside is decided (method solid); six rays along the axes vote. winding: by the number of "
    "outward less inward faces crossed; right for closed and overlapping pieces. parity: "
    "by an odd number of faces crossed; for meshes whose faces disagree on what is outside and "
    "could not be turned, as where more than two meet at an edge. Faces that lie on others count "
    "once, and those that look in are turned out.";
constexpr const char* near_pieces =
    "How parts are treated that are nearer to each other than a cube, such as the teeth of a comb. "
    "merge: one cube joins all parts in it, and narrow gaps are mended. apart: each part in a cube "
    "gets a cube of its own, and cubes are joined only where material crosses their common face. A "
    "gap of half a cube stays open at any angle. Parts that do not touch are not joined. each: "
    "each piece, which is what triangles with common vertices are, is a body with cubes of its "
    "own, even where it touches or overlaps others: the stones of a wall, boxes in a stack. Faces "
    "of one file that meet have common vertices, unless ReadMesh has weld = groups; those of "
    "Copies and Merge have not. Cavities "
    "belong to what is around them. groups: the same for the pieces of each group of the mesh "
    "together; a chair whose legs and seat are groups of their own falls into these. Simulate "
    "keeps bodies apart by contact. Where bodies share a cell, a tear (lattice.tear) cuts the mesh "
    "of the first alone.";
constexpr const char* join_gap =
    "Largest gap across which parts are joined. Gaps are measured in quarters of a cube: wider "
    "ones "
    "by up to half a cube may be joined too. 0: only parts that touch are joined.";
constexpr const char* about_quality =
    "How the size of the cubes is chosen. by_size: by `size` or `resolution`. draft, good, exact: "
    "the coarsest cubes whose stiffness is within 20 %, 5 %, 1 %; by_error: within `error`. The "
    "error is estimated from the lowest vibrations of the free body with cubes of three sizes and "
    "their observed order, of 30,000 at most (100,000 where else far more would be made), and by "
    "that order, at least 1, beyond. Where that takes more than `max_cubes`, about the finest that "
    "it allows are made. What was chosen, and why, is told in a warning.";
constexpr const char* about_size =
    "Edge of a cube; 0: from `resolution`. Documents may also say \"draft\", \"good\" or "
    "\"exact\", "
    "which is that quality, or {\"auto\": {\"error\": 0.05}}, which is that error.";
constexpr const char* about_min_fill =
    "Smallest fill of a cube: no cube is lighter or softer than one filled to this share, however "
    "little of the model it holds. The mass that this adds is taken from all cubes in proportion: "
    "the density that LocalMatter and Render know is then less than that of the material. A body "
    "that encloses no volume, such as a flat face without `thickness`, weighs what this adds.";
constexpr const char* about_max_cubes =
    "Limit on the number of cubes. Exceeding it is an error that names a size that fits; a size "
    "that `quality` chooses does not exceed it.";
constexpr const char* about_materials =
    "Materials of parts of the model. If several rules match, the last one counts. "
    "Method solid: a closed part of the mesh is filled with the material of its faces, "
    "up to the closed parts within it; a part whose faces are of several materials, and "
    "what is open, has the material of the faces in a cube, or of the nearest one.";

constexpr const char* about_stiffness =
    "How stiff partly filled cubes are. filled: as a whole cube, in the share of its fill; walls "
    "thinner than two cubes, and tilted ones, are too stiff in bending. calibrated: as fine cubes "
    "of the mesh are (numerical coarsening), for methods bricks and Modes. Down to walls "
    "of half a cube, the lowest vibrations are then right within 6 %, and sags within a quarter. "
    "The "
    "fine cubes are solved once, when cubes are made. Changing young (LocalMatter) scales the "
    "stiffness; changing "
    "poisson, and the options weighting and element elsewhere, leave it.";

constexpr const char* about_method =
    "Which cubes are made. samples: one wherever a sample lies; sparse samples leave "
    "holes. surface: one wherever a triangle passes, exactly; a face between two cubes "
    "belongs to the upper one; of a point cloud, one wherever a point lies. solid: "
    "those of surface, and those whose centre is inside.";

constexpr const char* about_thickness =
    "Thickness of the faces: a cube holds the face area in it times this; a face and its back, or "
    "a copy of it, count once. 0: `surface` "
    "treats every cube as full; `solid` counts only the enclosed volume (exact, except "
    "near holes and overlaps, where 4 x 4 x 4 points per cube are sampled).";

constexpr const char* about_attributes =
    "Attributes of the mesh that cubes get, as LocalMatter, CubeMesh, Embed, Measure and Render "
    "know them: names, with commas between them, where * stands for any text and ? for any "
    "character. Empty: none. Method surface: the mean by area of the faces in a cube. Method "
    "solid: the mean over the cube, where each place has the value of the nearest place of the "
    "surface. Samples bring their own.";

static void describe_calibration(graph::ParamsOf<CalibrationParams>& p)
{
    p.param("fine", &CalibrationParams::fine,
            "Fine cubes along the edge of a cube. 0: four through the thinnest wall, or what "
            "200,000 fine cubes allow. More than 400,000 are refused.",
            {0, 32, ""})
        .param("modes", &CalibrationParams::modes,
               "Lowest vibrations of each body that its cubes are calibrated for, beside six loads "
               "that stretch and shear it. A body of one part is right with 12; one of many thin "
               "limbs needs some for each. Where a cube takes part in more, it becomes too soft.",
               {1, 200, ""});
}

void add_to(graph::Registry& registry)
{
    const graph::ShownWhen of_mesh{"method", {"surface", "solid"}};
    registry.add("Voxelize", 1, run)
        .summary("Converts samples or a mesh to equal cubes with shared corners: the deformable "
                 "model. Memory grows with the number of cubes, not with the box around them.")
        .inputs("points", &Inputs::points,
                "Samples to convert (method samples). Their own masses and materials count. "
                "Several sets make one model.")
        .input("mesh", &Inputs::mesh,
               "The mesh to convert (methods surface and solid). With method samples it only "
               "places the grid, so that several models can share one.",
               graph::Need::optional)
        .choice("method", &Inputs::method, {"samples", "surface", "solid"}, about_method)
        .short_forms({write_out_size, {{"size", size_forms}}})
        .choice("quality", &Inputs::quality, {"by_size", "draft", "good", "exact", "by_error"},
                about_quality)
        .param("error", &Inputs::error,
               "Largest relative error of deflections under loads that may come from the size of "
               "the cubes.",
               {0.001, 1, ""}, {"quality", {"by_error"}})
        .param("size", &Inputs::size, about_size, {0, 1e12, "m"}, {"quality", {"by_size"}})
        .param("resolution", &Inputs::resolution,
               "Number of cubes along the model's longest side, if size is 0.",
               {1, 1'000'000, "cubes"}, {"quality", {"by_size"}})
        .choice("align", &Inputs::align, {"fit", "origin"},
                "Where the grid lies. fit: centred on the model. origin: cube 0 starts at a given "
                "point, so that the grids of several models agree.")
        .param("origin", &Inputs::origin, "Lowest corner of cube 0.", {.unit = "m"},
               {"align", {"origin"}})
        .choice("inside", &Inputs::inside, {"winding", "parity"}, how_inside, {"method", {"solid"}})
        .choice("pieces", &Inputs::pieces, {"merge", "apart", "each", "groups"}, near_pieces,
                of_mesh)
        .param("join", &Inputs::join, join_gap, {0, 1e6, "m"}, {"pieces", {"apart"}})
        .param("thickness", &Inputs::thickness, about_thickness, {0, 1e6, "m"}, of_mesh)
        .choice("stiffness", &Inputs::stiffness, {"filled", "calibrated"}, about_stiffness,
                {"method", {"solid"}})
        .block("calibration", &Inputs::calibration, describe_calibration,
               "How the stiffness is calibrated.", {"stiffness", {"calibrated"}})
        .block("matter", &Inputs::matter, describe_matter<ChosenMatter>,
               "Material of the model where no rule of `materials` matches.", of_mesh)
        .list("materials", &Inputs::materials, describe_rule, about_materials, of_mesh)
        .param("attributes", &Inputs::attributes, about_attributes, {}, of_mesh)
        .param("total_mass", &Inputs::total_mass,
               "Total mass to which all masses are scaled; 0: masses follow from densities (or "
               "samples).",
               {0, 1e15, "kg"})
        .param("min_fill", &Inputs::min_fill, about_min_fill, {0, 1, ""})
        .param("max_cubes", &Inputs::max_cubes, about_max_cubes, {1, 1e9, "cubes"})
        .check(check)
        .output("cubes", &Outputs::cubes,
                "The cubes, with mass, fill and material. Materials in one cube are averaged by "
                "volume.");
}

}  // namespace nodes::voxelize

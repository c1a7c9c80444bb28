#include "physics/mixed/mixed_body.hpp"

#include "geometry/cubes/plane.hpp"
#include "physics/body/join_bodies.hpp"
#include "physics/body/make_sheet_cells.hpp"
#include "physics/bricks/factor_cache.hpp"
#include "physics/bricks/time_step.hpp"

#include <limits>
#include <stdexcept>

namespace physics {
namespace {

// The models of one kind, and which corners and cubes of all are theirs.
struct Kind {
    std::vector<BodyModel> models;
    std::vector<std::uint32_t> corner, cube;
    std::vector<std::uint8_t> rigid;
};

void add(const BodyModel& model, std::uint32_t first_corner, std::uint32_t first_cube, Kind& to)
{
    to.models.push_back(model);
    for (std::uint32_t k = 0; k < model.cubes->corner_count(); ++k) {
        to.corner.push_back(first_corner + k);
    }
    for (std::uint32_t c = 0; c < model.cubes->count(); ++c) to.cube.push_back(first_cube + c);
}

}  // namespace

MixedBody make_mixed(std::span<const BodyModel> models, const BrickOptions& bricks,
                     const ShellOptions& shell)
{
    if (shell.plastic.yield > 0) {
        throw std::invalid_argument("sheets beside solids do not yield: set shell.plastic.yield to "
                                    "0, or simulate the sheets alone with method = shell");
    }
    Kind solids, sheets;
    std::vector<JoinedModel> joined;
    std::uint32_t corner = 0, cube = 0;
    for (std::size_t m = 0; m < models.size(); ++m) {
        const geometry::Cubes& cubes = *models[m].cubes;
        const bool flat = geometry::flat_axis(cubes) >= 0;
        joined.push_back({flat, cubes.corner_count()});
        // Sheets are touched at their own corners, by what edges of solids come between these.
        add({&cubes, flat ? nullptr : models[m].surface}, corner, cube, flat ? sheets : solids);
        if (!flat) solids.rigid.push_back(m < bricks.rigid.size() ? bricks.rigid[m] : 0);
        if (flat && m < bricks.rigid.size() && bricks.rigid[m] != 0) {
            throw std::invalid_argument("model " + std::to_string(m + 1) +
                                        " is a sheet, which bends: set `rigid` of it to false, or "
                                        "make cubes with a thickness by Voxelize");
        }
        corner += static_cast<std::uint32_t>(cubes.corner_count());
        cube += static_cast<std::uint32_t>(cubes.count());
    }
    if (solids.models.empty() || sheets.models.empty()) {
        throw std::invalid_argument("expected both sheets and solids, found one kind alone");
    }
    BrickOptions own = bricks;
    own.rigid = solids.rigid;
    ShellOptions thin = shell;
    thin.contact = bricks.contact;
    const BodyModels of_solids(solids.models), of_sheets(sheets.models, ModelKind::plane);
    MixedBody body;
    body.bricks = make_bricks(of_solids, own);
    body.shell = make_shell(of_sheets, thin);
    std::unique_ptr<SolidsBesideSheets> touching;
    if (bricks.contact.on) {
        touching = std::make_unique<SolidsBesideSheets>(
            make_solids_beside_sheets(of_solids, body.bricks.base, bricks.contact));
        touching->cells = make_sheet_cells(of_sheets, body.shell.base, bricks.contact);
    }
    body.base = join_bodies(body.bricks.base, body.shell.base, joined, std::move(touching));
    body.solid_corner = std::move(solids.corner), body.sheet_corner = std::move(sheets.corner);
    body.solid_cube = std::move(solids.cube);
    body.cubes = cube;
    body.dissections = std::make_shared<DissectionCache>();
    return body;
}

std::size_t MixedBody::bytes() const
{
    return sizeof *this - sizeof bricks - sizeof shell - sizeof base + base.bytes() +
           bricks.bytes() + shell.bytes() +
           (solid_corner.size() + sheet_corner.size() + solid_cube.size()) * sizeof(std::uint32_t);
}

State rest_state(const MixedBody& body)
{
    State state = rest_state(body.base);
    state.brick_mass = body.has_brick_mass();
    constexpr float unknown = std::numeric_limits<float>::quiet_NaN();  // of sheets
    state.stress.assign(body.cubes, unknown);
    for (const auto c : body.solid_cube) state.stress[c] = 0;
    state.energy = state.stress;
    if (body.bricks.plastic.yield > 0) state.plastic_strain.assign(body.cubes, 0.0f);
    return state;
}

}  // namespace physics

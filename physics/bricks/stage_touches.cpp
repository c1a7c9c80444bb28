#include "physics/bricks/stage_touches.hpp"

#include "geometry/base/parallel.hpp"
#include "physics/body/collider_touches.hpp"
#include "physics/body/external_forces.hpp"
#include "physics/body/sheet_contact.hpp"
#include "physics/body/solid_points.hpp"
#include "physics/body/solids_beside_sheets.hpp"
#include "physics/bricks/bounce.hpp"
#include "physics/bricks/joints.hpp"
#include "physics/bricks/radial_on_way.hpp"
#include "physics/math/for_numbers.hpp"

#include <algorithm>
#include <cmath>

namespace physics {
namespace {

using geometry::Box;

bool between_rigid(const Stage& stage, const PlaneTouch& touch)
{
    const CornerBody& body = stage.frame.body;
    if (stage.rigid.none() || body.rigid[body.part_of(touch.corners[0])] == 0) return false;
    return touch.count == 8 || body.rigid[body.part_of(touch.corners[8])] != 0;
}

// A rigid part stops as a whole: what touches it would give back the speed that it stores as a
// spring, were it not as stiff as stops that mass within a step.
void stop_rigid(const Stage& stage, std::vector<PlaneTouch>& found)
{
    constexpr double stiff = 30;  // a step gives back a 30th of the speed
    if (stage.rigid.none()) return;
    const CornerBody& body = stage.frame.body;
    for (PlaneTouch& touch : found) {
        if (!between_rigid(stage, touch)) continue;
        const auto part = body.part_of(touch.corners[0]);
        const auto other = touch.count > 8 ? body.part_of(touch.corners[8]) : part;
        const double mass = std::min(stage.frame.part_mass[part], stage.frame.part_mass[other]);
        const double least = stiff * mass / (stage.tau * stage.tau);
        touch.stiffness = std::max(touch.stiffness, least);
        touch.at_rest = std::max(touch.at_rest, least);
    }
}

SlackTime time_of_slack(const Stage& stage)
{
    return {stage.tau, !has_sheets(stage.frame.body)};
}

// A point of what is soft may be found deeper in something than it was when the last step ended, or
// deep in what it did not touch then. It leaves by that depth within a step: the faster, the
// shorter that is. In eighths of a step, which gained energy when they were longer, it comes out at
// a quarter of the speed that it has against that, and at what a fall by half a cube gives; the
// rest is slack. (At all of that speed, crushed cubes that push each other gain energy from step to
// step. In longer parts of a step, letters that fall on a heap come to rest deeper.)
//
// The stiffness of what is rigid grows with shorter steps, so that nothing else bounds its speed:
// in a step shorter than was asked for, it comes out as fast as in one of these.
void catch_late(const Stage& stage, std::vector<PlaneTouch>& found)
{
    constexpr int often = 3;
    constexpr double deep = 0.01;  // cubes
    const StepFrame& frame = stage.frame;
    const double share = stage.tau * least_steps(frame.options) / frame.seconds;  // of a step
    const bool late = stage.halvings >= often;
    if (!late && (stage.rigid.none() || !(share < 1))) return;
    for (PlaneTouch& touch : found) {
        const double deeper = depth_at_start(stage, touch) - std::max(touch.began, touch.slack);
        if (between_rigid(stage, touch)) {
            touch.slack += std::max(0.0, (1 - share) * deeper);
            continue;
        }
        if (!late || !(deeper > deep * touch.size)) continue;
        const double speed =
            0.25 * touch.velocity(stage.began_v.data()).norm() + slack_speed(touch.size);
        touch.slack += std::max(0.0, deeper - stage.tau * speed);
    }
}

// What colliders touch at x when corners came there at stage.w.
std::vector<PlaneTouch> find_holds(const Stage& stage, const Aligned<double>& x)
{
    const CornerBody& body = stage.frame.body;
    auto found = find_collider_touches(body, x.data(), stage.w.data(), stage.colliders, stage.held,
                                       stage.tau);
    if (body.solids) {
        join_solids(body, x.data(), stage.colliders, found);
        const auto others = static_cast<std::uint32_t>(stage.colliders.size());
        const std::span solids(stage.colliders.end() - std::ptrdiff_t(body.solids->solid.size()),
                               stage.colliders.end());
        const SolidPointStep step{stage.x0.data(), x.data(), stage.tau, stage.held, others, solids};
        found = put_in_order({found, find_solid_points(body, step)});
    }
    stop_rigid(stage, found);
    take_grips(found, stage.held, time_of_slack(stage));
    if (!body.sheets) catch_late(stage, found);
    return found;
}

// The ways of each part's corners from one place to another, m.
std::vector<Box> ways_of_parts(const PartShapes& shapes, const Aligned<double>& from,
                               const Aligned<double>& to)
{
    std::vector<Box> out(shapes.parts());
    geometry::parallel_for(shapes.parts(), 16, [&](std::size_t begin, std::size_t end) {
        for (std::size_t p = begin; p < end; ++p) {
            for (const auto slot : shapes.slots[p]) {
                const std::size_t at = 4 * std::size_t{slot};
                out[p].add(Eigen::Map<const Vec3>(to.data() + at) -
                           Eigen::Map<const Vec3>(from.data() + at));
            }
        }
    });
    return out;
}

// Keeps stage.x as where the pairs that `looked` says `now` of were looked at, in place of what no
// pair was looked at in last.
void keep_place(Stage& stage, std::uint32_t now)
{
    std::vector<std::uint8_t> used(std::size_t{now} + 1, 0);
    for (const auto at : stage.looked) used[at] = 1;
    const auto free =
        static_cast<std::uint32_t>(std::find(used.begin(), used.end(), 0) - used.begin());
    if (free >= now) {
        stage.looked_at.push_back(stage.x);
        return;
    }
    stage.looked_at[free] = stage.x;
    std::replace(stage.looked.begin(), stage.looked.end(), now, free);
}

// Of the pairs that are near, those whose corners may have moved further than `far` (m) against
// each other since they were looked at last. They count as looked at now.
std::vector<PartPair> moved_pairs(Stage& stage, double far)
{
    const PartShapes& shapes = *stage.frame.body.shapes;
    const auto now = static_cast<std::uint32_t>(stage.looked_at.size());
    std::vector<std::vector<Box>> ways(now);
    std::vector<PartPair> out;
    for (std::size_t i = 0; i < stage.near.size(); ++i) {
        std::vector<Box>& way = ways[stage.looked[i]];
        if (way.empty()) way = ways_of_parts(shapes, stage.looked_at[stage.looked[i]], stage.x);
        const Box &a = way[stage.near[i].a], &b = way[stage.near[i].b];
        if ((a.hi - b.lo).cwiseMax(b.hi - a.lo).norm() <= far) continue;
        out.push_back(stage.near[i]);
        stage.looked[i] = now;
    }
    if (!out.empty()) keep_place(stage, now);
    return out;
}

// Adds what parts touch at x.
bool find_part_touches(Stage& stage, double much)
{
    const auto pairs = moved_pairs(stage, known_before * stage.frame.body.h);
    if (pairs.empty()) return false;
    auto found = find_part_touches(*stage.frame.body.shapes, pairs, stage.x.data(), stage.w.data(),
                                   stage.tau, Look::back, stage.touches);
    if (found.empty()) return false;
    stop_rigid(stage, found);
    take_grips(found, stage.grips, time_of_slack(stage));
    catch_late(stage, found);
    return add_found(stage.touches, found, stage.x.data(), much);
}

// The same of colliders, where the body has come to be far from where they were looked for last.
bool find_collider_touches(Stage& stage, Known known, double much)
{
    constexpr double far = 0.5 * known_before;  // cubes: they may have moved as far
    double moved = 0;
    for (std::size_t i = 0; i < stage.frame.n; ++i) {
        moved = std::max(moved, std::abs(stage.x[i] - stage.holds_at[i]));
    }
    if (moved <= far * stage.frame.body.h) return false;
    stage.holds_at = stage.x;
    if (stage.frame.body.solids) {
        stage.colliders.resize(stage.frame.loads.colliders.size());
        pose_solids(stage.frame.body, stage.x0.data(), stage.x.data(), stage.tau, stage.solids,
                    stage.colliders);
    }
    const auto found = find_holds(stage, stage.x);
    return known == Known::kept ? add_found(stage.holds, found, stage.x.data(), much)
                                : renew(stage.holds, found, stage.x.data(), much);
}

// What sheets touch on the way from the start to x, without what is `known`.
std::vector<PlaneTouch> look_at_sheets(Stage& stage, const Aligned<double>& x,
                                       const std::vector<PlaneTouch>& known)
{
    stage.sheets_at = x;
    auto found = find_sheet_touches(stage.frame.body,
                                    {stage.began.data(), x.data(), stage.tau, stage.grips}, known);
    take_grips(found, stage.grips, time_of_slack(stage));
    return found;
}

// A shot may begin with bodies that are a bit inside each other or colliders, or with the middle of
// a sheet on a collider: they come out slowly, and are not thrown out.
void lay_down(const Stage& stage, const std::vector<Grip>& grips, std::vector<PlaneTouch>& touches)
{
    for (PlaneTouch& touch : touches) {
        if (find_grip(grips, touch.point, touch.other)) continue;
        touch.slack = std::max(0.0, depth_at_start(stage, touch));
    }
}

// What starts within the thickness of a sheet is not thrown out, unless it slid there.
void start_sheets(Stage& stage)
{
    Aligned<double> ahead = stage.x0;
    for (std::size_t i = 0; i < ahead.size(); ++i) ahead[i] += stage.tau * stage.v0[i];
    auto found = look_at_sheets(stage, ahead, {});
    for (PlaneTouch& touch : found) {
        const double deep = -touch.gap(stage.x0.data());
        if (!(deep > 0) || find_grip(stage.grips, touch.point, touch.other)) continue;
        const Grip* const beside = grip_beside(stage.frame.body, stage.grips, touch);
        const double known =
            beside ? slack_left(double(beside->slack), touch.size, time_of_slack(stage)) : 0;
        touch.slack = std::min(deep, beside ? known : touch.size);
    }
    stage.touches.insert(stage.touches.end(), found.begin(), found.end());
}

// How far corners have come from where sheets were looked at last, but for what they have come
// together, m.
double moved_against_each_other(const Stage& stage)
{
    const std::size_t corners = stage.frame.body.corners;
    const auto way = [&](std::size_t k) {
        return Vec3(Eigen::Map<const Vec3>(&stage.x[4 * k]) -
                    Eigen::Map<const Vec3>(&stage.sheets_at[4 * k]));
    };
    Vec3 mean = Vec3::Zero();
    for (std::size_t k = 0; k < corners; ++k) mean += way(k) / static_cast<double>(corners);
    double most_sq = 0;
    for (std::size_t k = 0; k < corners; ++k) {
        most_sq = std::max(most_sq, (way(k) - mean).squaredNorm());
    }
    return std::sqrt(most_sq);
}

// Finds what sheets touch at x. Planes that were found where the body is not going are put right,
// as long as rounds are not wary.
bool find_sheets(Stage& stage, Known known)
{
    const SheetCells& cells = *stage.frame.body.sheets;
    const double much = 0.05 * cells.thinnest;
    if (!(moved_against_each_other(stage) > 0.5 * (cells.reach - cells.thickest))) return false;
    if (stage.wary || known == Known::kept) {
        return add_found(stage.touches, look_at_sheets(stage, stage.x, stage.touches),
                         stage.x.data(), much);
    }
    // Those of solid parts come first.
    const auto of_parts = std::find_if(stage.touches.begin(), stage.touches.end(),
                                       [&](auto& t) { return t.point >= cells.first_number; });
    std::vector<PlaneTouch> own(of_parts, stage.touches.end());
    stage.touches.erase(of_parts, stage.touches.end());
    const bool changed = renew(own, look_at_sheets(stage, stage.x, {}), stage.x.data(), much);
    stage.touches.insert(stage.touches.end(), own.begin(), own.end());
    return changed;
}

}  // namespace

double depth_at_start(const Stage& stage, const PlaneTouch& touch)
{
    return -touch.gap(stage.began.data()) - stage.tau * touch.drift.dot(touch.normal);
}

void start_stage(Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0, double tau,
                 double share)
{
    const StepFrame& frame = stage.frame;
    const Loads& loads = frame.loads;
    const bool lays = frame.first && !frame.options.leaps;
    stage.tau = tau;
    stage.share = share;
    for (Aligned<double>* v : {&stage.began, &stage.x0}) copy_numbers(x0, *v);
    for (Aligned<double>* v : {&stage.began_v, &stage.v0}) copy_numbers(v0, *v);
    if (stage.elasticity.targets_move()) {
        stage.elasticity.at_share(share);
        stage.linear_at.clear();
    }
    stage.base.clear();
    stage.lifted.clear();
    stage.struck = false;
    for (Aligned<double>* v : {&stage.wind, &stage.drag}) fill_numbers(*v, frame.n, 0.0);
    if (frame.windy) {
        add_wind(frame.body, frame.forces, x0.data(), v0.data(), stage.wind, stage.drag);
        start_radial_forces(stage);
    }
    stage.colliders.clear();
    for (const Collider& c : loads.colliders) {
        stage.colliders.push_back(pose_collider(c, share, frame.seconds, frame.body.greatest_edge,
                                                frame.first, frame.body.skin.thickest));
    }
    stage.near.clear();
    stage.touches.clear();
    stage.holds.clear();
    if (frame.body.shapes) {
        stage.near = near_parts(*frame.body.shapes, x0.data(), v0.data(), tau);
        stage.touches = find_part_touches(*frame.body.shapes, stage.near, x0.data(), v0.data(), tau,
                                          Look::ahead);
        stop_rigid(stage, stage.touches);
        take_grips(stage.touches, stage.grips, time_of_slack(stage));
        catch_late(stage, stage.touches);
        if (lays) lay_down(stage, stage.grips, stage.touches);
    }
    if (frame.body.solids) {
        pose_solids(frame.body, nullptr, x0.data(), tau, stage.solids, stage.colliders);
        forget_tangles(frame.body, stage.colliders.size(), stage.held);
    }
    if (frame.body.sheets) start_sheets(stage);
    if (!stage.colliders.empty()) {
        fill_numbers(stage.w, frame.n, 0.0);
        stage.holds = find_holds(stage, x0);
        if (lays) lay_down(stage, stage.held, stage.holds);
    }
    aim_bounces(stage);
    copy_numbers(x0, stage.holds_at);
    stage.looked_at.assign(stage.near.empty() ? 0 : 1, x0);
    stage.looked.assign(stage.near.size(), 0);
    copy_numbers(v0, stage.w);
    for_held_axes(frame, [&](std::size_t pin, std::size_t axis, std::size_t number) {
        const double to = frame.pin_paths.at(pin, share)[static_cast<Eigen::Index>(axis)];
        stage.w[number] = (to - x0[number]) / tau;
    });
}

bool find_touches(Stage& stage, Known known)
{
    constexpr double much = 0.01;  // cubes
    if (!may_touch(stage)) return false;
    const double h = stage.frame.body.h;
    bool changed = false;
    if (!stage.near.empty()) changed = find_part_touches(stage, much * h);
    if (stage.frame.body.sheets) changed |= find_sheets(stage, known);
    if (!stage.colliders.empty()) changed |= find_collider_touches(stage, known, much * h);
    aim_bounces(stage);
    return changed;
}

bool firm_up(Stage& stage, const Aligned<double>& before)
{
    constexpr double deep = 0.05;  // cubes: it ends within a tenth of a cube
    const Aligned<double>& start = stage.rigid.none() ? stage.x0 : stage.began;
    const Firming firming{before.data(), stage.x.data(), deep, start.data(), stage.tau};
    const bool holds = firm_up(stage.holds, firming);
    return firm_up(stage.touches, firming) || holds;
}

Aligned<double> mean_velocities(const Stage& stage)
{
    Aligned<double> out = stage.w;
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {
        for (const auto slot : stage.rigid.corners(i)) {
            for (std::size_t at = 4 * std::size_t{slot}; at < 4 * std::size_t{slot} + 3; ++at) {
                out[at] += (stage.x0[at] - stage.began[at]) / stage.tau;
            }
        }
    }
    return out;
}

std::vector<PointContact> touching(const Stage& stage)
{
    constexpr double nearly = 0.95;  // the derivative itself may leave a slip with no resistance
    const double tangent = stage.wary ? nearly : 0;
    const bool touches = !stage.holds.empty() || !stage.touches.empty();
    const bool arcs = touches && !stage.rigid.none();
    const Aligned<double> mean = arcs ? mean_velocities(stage) : Aligned<double>();
    const double* const v = arcs ? mean.data() : stage.w.data();
    auto out = press(stage.holds, stage.x.data(), v, stage.tau, tangent);
    add_joints(stage, stage.x, out);
    if (stage.touches.empty()) return out;
    const auto parts = press(stage.touches, stage.x.data(), v, stage.tau, tangent);
    out.insert(out.end(), parts.begin(), parts.end());
    return out;
}

FoundTouches found_so_far(const Stage& stage)
{
    return {stage.touches,   stage.holds,    stage.looked_at, stage.looked,
            stage.sheets_at, stage.holds_at, stage.struck};
}

void go_back_to(const FoundTouches& found, Stage& stage)
{
    stage.touches = found.touches, stage.holds = found.holds;
    stage.looked_at = found.looked_at, stage.looked = found.looked;
    stage.sheets_at = found.sheets_at, stage.holds_at = found.holds_at;
    stage.struck = found.struck;
}

std::vector<PointContact> contacts_ahead(Stage& stage, const Aligned<double>& w)
{
    const FoundTouches found = found_so_far(stage);
    const Aligned<double> before_w = stage.w, before_x = stage.x;
    stage.w = w;
    place(stage);
    find_touches(stage);
    std::vector<PointContact> out = touching(stage);
    stage.w = before_w, stage.x = before_x;
    go_back_to(found, stage);
    return out;
}

std::vector<Grip> with_corners(const CornerBody& body, std::vector<Grip> grips)
{
    if (grips.empty() || body.slot.empty()) return grips;
    std::vector<std::uint32_t> corner(body.corners, Grip::no_corner);  // by slot
    for (std::uint32_t k = 0; k < body.corners; ++k) corner[body.slot_of(k)] = k;
    for (Grip& grip : grips) {
        for (auto& slot : grip.corners) {
            slot = slot < corner.size() ? corner[slot] : Grip::no_corner;
        }
    }
    return grips;
}

void hold_loads(Stage& stage)
{
    hold_loads(stage.touches, stage.x.data());
    hold_loads(stage.holds, stage.x.data());
}

void hold_first_loads(Stage& stage)
{
    const double times = stage.rigid.none() ? 2 : 0;  // stiff contacts take fewer rounds from none
    hold_first_loads(stage.touches, stage.x.data(), times);
    hold_first_loads(stage.holds, stage.x.data(), times);
}

double friction_off(const Stage& stage)
{
    const HeldFriction a = held_friction(stage.touches, stage.x.data());
    const HeldFriction b = held_friction(stage.holds, stage.x.data());
    const double off = a.off + b.off, all = a.all + b.all;
    if (!(off > 0)) return 0;
    return all > 0 ? off / all : 1;  // loads are held where nothing pushes any more
}

}  // namespace physics

#include "physics/bricks/rigid_energy.hpp"

#include "physics/bricks/free_parts.hpp"
#include "physics/bricks/joints.hpp"
#include "physics/bricks/radial_on_way.hpp"
#include "physics/state/hold_matter.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace physics {
namespace {

using geometry::Mat3;

struct RigidGroup {
    bool rigid = true;       // all of it, touching nothing
    bool held = false;       // by pins
    std::uint32_t axes = 0;  // that they hold
    bool joined = false;     // of several parts
    double due = 0;          // J, T before and W
    double kinetic = 0;      // J, now
    RigidPart as_one = {};   // now

    double lost() const;    // J
    double moving() const;  // J, T now beside that of its motion as one
    bool is_hit() const;
};

Vec3 of_slot(const Aligned<double>& v, std::size_t slot)
{
    return {v[4 * slot], v[4 * slot + 1], v[4 * slot + 2]};
}

double energy_of(const RigidPart& part)
{
    return 0.5 * (part.mass * part.velocity.squaredNorm() + part.spin.dot(part.momentum));
}

double RigidGroup::lost() const
{
    return due - kinetic;
}
double RigidGroup::moving() const
{
    return kinetic - energy_of(as_one);
}

// A group that lost more than this share of what it has was hit.
constexpr double much = 0.5;

bool RigidGroup::is_hit() const
{
    return !(lost() <= much * moving());
}

class RigidGroups {
public:
    explicit RigidGroups(const Stage& stage)
        : stage_(stage), body_(stage.frame.body),
          of_(joined_parts(body_, stage.frame.loads.joints)), all(of_.size())
    {
        std::vector<std::uint8_t> rigid(of_.size(), 0);
        for (std::size_t i = 0; i < stage.rigid.count(); ++i) rigid[stage.rigid.part(i)] = 1;
        for (std::uint32_t p = 0; p < of_.size(); ++p) {
            if (rigid[p] == 0) all[of_[p]].rigid = false;
            if (of_[p] != p) all[of_[p]].joined = true;
        }
        const HeldMatter& matter = stage.frame.loads.pins.matter;
        const std::vector<Vec3> from = stage.elasticity.targets(0);
        for (const HeldCube& cube : matter.cubes) {
            RigidGroup& group = of_corner(matter.corner[cube.corner[0]]);
            group.held = true;
            group.axes |= cube.axes;
            const auto moves = [&](std::uint32_t i) { return from[i] != matter.target[i]; };
            if (std::any_of(cube.corner.begin(), cube.corner.end(), moves)) group.rigid = false;
        }
        for (const PlaneTouch& touch : stage.touches) leave_out(touch);
        for (const PlaneTouch& touch : stage.holds) leave_out(touch);
    }

    RigidGroup& of_part(std::uint32_t part) { return all[of_[part]]; }
    RigidGroup& of_corner(std::uint32_t corner)
    {
        return of_part(body_.part_of(body_.slot_of(corner)));
    }
    bool keeps(std::uint32_t part) { return kept(of_part(part)); }
    static bool kept(const RigidGroup& group)
    {
        return group.rigid && (group.held || group.joined);
    }

private:
    void leave_out(const PlaneTouch& touch)
    {
        if (!(touch.depth(stage_.x.data()) > 0)) return;
        of_part(body_.part_of(touch.corners[0])).rigid = false;
        if (touch.count > 8) of_part(body_.part_of(touch.corners[8])).rigid = false;
    }

    const Stage& stage_;
    const CornerBody& body_;
    std::vector<std::uint32_t> of_;

public:
    std::vector<RigidGroup> all;
};

// W, with drag and damping. Radial forces do theirs as they are in the middle of the way.
void add_work(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& x,
              RigidGroups& groups)
{
    const StepFrame& frame = stage.frame;
    Aligned<double> more;
    if (!stage.radial.empty()) {
        Aligned<double> middle = x0;
        for (std::size_t i = 0; i < middle.size(); ++i) middle[i] += 0.5 * (x[i] - x0[i]);
        more = radial_beyond_stage(stage, middle);
    }
    for (std::size_t k = 0; k < frame.body.corners; ++k) {
        const auto part = frame.body.part_of(k);
        if (!groups.keeps(part)) continue;
        double& due = groups.of_part(part).due;
        for (std::size_t i = 4 * k; i < 4 * k + 3; ++i) {
            const double force =
                frame.steady[i] + stage.wind[i] - (frame.damping[i] + stage.drag[i]) * stage.w[i];
            due += (force + (more.empty() ? 0 : more[i])) * (x[i] - x0[i]);
        }
    }
}

// What the springs that hold material store at x, J. Those that hold a corner of a rigid part as it
// stays (rigid_pins.hpp) are so stiff that theirs is an error of the step.
double stored(const Stage& stage, const HeldCube& cube, const Aligned<double>& x)
{
    const HeldMatter& matter = stage.frame.loads.pins.matter;
    if (cube.corner[0] == cube.corner[7]) return 0;
    std::array<Vec3, 8> away;
    for (std::size_t a = 0; a < 8; ++a) {
        const auto k = stage.frame.body.slot_of(matter.corner[cube.corner[a]]);
        away[a] = of_slot(x, k) - matter.target[cube.corner[a]];
        for (unsigned i = 0; i < 3; ++i) {
            if ((cube.axes >> i & 1) == 0) away[a][static_cast<Eigen::Index>(i)] = 0;
        }
    }
    double sum = 0;
    for (std::size_t a = 0; a < 8; ++a) {
        for (std::size_t b = 0; b < 8; ++b) {
            sum += 0.5 * stiffness_at(cube, a, b) * away[a].dot(away[b]);
        }
    }
    return sum;
}

void add_stored(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& x,
                RigidGroups& groups)
{
    const HeldMatter& matter = stage.frame.loads.pins.matter;
    for (const HeldCube& cube : matter.cubes) {
        RigidGroup& group = groups.of_corner(matter.corner[cube.corner[0]]);
        if (RigidGroups::kept(group)) {
            group.due += stored(stage, cube, x0) - stored(stage, cube, x);
        }
    }
}

// How parts move on the whole: mass, centre and velocity.
RigidPart mean_of(const std::vector<RigidPart>& parts, const std::vector<std::uint32_t>& own)
{
    RigidPart sum;
    for (const auto p : own) {
        sum.mass += parts[p].mass;
        sum.centre += parts[p].mass * parts[p].centre;
        sum.velocity += parts[p].mass * parts[p].velocity;
    }
    sum.centre /= sum.mass, sum.velocity /= sum.mass;
    return sum;
}

// Of a group that is held: the mean motion along the axes that no pin holds.
RigidPart slide_freely(const RigidGroup& group, const std::vector<RigidPart>& parts,
                       const std::vector<std::uint32_t>& own)
{
    RigidPart sum = mean_of(parts, own);
    for (unsigned i = 0; i < 3; ++i) {
        if ((group.axes >> i & 1) != 0) sum.velocity[static_cast<Eigen::Index>(i)] = 0;
    }
    return sum;
}

// Of all parts as they move in a group.
RigidPart move_as_one(const std::vector<RigidPart>& parts, const std::vector<std::uint32_t>& own)
{
    RigidPart sum = mean_of(parts, own);
    for (const auto p : own) {
        const Vec3 arm = parts[p].centre - sum.centre;
        sum.inertia += parts[p].inertia + parts[p].mass * (arm.squaredNorm() * Mat3::Identity() -
                                                           arm * arm.transpose());
        sum.momentum +=
            parts[p].momentum + parts[p].mass * arm.cross(parts[p].velocity - sum.velocity);
    }
    sum.spin = spin_of(sum.inertia, sum.momentum);
    return sum;
}

// Of groups that went from x0, v0 to x, v in the stage.
void find_energies(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0,
                   const Aligned<double>& x, const Aligned<double>& v, RigidGroups& groups)
{
    const auto before = rigid_parts(stage, x0, v0), after = rigid_parts(stage, x, v);
    std::vector<std::vector<std::uint32_t>> own(groups.all.size());
    for (std::uint32_t p = 0; p < stage.frame.body.parts; ++p) {
        if (!groups.keeps(p)) continue;
        RigidGroup& group = groups.of_part(p);
        group.due += energy_of(before[p]), group.kinetic += energy_of(after[p]);
        own[std::size_t(&group - groups.all.data())].push_back(p);
    }
    add_work(stage, x0, x, groups);
    add_stored(stage, x0, x, groups);
    for (std::size_t g = 0; g < own.size(); ++g) {
        RigidGroup& group = groups.all[g];
        if (own[g].empty()) continue;
        group.as_one = group.held ? slide_freely(group, after, own[g]) : move_as_one(after, own[g]);
    }
}

// Whether its velocity changes so little in the stage that its place is the same, as of what is
// pinned all over.
bool is_steady(const Stage& stage, std::size_t i)
{
    constexpr double little = 1e-7;  // cubes
    const RigidMotion& m = stage.rigid.motion[i];
    const double edge = stage.frame.body.edge_at(stage.rigid.corners(i)[0]);
    const double faster = (m.v - m.began.velocity).norm() + edge * (m.s - m.began.spin).norm();
    return stage.tau * faster <= little * edge;
}

}  // namespace

bool HeldPlaces::take_means(Stage& stage)
{
    if (stage.rigid.none() || !stage.turns_start || stage.frame.options.leaps) return false;
    if (stage.frame.loads.pins.matter.cubes.empty()) return false;
    place(stage);
    RigidGroups groups(stage);
    find_energies(stage, stage.began, stage.began_v, stage.x, stage.w, groups);
    impact_.assign(stage.rigid.count(), std::numeric_limits<double>::infinity());
    bool any = false;
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {
        const RigidGroup& group = groups.of_part(stage.rigid.part(i));
        if (!group.held || !group.rigid || is_steady(stage, i)) continue;
        place_by_means(stage, i);
        if (group.is_hit()) impact_[i] = group.lost();
        any = true;
    }
    return any;
}

bool HeldPlaces::take_ends(Stage& stage, Which which)
{
    constexpr double much_left = 0.5;
    place(stage);
    RigidGroups groups(stage);
    find_energies(stage, stage.began, stage.began_v, stage.x, stage.w, groups);
    bool any = false;
    for (std::size_t i = 0; i < stage.rigid.count(); ++i) {
        const RigidGroup& group = groups.of_part(stage.rigid.part(i));
        RigidMotion& motion = stage.rigid.motion[i];
        const bool smooth = group.rigid && group.lost() <= much_left * impact_[i];
        if (which == Which::struck && smooth) continue;
        if (motion.less_v.isZero(0) && motion.less_momentum.isZero(0)) continue;
        motion.less_v = motion.less_momentum = Vec3::Zero();
        any = true;
    }
    return any;
}

void keep_rigid_energy(const Stage& stage, const Aligned<double>& x0, const Aligned<double>& v0,
                       const Aligned<double>& x, Aligned<double>& v)
{
    const StepFrame& frame = stage.frame;
    const CornerBody& body = frame.body;
    if (stage.rigid.none()) return;
    if (frame.loads.pins.matter.cubes.empty() && frame.loads.joints.empty()) return;
    RigidGroups groups(stage);
    if (std::none_of(groups.all.begin(), groups.all.end(), RigidGroups::kept)) return;
    find_energies(stage, x0, v0, x, v, groups);
    std::vector<double> factor(groups.all.size(), 1);
    for (std::size_t g = 0; g < factor.size(); ++g) {
        const RigidGroup& group = groups.all[g];
        const double moving = group.moving();
        if (group.is_hit() || !(moving > 0)) continue;
        factor[g] = std::sqrt(std::max(0.0, 1 + group.lost() / moving));
    }
    for (std::size_t k = 0; k < body.corners; ++k) {
        if (!groups.keeps(body.part_of(k))) continue;
        const RigidGroup& group = groups.of_part(body.part_of(k));
        const RigidPart& one = group.as_one;
        const Vec3 rest = one.velocity + one.spin.cross(of_slot(x, k) - one.centre);
        const double by = factor[std::size_t(&group - groups.all.data())];
        const Vec3 now = rest + by * (of_slot(v, k) - rest);
        for (std::size_t i = 0; i < 3; ++i) v[4 * k + i] = now[static_cast<Eigen::Index>(i)];
    }
}

}  // namespace physics

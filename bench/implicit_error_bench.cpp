// Writes docs/implicit-error.md: how far contact, volume and surface of implicit layers are from
// the exact ones against the number of samples, and what each costs.
//   implicit_error_bench [docs/implicit-error.md]

#include "geometry/base/random.hpp"
#include "geometry/mesh/mesh.hpp"
#include "physics/layers/deformed_layer.hpp"
#include "physics/layers/layer_contact.hpp"
#include "physics/layers/layer_contact_border.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>
#include <iostream>
#include <list>
#include <numbers>

namespace {

using namespace physics;
using geometry::Contribution;
using geometry::SkeletonKind;

constexpr double pi = std::numbers::pi;

double milliseconds(const auto& work)
{
    std::vector<double> times;
    for (int i = 0; i < 7; ++i) {
        const auto begin = std::chrono::steady_clock::now();
        work();
        times.push_back(
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin)
                .count());
    }
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

// A body of point skeletons in one frame, with all that a ContactBody names.
struct Balls {
    ImplicitLayer layer;
    std::vector<Transform> frames;
    std::vector<Twist> twists{1};
    Field field;
    SurfaceSamples samples;
    SampleWalk walk;
    LayerMatter matter{.stiffness = 1, .friction = 0, .bulge_width = 0.3, .bulge_height = 0.5};

    Balls(const std::vector<Vec3>& points, const Contribution& c, double spacing,
          const Transform& at = Transform::Identity())
        : frames{at}
    {
        for (const Vec3& p : points) {
            layer.skeletons.push_back({.kind = SkeletonKind::point, .points = {p}});
            layer.contributions.push_back(c);
            layer.frame.push_back(0);
        }
        field = geometry::make_field(layer, frames);
        samples = make_surface_samples(layer, spacing);
        walk = physics::walk(field, samples, frames);
    }
    ContactBody body() const
    {
        return {&field, &samples, &walk, frames, twists, layer.frame, matter};
    }
};

// The accuracy page's contact: k = 1, r0 = 1, half distance 0.9.
constexpr double h = 0.9;
const Contribution unit{.thickness = 1, .stiffness = 1, .radius = 2, .stiffening = 0};

std::list<Balls> pressed(double spacing)
{
    std::list<Balls> balls;
    for (const double side : {-1.0, 1.0}) {
        // Turned, so that no row of samples lies in the border by symmetry.
        Transform at = Transform::Identity();
        at.translate(Vec3(h * side, 0, 0))
            .rotate(Eigen::AngleAxisd(0.5 + 0.2 * side, Vec3(side, 2, 2).normalized()));
        balls.emplace_back(std::vector<Vec3>{Vec3::Zero()}, unit, spacing, at);
    }
    return balls;
}

std::vector<ContactBody> bodies(const std::list<Balls>& balls)
{
    std::vector<ContactBody> all;
    for (const Balls& b : balls) all.push_back(b.body());
    return all;
}

std::string order(double before, double now, double ratio)
{
    if (!(before > 0) || !(now > 1e-13)) return "";
    return fmt::format("{:.1f}", std::log(before / now) / std::log(ratio));
}

void contact_table(std::ostream& out)
{
    const double a_sq = 1 - h * h;
    const double radius = std::sqrt(a_sq), force = 2 * pi * (a_sq / 2 - (1 - h * h * h) / 3);
    out << "## Contact of two equal balls\n\n"
        << fmt::format(
               "Linear, k = 1, rest radius 1, half distance 0.9: radius {:.7f}, force {:.9f}. "
               "Seeds are those of both balls. `border` computes the radius from the curve of the "
               "contact's border, `cells` from the areas of the seeds in contact.\n\n",
               radius, force)
        << "| seeds | force error | order | radius error, border | order | radius error, cells | "
           "walk ms | contact ms | border ms |\n|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    double last_force = 0, last_radius = 0;
    for (double spacing = 0.32; spacing > 0.009; spacing /= 2) {
        std::list<Balls> balls = pressed(spacing);
        const std::vector<ContactBody> both = bodies(balls);
        const Contacts found = find_contacts(both);
        const LayerContactBorder border = find_border(both, found);
        double cells = 0, worst = 0;
        for (const LayerContact& c : found.contacts) cells += c.body == 0 ? c.area : 0;
        for (const ContactPatch& patch : border.patches) {
            worst = std::max(worst, std::abs(std::sqrt(patch.area / pi) - radius));
        }
        const double force_error = std::abs(-found.wrenches[0][0].force.x() - force);
        const double walk_ms = milliseconds([&] {
            for (Balls& b : balls) b.walk = physics::walk(b.field, b.samples, b.frames, &b.walk);
        });
        const double contact_ms = milliseconds([&] { find_contacts(both); });
        const double border_ms = milliseconds([&] { find_border(both, found); });
        out << fmt::format(
            "| {} | {:.2e} | {} | {:.2e} | {} | {:.2e} | {:.2f} | {:.2f} | {:.2f} |\n",
            2 * balls.front().samples.count(), force_error, order(last_force, force_error, 2),
            worst, order(last_radius, worst, 2), std::abs(std::sqrt(cells / pi) - radius), walk_ms,
            contact_ms, border_ms);
        last_force = force_error;
        last_radius = worst;
    }
    out << '\n';
}

void invariants(std::ostream& out)
{
    std::list<Balls> balls = pressed(0.02);
    balls.front().twists[0] = {{1, 2, 3}, {0.3, -0.2, 0.5}};
    balls.front().matter.friction = 2;
    const std::vector<ContactBody> both = bodies(balls);
    const Contacts found = find_contacts(both);
    double apart = 0;
    for (const LayerContact& contact : found.contacts) {
        for (std::uint32_t b = 0; b < 2; ++b) {
            apart = std::max(apart,
                             std::abs(value_at(deformed(both, b, found), contact.position).f - 1));
        }
    }
    const Wrench& a = found.wrenches[0][0];
    const Wrench& b = found.wrenches[1][0];
    out << "At 0.02 m between seeds, with friction and spin: both deformed surfaces pass through "
        << fmt::format(
               "every contact point to {:.1e} (|D - c|, over {} points); force and its reaction "
               "cancel to {:.1e} of the force, surfaces penetrate each other by {:.1e} m.\n\n",
               apart, found.contacts.size(), (a.force + b.force).norm() / a.force.norm(),
               std::max(found.penetration[0], found.penetration[1]));

    const DeformedLayer left = deformed(both, 0, found);
    const auto normal_near = [&](double rho) {
        double inside = -0.5, outside = 0.3;
        while (outside - inside > 1e-13) {
            const double x = 0.5 * (inside + outside);
            (value_at(left, {x, rho, 0}).f > 1 ? inside : outside) = x;
        }
        return Vec3(-value_at(left, {inside, rho, 0}).gradient.normalized());
    };
    out << "Angle between the normals a step inside and a step outside the contact's border (C1: "
           "it "
           "vanishes with the step; without the bulge it would stay at 0.45 rad):\n\n| step, m | "
           "angle, rad |\n|--:|--:|\n";
    const double rim = std::sqrt(1 - h * h);
    for (const double step : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        const Vec3 n = normal_near(rim - step), m = normal_near(rim + step);
        out << fmt::format("| {:.0e} | {:.2e} |\n", step, std::atan2(n.cross(m).norm(), n.dot(m)));
    }
    out << '\n';
}

void volume_table(std::ostream& out)
{
    out << "## Volume and surface\n\nErrors of the volume of a ball (against 4/3 pi r^3) and of "
           "two blended balls (against the finest row), and the largest distance of the preview "
           "mesh's faces from the surface, at their centres (m; balls of radius 0.5, 0.8 "
           "apart).\n\n| seeds | ball, volume error | two balls, volume error | order | surface "
           "distance | order | walk ms | preview mesh ms |\n|--:|--:|--:|--:|--:|--:|--:|--:|\n";
    const Contribution soft{.thickness = 0.5, .stiffness = 2, .radius = 1.2, .stiffening = 0.3};
    Transform turn = Transform::Identity();
    turn.rotate(Eigen::AngleAxisd(0.3, Vec3(1, 2, 3).normalized()));
    const std::vector<Vec3> two{{-0.4, 0, 0}, {0.4, 0, 0}};
    const double reference = Balls(two, soft, 0.0035, turn).walk.volume();
    double last = 0, last_distance = 0;
    for (double spacing = 0.16; spacing > 0.009; spacing /= 2) {
        const double exact = 4 * pi / 3 * 0.125;
        const double ball = Balls({Vec3::Zero()}, soft, spacing).walk.volume();
        Balls blend(two, soft, spacing, turn);
        const double error = std::abs(blend.walk.volume() / reference - 1);
        const geometry::TriMesh mesh = preview_mesh(blend.samples, blend.walk);
        double distance = 0;
        for (const geometry::Triangle& t : mesh.triangles()) {
            if (!(blend.walk.valid[t[0]] && blend.walk.valid[t[1]] && blend.walk.valid[t[2]])) {
                continue;
            }
            const Vec3 p = (blend.walk.position[t[0]] + blend.walk.position[t[1]] +
                            blend.walk.position[t[2]]) /
                           3;
            const geometry::FieldValue at = geometry::value_at(blend.field, p);
            distance = std::max(distance, std::abs(at.f - 1) / at.gradient.norm());
        }
        const double walk_ms = milliseconds([&] {
            blend.walk = physics::walk(blend.field, blend.samples, blend.frames, &blend.walk);
        });
        const double mesh_ms = milliseconds([&] { preview_mesh(blend.samples, blend.walk); });
        out << fmt::format("| {} | {:.1e} | {:.2e} | {} | {:.2e} | {} | {:.2f} | {:.2f} |\n",
                           blend.samples.count(), std::abs(ball / exact - 1), error,
                           order(last, error, 2), distance, order(last_distance, distance, 2),
                           walk_ms, mesh_ms);
        last = error;
        last_distance = distance;
    }
    out << '\n';
}

// While two parts fuse, the surface is found on rays from one skeleton; its largest change of place
// and of normal from one weight to the next, and the largest jump of the gradient in space.
void fusion_table(std::ostream& out)
{
    out << "## Fusion\n\nTwo balls of 0.1 m, 0.18 m apart, fuse while the weight of their link "
           "goes from 0 to 1 in equal steps. The columns are the largest change per step of the "
           "position of the surface (as a share of the thickness) and of its normal, on 2,000 "
           "rays, and the largest relative jump of the gradient over 2e-8 m across the middle. "
           "(With the largest group of the paper, the gradient jumps there by 1.8.)\n\n| steps | "
           "surface, of e | normal, rad | gradient jump |\n|--:|--:|--:|--:|\n";
    ImplicitLayer layer;
    layer.skeletons = {{.kind = SkeletonKind::point, .points = {{-0.09, 0, 0}}},
                       {.kind = SkeletonKind::point, .points = {{0.09, 0, 0}}}};
    layer.contributions.assign(2, {.thickness = 0.1, .stiffness = 10, .radius = 0.22});
    layer.frame = {0, 1};
    layer.blend.rule = geometry::BlendRule::smooth_groups;
    const std::vector<Transform> at(2, Transform::Identity());
    const geometry::Random random(3);
    std::vector<Vec3> rays;
    for (std::uint64_t i = 0; i < 2000; ++i) {
        const double z = 2 * random.unit(2 * i) - 1, angle = 2 * pi * random.unit(2 * i + 1);
        const double r = std::sqrt(1 - z * z);
        rays.push_back({-std::abs(r * std::cos(angle)), r * std::sin(angle), z});
    }
    for (const int steps : {50, 200, 800}) {
        std::vector<double> place(rays.size(), -1);
        std::vector<Vec3> normal(rays.size());
        double moved = 0, turned = 0, jump = 0;
        for (int i = 1; i <= steps; ++i) {
            layer.blend.links = {{0, 1, static_cast<double>(i) / steps}};
            const Field field = geometry::make_field(layer, at);
            for (std::size_t k = 0; k < rays.size(); ++k) {
                double inside = 0, outside = 0.4;
                const Vec3 from(-0.09, 0, 0);
                while (outside - inside > 1e-12) {
                    const double t = 0.5 * (inside + outside);
                    (geometry::value_at(field, from + t * rays[k]).f > 1 ? inside : outside) = t;
                }
                const Vec3 n =
                    -geometry::value_at(field, from + inside * rays[k]).gradient.normalized();
                if (i > 1) {
                    moved = std::max(moved, std::abs(inside - place[k]) / 0.1);
                    turned =
                        std::max(turned, std::atan2(n.cross(normal[k]).norm(), n.dot(normal[k])));
                }
                place[k] = inside;
                normal[k] = n;
            }
            if (i * 50 < steps) continue;
            for (double y = 0; y < 0.12; y += 0.005) {
                const Vec3 a = geometry::value_at(field, {-1e-8, y, 0}).gradient;
                const Vec3 b = geometry::value_at(field, {1e-8, y, 0}).gradient;
                jump = std::max(jump, (a - b).norm() / 10);
            }
        }
        out << fmt::format("| {} | {:.2e} | {:.2e} | {:.1e} |\n", steps, moved, turned, jump);
    }
    out << '\n';
}

}  // namespace

int main(int argc, char** argv)
{
    std::ofstream file;
    if (argc > 1) file.open(argv[1]);
    std::ostream& out = argc > 1 ? file : std::cout;
    out << "# Implicit layers: error against seeds and time\n\nWritten by `implicit_error_bench "
           "docs/implicit-error.md`; medians of 7 runs on one machine. Seeds are the samples of a "
           "surface. The formulas are in physics/layers/layer_contact.hpp, "
           "layer_contact_border.hpp and surface_samples.hpp.\n\n";
    contact_table(out);
    invariants(out);
    volume_table(out);
    fusion_table(out);
    return out.good() ? 0 : 1;
}

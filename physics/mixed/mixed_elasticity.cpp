#include "physics/mixed/mixed_elasticity.hpp"

#include "physics/body/point_contact.hpp"
#include "physics/bricks/dissection.hpp"
#include "physics/bricks/factor_cache.hpp"

#include <algorithm>

namespace physics {

MixedElasticity::MixedElasticity(const MixedBody& body, Elasticity& bricks, Elasticity& shell)
    : body_(body), bricks_(bricks), shell_(shell), first_(body.bricks.base.corners),
      corner_of_slot_(body.base.corners)
{
    for (std::uint32_t k = 0; k < body.base.corners; ++k) {
        corner_of_slot_[body.base.slot_of(k)] = k;
    }
    const auto make_room = [&](auto& own) {
        const std::size_t solids = std::max(bricks.room(), body.bricks.base.numbers);
        const std::size_t sheets = std::max(shell.room(), body.shell.base.numbers);
        own.solids.assign(solids, 0), own.solids_out.assign(solids, 0);
        own.sheets.assign(sheets, 0), own.sheets_out.assign(sheets, 0);
    };
    make_room(high_), make_room(low_);
}

template <class T> void MixedElasticity::take(const T* from, Own<T>& own) const
{
    const T* const sheets = from + 4 * first_;
    std::copy(from, sheets, own.solids.begin());
    std::copy_n(sheets, 4 * body_.shell.base.corners, own.sheets.begin());
}

template <class T> void MixedElasticity::give(const Own<T>& own, T* to) const
{
    T* const sheets = to + 4 * first_;
    std::copy_n(own.solids_out.begin(), 4 * first_, to);
    std::copy_n(own.sheets_out.begin(), 4 * body_.shell.base.corners, sheets);
}

void MixedElasticity::forces(const double* x, double* f)
{
    take(x, high_);
    bricks_.forces(high_.solids.data(), high_.solids_out.data());
    shell_.forces(high_.sheets.data(), high_.sheets_out.data());
    give(high_, f);
}

double MixedElasticity::energy(const double* x)
{
    take(x, high_);
    return bricks_.energy(high_.solids.data()) + shell_.energy(high_.sheets.data());
}

double MixedElasticity::largest_rate(const double* w) const
{
    take(w, high_);
    return std::max(bricks_.largest_rate(high_.solids.data()),
                    shell_.largest_rate(high_.sheets.data()));
}

void MixedElasticity::weigh(double stiffness, double damping)
{
    bricks_.weigh(stiffness, damping);
    shell_.weigh(stiffness, damping);
}

bool MixedElasticity::use_hessian(bool on)
{
    const bool bricks = bricks_.use_hessian(on);
    return shell_.use_hessian(on) || bricks;
}

template <class T> void MixedElasticity::multiply_any(Own<T>& own, const T* p, T* y) const
{
    take(p, own);
    bricks_.multiply(own.solids.data(), own.solids_out.data());
    shell_.multiply(own.sheets.data(), own.sheets_out.data());
    give(own, y);
}

void MixedElasticity::multiply(const float* p, float* y) const
{
    multiply_any(low_, p, y);
}

void MixedElasticity::multiply(const double* p, double* y) const
{
    multiply_any(high_, p, y);
}

double MixedElasticity::product_work() const
{
    const double bricks = bricks_.product_work() * static_cast<double>(bricks_.cube_count());
    const double shell = shell_.product_work() * static_cast<double>(shell_.cube_count());
    return (bricks + shell) / static_cast<double>(cube_count());
}

void MixedElasticity::add_diagonal(double* d) const
{
    take(d, high_);
    bricks_.add_diagonal(high_.solids.data());
    shell_.add_diagonal(high_.sheets.data());
    std::copy_n(high_.solids.begin(), 4 * first_, d);
    std::copy_n(high_.sheets.begin(), 4 * body_.shell.base.corners, d + 4 * first_);
}

bool MixedElasticity::excess(Lumped of, const double* v, double* y) const
{
    take(v, high_);
    if (!bricks_.excess(of, high_.solids.data(), high_.solids_out.data())) return false;
    std::fill(high_.sheets_out.begin(), high_.sheets_out.end(), 0);
    give(high_, y);
    return true;
}

bool MixedElasticity::cube_matrices(std::vector<BrickMatrix>& out) const
{
    std::vector<BrickMatrix> sheets;
    if (!bricks_.cube_matrices(out) || !shell_.cube_matrices(sheets)) return false;
    out.insert(out.end(), sheets.begin(), sheets.end());
    return true;
}

void MixedElasticity::add_contact(const PointContact& contact, const geometry::Mat3& block,
                                  std::span<BrickMatrix> to) const
{
    if (contact.count != 8) return;
    if (contact.corners[0] < first_) return bricks_.add_contact(contact, block, to);
    PointContact own = contact;
    for (std::size_t a = 0; a < 8; ++a) own.corners[a] -= static_cast<std::uint32_t>(first_);
    shell_.add_contact(own, block, to.subspan(bricks_.cube_count()));
}

// Elements of solids, of sheets, then `more`, by where corners are at x.
std::shared_ptr<const Dissection> MixedElasticity::dissected(const std::vector<std::uint32_t>& held,
                                                             const ElementCorners& more,
                                                             const double* x) const
{
    // Solves with more than these take longer than any other way.
    constexpr double most_entries_a_corner = 1500;
    constexpr std::size_t uncut = 16;
    const std::size_t corners = body_.base.corners;
    take(x, high_);
    const ElementsOfMethod solids = bricks_.elements(high_.solids.data());
    const ElementsOfMethod sheets = shell_.elements(high_.sheets.data());
    ElementCorners elements;
    for (auto of : solids.corners) {
        for (auto& k : of) k = body_.solid_corner[k];
        elements.push_back(of);
    }
    const std::size_t own = body_.sheet_corner.size();
    for (auto of : sheets.corners) {
        for (auto& k : of) {
            k = k < own ? body_.sheet_corner[k] : static_cast<std::uint32_t>(corners + (k - own));
        }
        elements.push_back(of);
    }
    for (auto of : more) {
        for (auto& k : of) k = corner_of_slot_[k];
        elements.push_back(of);
    }
    std::vector<geometry::Vec3> places(corners);
    for (std::uint32_t k = 0; k < corners; ++k) {
        places[k] = Eigen::Map<const geometry::Vec3>(x + 4 * body_.base.slot_of(k));
    }
    places.insert(places.end(), sheets.inner.begin(), sheets.inner.end());
    std::vector<char> left_out(places.size(), 0);
    for (const auto k : held) left_out[k] = 1;
    Dissection tree = dissect(elements, places, left_out,
                              most_entries_a_corner * static_cast<double>(places.size()), uncut);
    if (tree.fronts.empty()) return nullptr;
    return std::make_shared<const Dissection>(std::move(tree));
}

std::shared_ptr<const Dissection>
MixedElasticity::dissection(const std::vector<std::uint32_t>& held) const
{
    return body_.dissections->find({0, 0, {}, {held, {}}}, [&]() -> DissectionCache::Factor {
        return dissected(held, {}, body_.base.rest.data());
    });
}

std::shared_ptr<const Dissection>
MixedElasticity::dissection_with(const std::vector<std::uint32_t>& held, const ElementCorners& more,
                                 const double* x) const
{
    return dissected(held, more, x);
}

double MixedElasticity::flow(const double* x, double dt, Flow how)
{
    take(x, high_);
    return bricks_.flow(high_.solids.data(), dt, how);
}

}  // namespace physics

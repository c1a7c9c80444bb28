#include "geometry/fields/field_blend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace geometry {

BlendWeights::BlendWeights(const Blend& blend, std::size_t skeletons)
{
    if (!blend.part.empty() && blend.part.size() != skeletons) {
        throw std::invalid_argument(
            fmt::format("a blend of {} skeletons needs as many part numbers, or none; got {}",
                        skeletons, blend.part.size()));
    }
    part_ = blend.part;
    for (std::uint32_t i = 0; part_.size() < skeletons; ++i) part_.push_back(i);
    if (blend.links.empty()) return;

    struct Entry {
        std::uint32_t from, to;
        double weight;
    };
    std::vector<Entry> entries;
    for (const BlendLink& link : blend.links) {
        if (link.a >= skeletons || link.b >= skeletons) {
            throw std::invalid_argument(fmt::format(
                "a blend link joins skeletons {} and {}, but there are only {} skeletons", link.a,
                link.b, skeletons));
        }
        if (part_[link.a] == part_[link.b]) {
            throw std::invalid_argument(fmt::format(
                "a blend link joins skeletons {} and {} of the same part; they blend anyway",
                link.a, link.b));
        }
        if (!(link.weight >= 0 && link.weight <= 1)) {
            throw std::invalid_argument(
                fmt::format("the blend link of skeletons {} and {} needs a weight in 0..1, got {}",
                            link.a, link.b, link.weight));
        }
        entries.push_back({link.a, link.b, link.weight});
        entries.push_back({link.b, link.a, link.weight});
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
        return std::pair(a.from, a.to) < std::pair(b.from, b.to);
    });
    first_.assign(skeletons + 1, 0);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const Entry& e = entries[i];
        if (i > 0 && e.from == entries[i - 1].from && e.to == entries[i - 1].to) {
            throw std::invalid_argument(fmt::format(
                "skeletons {} and {} have two blend links; expected one", e.from, e.to));
        }
        ++first_[e.from + 1];
        to_.push_back(e.to);
        weight_.push_back(e.weight);
    }
    for (std::size_t i = 0; i < skeletons; ++i) first_[i + 1] += first_[i];
}

double BlendWeights::operator()(std::uint32_t i, std::uint32_t j) const
{
    if (part_[i] == part_[j]) return 1;
    if (first_.empty()) return 0;
    const auto begin = to_.begin() + first_[i], end = to_.begin() + first_[i + 1];
    const auto found = std::lower_bound(begin, end, j);
    return found != end && *found == j ? weight_[static_cast<std::size_t>(found - to_.begin())] : 0;
}

namespace {

Blended total(std::span<Contributor> contributors)
{
    Blended sum;
    for (Contributor& c : contributors) {
        c.share = 1;
        sum.f += c.f;
        sum.gradient += c.gradient;
    }
    return sum;
}

// The heaviest clique, by branch and bound: contributors come in order of falling f, a branch is
// cut when even all that is left could not beat the best.
struct CliqueSearch {
    const BlendWeights& weights;
    std::span<const Contributor> contributors;
    std::vector<std::uint32_t> chosen, best;
    double best_sum = -1;

    void extend(std::span<const std::uint32_t> candidates, double sum)
    {
        double left = 0;
        for (const std::uint32_t i : candidates) left += contributors[i].f;
        if (sum + left <= best_sum) return;
        if (candidates.empty()) {
            best = chosen;
            best_sum = sum;
            return;
        }
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            const Contributor& c = contributors[candidates[i]];
            std::vector<std::uint32_t> next;
            for (const std::uint32_t j : candidates.subspan(i + 1)) {
                if (weights(c.skeleton, contributors[j].skeleton) > 0) next.push_back(j);
            }
            chosen.push_back(candidates[i]);
            extend(next, sum + c.f);
            chosen.pop_back();
            left -= c.f;
            if (sum + left <= best_sum) return;
        }
    }
};

Blended largest_group(const BlendWeights& weights, std::span<Contributor> contributors)
{
    std::sort(contributors.begin(), contributors.end(),
              [](const Contributor& a, const Contributor& b) {
                  return a.f > b.f || (a.f == b.f && a.skeleton < b.skeleton);
              });
    CliqueSearch search{weights, contributors, {}, {}};
    std::vector<std::uint32_t> all(contributors.size());
    for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = i;
    search.extend(all, 0);
    Blended result;
    for (Contributor& c : contributors) c.share = 0;
    for (const std::uint32_t i : search.best) {
        contributors[i].share = 1;
        result.f += contributors[i].f;
        result.gradient += contributors[i].gradient;
    }
    return result;
}

// f = M S^beta, S = sum x_A, x_A = (F_A / M)^(1/beta), M = max F_A.
//   df/dF_A = f x_A / (S F_A)
//   df/dbeta = f (ln S - (1/beta) sum x_A ln(F_A / M) / S)
//   dbeta/df_i = (sum_j w_ij f_j - beta sum_j f_j) / B,  j over other parts, B = sum f_i f_j
// and for weights that vary in space, grad beta gains sum grad(w_ij) f_i f_j / B.

// The sums over pairs of contributors of different parts that beta is made of.
struct PairSums {
    double blended = 0, all = 0;          // sum w_ij f_i f_j, B
    Vec3 turn = Vec3::Zero();             // sum grad(w_ij) f_i f_j
    struct Row {                          // one a contributor i: sums over j
        double weighted = 0, others = 0;  // w_ij f_j, f_j
    };
    std::vector<Row> rows;

    double beta() const { return blended / all; }
};

// `part(i)`: of contributor i. Reuses the memory of `sums`.
void sum_pairs(const BlendWeights& weights, std::span<const Contributor> contributors,
               bool by_gradient, const auto& part, PairSums& sums)
{
    const std::size_t n = contributors.size();
    sums.blended = sums.all = 0;
    sums.turn.setZero();
    sums.rows.assign(n, {});
    for (std::size_t i = 0; i < n; ++i) {
        const Contributor& a = contributors[i];
        for (std::size_t j = i + 1; j < n; ++j) {
            const Contributor& b = contributors[j];
            if (part(i) == part(j)) continue;
            double w = weights(a.skeleton, b.skeleton);
            if (by_gradient) {
                const double cosine = a.n.dot(b.n);
                sums.turn -= w * 2 * cosine * a.f * b.f * (a.turn * b.n + b.turn * a.n);
                w *= std::max(0.0, 1 - cosine * cosine);
            }
            sums.blended += w * a.f * b.f;
            sums.all += a.f * b.f;
            sums.rows[i].weighted += w * b.f;
            sums.rows[i].others += b.f;
            sums.rows[j].weighted += w * a.f;
            sums.rows[j].others += a.f;
        }
    }
}

// A part: its sum F_A, x_A, and where its contributors end.
struct PartSum {
    double F = 0, x = 0;
    std::size_t end = 0;
};

// The parts of contributors that come part by part. Returns which is the largest.
std::size_t sum_parts(std::span<const Contributor> contributors, const auto& part,
                      std::vector<PartSum>& parts)
{
    parts.clear();
    for (std::size_t i = 0; i < contributors.size(); ++i) {
        if (i == 0 || part(i) != part(i - 1)) parts.emplace_back();
        parts.back().F += contributors[i].f;
        parts.back().end = i + 1;
    }
    std::size_t largest = 0;
    for (std::size_t a = 1; a < parts.size(); ++a) {
        if (parts[a].F > parts[largest].F) largest = a;
    }
    return largest;
}

Blended smooth_groups(BlendRule rule, const BlendWeights& weights,
                      std::span<Contributor> contributors)
{
    const bool by_gradient = rule == BlendRule::gradient;
    const std::size_t n = contributors.size();
    const auto part = [&](std::size_t i) {
        return by_gradient ? contributors[i].skeleton : weights.part(contributors[i].skeleton);
    };
    std::sort(contributors.begin(), contributors.end(),
              [&](const Contributor& a, const Contributor& b) {
                  const auto pa = weights.part(a.skeleton), pb = weights.part(b.skeleton);
                  return pa < pb || (pa == pb && a.skeleton < b.skeleton);
              });
    if (part(0) == part(n - 1)) return total(contributors);

    thread_local PairSums pairs;
    sum_pairs(weights, contributors, by_gradient, part, pairs);
    const double beta = pairs.beta();
    thread_local std::vector<PartSum> parts;
    const std::size_t largest = sum_parts(contributors, part, parts);
    if (!(beta > 1e-9)) {  // a crease: p beyond 1e9 is the largest to the last digits
        const std::size_t begin = largest == 0 ? 0 : parts[largest - 1].end;
        for (Contributor& c : contributors) c.share = 0;
        return total(contributors.subspan(begin, parts[largest].end - begin));
    }

    const double M = parts[largest].F;
    double S = 0, entropy = 0;
    for (PartSum& a : parts) {
        const double log_ratio = std::log(a.F / M);
        a.x = std::exp(log_ratio / beta);
        S += a.x;
        if (a.x > 0) entropy -= a.x * log_ratio;
    }
    Blended result;
    result.f = M * std::pow(S, beta);
    const double df_dbeta = result.f * (std::log(S) + entropy / (beta * S));
    for (std::size_t i = 0, a = 0; i < n; ++i) {
        if (i == parts[a].end) ++a;
        const double df_dF = result.f * parts[a].x / (S * parts[a].F);
        const double dbeta = (pairs.rows[i].weighted - beta * pairs.rows[i].others) / pairs.all;
        contributors[i].share = df_dF + df_dbeta * dbeta;
        result.gradient += contributors[i].share * contributors[i].gradient;
    }
    if (by_gradient) result.gradient += df_dbeta / pairs.all * pairs.turn;
    return result;
}

}  // namespace

Blended blend(BlendRule rule, const BlendWeights& weights, std::span<Contributor> contributors)
{
    if (contributors.empty()) return {};
    if (contributors.size() == 1) return total(contributors);
    switch (rule) {
    case BlendRule::sum:
        return total(contributors);
    case BlendRule::largest_group:
        return largest_group(weights, contributors);
    case BlendRule::smooth_groups:
    case BlendRule::gradient:
        return smooth_groups(rule, weights, contributors);
    }
    return {};
}

}  // namespace geometry

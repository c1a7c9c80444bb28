#include "physics/regions/lattice_runs.hpp"

#include <algorithm>

namespace physics {

Runs::Runs(const Lattice& lattice)
{
    const std::size_t n = lattice.count();
    of_.assign(n, none);
    std::vector<std::uint8_t> has_before(n, 0);
    for (const auto& next : lattice.next) {
        if (next[0] != none) has_before[next[0]] = 1;
    }
    for (std::uint32_t i = 0; i < n; ++i) {
        if (has_before[i]) continue;
        const Vec3i& p = lattice.at[i];
        const auto first = std::uint32_t(particle_.size());
        for (std::uint32_t j = i; j != none; j = lattice.next[j][0]) {
            of_[j] = std::uint32_t(run_.size());
            particle_.push_back(j);
        }
        run_.push_back({first, std::uint32_t(particle_.size()) - first, p[0], p[1], p[2]});
    }
    std::vector<std::vector<Seam>> seams(run_.size());
    for (std::uint32_t r = 0; r < run_.size(); ++r) {
        const Run& run = run_[r];
        for (std::size_t d = 1; d < 3; ++d) {
            for (std::uint32_t k = 0; k < run.length; ++k) {
                const std::uint32_t j = lattice.next[particle_[run.first + k]][d];
                if (j == none) continue;
                const int x = run.x + int(k);
                const std::uint32_t other = of_[j];
                auto& mine = seams[r];
                if (!mine.empty() && mine.back().run == other && mine.back().high == x - 1) {
                    ++mine.back().high;
                    ++seams[other].back().high;
                } else {
                    mine.push_back({other, x, x});
                    seams[other].push_back({r, x, x});
                }
            }
        }
    }
    seams_.resize(run_.size());
    for (std::uint32_t r = 0; r < run_.size(); ++r) set_seams(r, seams[r]);
}

void Runs::cut(std::uint32_t i, std::uint32_t j, int axis, int x)
{
    if (axis == 0) {
        part_run(of_[i], x);
    } else {
        part_seam(of_[i], of_[j], x);
        part_seam(of_[j], of_[i], x);
    }
}

// In the room that the run's seams have, or at the end.
void Runs::set_seams(std::uint32_t r, const std::vector<Seam>& seams)
{
    if (seams.size() > seams_[r].count) {
        seams_[r].begin = seam_.size();
        seam_.resize(seam_.size() + seams.size());
    }
    seams_[r].count = seams.size();
    std::copy(seams.begin(), seams.end(), seam_.begin() + std::ptrdiff_t(seams_[r].begin));
}

// Takes x out of the seam from run r to the other.
void Runs::part_seam(std::uint32_t r, std::uint32_t other, int x)
{
    std::vector<Seam> left;
    for (const Seam& seam : seams(r)) {
        if (seam.run != other || x < seam.low || x > seam.high) {
            left.push_back(seam);
            continue;
        }
        if (seam.low < x) left.push_back({other, seam.low, x - 1});
        if (seam.high > x) left.push_back({other, x + 1, seam.high});
    }
    set_seams(r, left);
}

// What of run r lies beyond x is a run of its own.
void Runs::part_run(std::uint32_t r, int x)
{
    const auto fresh = std::uint32_t(run_.size());
    const std::uint32_t kept = std::uint32_t(x - run_[r].x) + 1;
    run_.push_back({run_[r].first + kept, run_[r].length - kept, x + 1, run_[r].y, run_[r].z});
    run_[r].length = kept;
    for (std::uint32_t k = 0; k < run_[fresh].length; ++k) {
        of_[particle_[run_[fresh].first + k]] = fresh;
    }
    seams_.emplace_back();
    std::vector<Seam> before, beyond, theirs;
    for (const Seam& seam : seams(r)) {
        if (seam.low <= x) before.push_back({seam.run, seam.low, std::min(seam.high, x)});
        if (seam.high > x) beyond.push_back({seam.run, std::max(seam.low, x + 1), seam.high});
    }
    for (const Seam& seam : beyond) {
        theirs.clear();
        for (const Seam& back : seams(seam.run)) {
            if (back.run != r || back.high <= x) {
                theirs.push_back(back);
                continue;
            }
            if (back.low <= x) theirs.push_back({r, back.low, x});
            theirs.push_back({fresh, std::max(back.low, x + 1), back.high});
        }
        set_seams(seam.run, theirs);
    }
    set_seams(r, before);
    set_seams(fresh, beyond);
}

}  // namespace physics

#pragma once

// What links of a lattice reach inside a box, a run of particles at a time: an unbroken row along
// x. Where two runs are linked they have a seam, which lies in both.
//
//     run 1   o--o--o       o--o   run 2
//             |  |             |
//     run 0   o--o--o--o--o--o--o           seams of run 0: to run 1 at x = 0 .. 1, to run 2 at 6
//             0  1  2  3  4  5  6   x

#include "physics/regions/links.hpp"

#include <algorithm>
#include <cstdlib>
#include <span>
#include <tuple>
#include <vector>

namespace physics {

// Unbroken runs of particles along x, and where neighbouring runs are linked.
class Runs {
public:
    struct Run {
        std::uint32_t first, length;  // into particles()
        int x, y, z;                  // of its first particle
    };
    struct Seam {
        std::uint32_t run;
        int low, high;  // x, inclusive, of a stretch without a gap
    };

    explicit Runs(const Lattice& lattice);

    // Breaks the link of particle i, at x, to j, next along `axis`: runs that part keep their
    // places in particles().
    void cut(std::uint32_t i, std::uint32_t j, int axis, int x);

    std::size_t count() const { return run_.size(); }
    const Run& operator[](std::uint32_t r) const { return run_[r]; }
    std::span<const std::uint32_t> particles() const { return particle_; }
    std::uint32_t of(std::uint32_t particle) const { return of_[particle]; }
    std::span<const Seam> seams(std::uint32_t r) const
    {
        return {seam_.data() + seams_[r].begin, seams_[r].count};
    }

private:
    struct Some {
        std::size_t begin = 0, count = 0;
    };

    void set_seams(std::uint32_t r, const std::vector<Seam>& seams);
    void part_seam(std::uint32_t r, std::uint32_t other, int x);
    void part_run(std::uint32_t r, int x);

    std::vector<Run> run_;
    std::vector<std::uint32_t> particle_;
    std::vector<std::uint32_t> of_;  // N, the run that holds a particle
    std::vector<Some> seams_;        // of each run, into seam_
    std::vector<Seam> seam_;
};

// What is reached inside the box of half width w around one particle.
class Reach {
public:
    // Of a run, into Runs::particles().
    struct Piece {
        std::uint32_t first, length;
        int z;
        std::uint32_t run;

        // By z, then by place.
        bool operator<(const Piece& o) const { return std::tie(z, first) < std::tie(o.z, o.first); }
    };

    Reach(const Runs& runs, int w) : runs_(runs), w_(w), seen_(runs.count(), none) {}

    // In no particular order; valid until the next call.
    std::span<const Piece> from(std::uint32_t particle, const Vec3i& at)
    {
        pieces_.clear();
        visit(runs_.of(particle), particle, at);
        for (std::size_t k = 0; k < pieces_.size(); ++k) {
            for (const auto& seam : runs_.seams(pieces_[k].run)) {
                if (seam.low <= at[0] + w_ && seam.high >= at[0] - w_) {
                    visit(seam.run, particle, at);
                }
            }
        }
        return pieces_;
    }

private:
    void visit(std::uint32_t r, std::uint32_t particle, const Vec3i& at)
    {
        const auto& run = runs_[r];
        if (seen_[r] == particle || std::abs(run.y - at[1]) > w_ || std::abs(run.z - at[2]) > w_) {
            return;
        }
        seen_[r] = particle;
        const int low = std::max(run.x, at[0] - w_);
        const int high = std::min(run.x + int(run.length) - 1, at[0] + w_);
        pieces_.push_back(
            {run.first + std::uint32_t(low - run.x), std::uint32_t(high - low + 1), run.z, r});
    }

    const Runs& runs_;
    int w_;
    std::vector<std::uint32_t> seen_;  // the particle that last saw a run
    std::vector<Piece> pieces_;
};

}  // namespace physics

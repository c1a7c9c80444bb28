#pragma once

// A page of error against time: for each case a table, and a plot by gnuplot.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

namespace bench {

struct Result {
    std::string kind;     // series of a plot
    std::string setting;  // what is written beside its point
    double error = 0;     // relative
    double ms = 0;        // what it cost, see the case
};

// Of processor time: all runs on one thread, and what else the machine does must not count.
inline double seconds()
{
    return double(std::clock()) / CLOCKS_PER_SEC;
}

inline std::string percent(double error)
{
    if (!std::isfinite(error)) return "does not swing";
    return fmt::format("{:+.{}f} %", 100 * error, std::abs(error) < 0.01 ? 2 : 1);
}

inline std::string milliseconds(double ms)
{
    return ms >= 100 ? fmt::format("{:.0f}", ms) : fmt::format("{:.3g}", ms);
}

// How fine the grid of a setting is, "n=2 w=1" by its cubes across or "h=0.05 w=1" by 1 / edge, and
// all else that it says.
inline std::pair<double, std::string> grid_of(const Result& r)
{
    const std::size_t end = std::min(r.setting.find_first_of(" ,"), r.setting.size());
    const std::string first = r.setting.substr(0, end);
    if (first.starts_with("n=")) return {std::stod(first.substr(2)), r.setting.substr(end)};
    if (first.starts_with("h=")) return {1 / std::stod(first.substr(2)), r.setting.substr(end)};
    return {0, r.setting};
}

// The error that a setting can be trusted with: an error may cross zero as the grid is refined, so
// the worst of this setting and of the finer grids of the same method, all else alike.
inline double held_error(const Result& r, const std::vector<Result>& results)
{
    double worst = std::abs(r.error);
    const auto [n, rest] = grid_of(r);
    for (const Result& other : results) {
        const auto [finer, same] = grid_of(other);
        if (other.kind == r.kind && same == rest && finer > n) {
            worst = std::max(worst, std::abs(other.error));
        }
    }
    return worst;
}

// Whether nothing else is both quicker and nearer.
inline bool is_best(const Result& r, const std::vector<Result>& results)
{
    return std::isfinite(r.error) &&
           std::none_of(results.begin(), results.end(), [&](const Result& other) {
               return other.ms < r.ms && held_error(other, results) < held_error(r, results);
           });
}

// What meets some errors soonest, as a sentence.
inline std::string soonest(const std::vector<Result>& results)
{
    std::string text;
    for (const double wanted : {0.01, 0.05, 0.2}) {
        const Result* found = nullptr;
        for (const Result& r : results) {
            if (!(held_error(r, results) <= wanted) || (found && found->ms <= r.ms)) continue;
            found = &r;
        }
        if (!text.empty()) text += "; ";
        text += fmt::format("within {:g} %: ", 100 * wanted);
        text += found ? fmt::format("**{}, {}** ({} ms)", found->kind, found->setting,
                                    milliseconds(found->ms))
                      : "none";
    }
    return "Fastest " + text + ".";
}

struct Page {
    std::filesystem::path folder;
    std::string text;

    // A table and a plot of it.
    void plot(const std::string& name, const std::string& title, const std::string& cost,
              const std::string& what, const std::vector<Result>& results)
    {
        std::vector<std::string> kinds;
        for (const Result& r : results) {
            if (std::find(kinds.begin(), kinds.end(), r.kind) == kinds.end()) {
                kinds.push_back(r.kind);
            }
        }
        text +=
            fmt::format("## {}\n\n{}\n\n{}\n\n![{}](images/{}.svg)\n\n| method | setting | error | "
                        "{} |\n|---|---|---:|---:|\n",
                        title, what, soonest(results), title, name, cost);
        std::ofstream csv(folder / (name + ".csv"));
        std::vector<std::string> drawn;  // gnuplot breaks down on kinds that have no point
        for (const std::string& kind : kinds) {
            const bool has_points =
                std::any_of(results.begin(), results.end(), [&](const Result& r) {
                    return r.kind == kind && std::isfinite(r.error);
                });
            if (has_points && !drawn.empty()) csv << "\n\n";  // a block a kind, as gnuplot counts
            if (has_points) drawn.push_back(kind);
            for (const Result& r : results) {
                if (r.kind != kind) continue;
                if (std::isfinite(r.error)) {
                    csv << fmt::format("\"{}\",{:.6g},{:.6g},{}\n", r.setting, r.ms,
                                       std::max(1e-5, std::abs(r.error)),
                                       is_best(r, results) ? "1" : "NaN");
                }
                const char* const mark = is_best(r, results) ? "**" : "";
                text += fmt::format("| {} | {}{}{} | {} | {} |\n", r.kind, mark, r.setting, mark,
                                    percent(r.error), milliseconds(r.ms));
            }
        }
        text += "\n";
        std::ofstream gp(folder / (name + ".gp"));
        gp << fmt::format("set terminal svg size 820,520 font 'sans,11' background '#ffffff'\n"
                          "set output '{}.svg'\nset datafile separator ','\n"
                          "set xlabel '{}'\nset ylabel 'relative error'\nset logscale xy\n"
                          "set format y '%g'\nset format x '%g'\nset grid lc rgb '#dddddd'\n"
                          "set key outside right top Left reverse samplen 1\n",
                          name, cost);
        gp << "plot ";
        const char* colours[] = {"#d0561f", "#2a6f97", "#5b8c2a", "#8a4fbf", "#c9a227",
                                 "#777777", "#c2203a", "#20808d", "#d77fb0"};
        for (std::size_t k = 0; k < drawn.size(); ++k) {
            // Only the best are named: the others stand in the table.
            gp << fmt::format("{}'{}.csv' index {} using 2:3 with points pt 7 ps 0.9 lc rgb '{}' "
                              "title '{}', '' index {} using ($4*$2):3:1 with labels left offset "
                              "1,0.5 font ',9' tc rgb '{}' notitle",
                              k ? ", \\\n     " : "", name, k, colours[k % std::size(colours)],
                              drawn[k], k, colours[k % std::size(colours)]);
        }
        // A ring around each that nothing beats in both.
        gp << fmt::format(", \\\n     '{}.csv' using ($4*$2):3 with points pt 6 ps 1.8 lw 2 lc rgb "
                          "'#111111' title 'best'\n",
                          name);
    }
};

}  // namespace bench

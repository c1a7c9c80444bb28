#pragma once

// What is wrong with a document: where it stands, what was expected, what was found.

#include <cstddef>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace graph {

// Where something stands in a document; line and column count from 1 (a column is a character, not
// a byte), 0 when there is none.
struct Place {
    std::string file;
    int line = 0, column = 0;
};

enum class Severity { note, warning, error };

// What Problem::port names.
enum class Part { none, parameter, input, output };

struct Problem {
    Place place;
    Severity severity = Severity::error;
    std::string node;  // empty: it is no node's
    Part part = Part::none;
    std::string port;
    std::string message;          // may be empty when expected and found say it all
    std::string expected, found;  // "a number of at least 0", "\"big\""
    std::string suggestion;       // "did you mean 'size'?"
};

// "graphs/chair.json:12:3".
std::string describe(const Place&);

// "graphs/chair.json:12:3: error: node 'cubes', parameter 'size': expected a number, found "big"".
std::string describe(const Problem&);

bool has_errors(std::span<const Problem>);

// A problem that only a frame could bring out.
struct Failure : std::runtime_error {
    explicit Failure(Problem what) : std::runtime_error(describe(what)), problem(std::move(what)) {}
    Problem problem;
};

// Collects problems, at most a thousand: a hostile file may hold a mistake every three bytes.
class Problems {
public:
    void add(Problem);
    // True once no further problem would be kept.
    bool full() const { return list_.size() >= most; }
    bool has_errors() const { return errors_; }
    // The names of the nodes that have errors.
    std::set<std::string, std::less<>> wrong_nodes() const;
    // All, by file and place, in the order in which the files were first named.
    std::vector<Problem> take();

    static constexpr std::size_t most = 1000;

private:
    std::vector<Problem> list_;
    std::size_t dropped_ = 0;
    bool errors_ = false;
};

// The candidate that `name` is most likely a slip of; empty when none is near. Letter case is free.
std::string nearest(std::string_view name, std::span<const std::string_view> candidates);

// "did you mean 'size'?" or, when nothing is near, "available: 'a', 'b' and 'c'" for a short list;
// of a long one only what shares a word or most letters with `name`, and nothing if that is none.
std::string suggest(std::string_view name, std::span<const std::string_view> candidates);

// "'a', 'b' and 'c'", at most `most` of them.
inline constexpr std::size_t listed = 12;
std::string list_names(std::span<const std::string_view> names, std::size_t most = listed);

}  // namespace graph

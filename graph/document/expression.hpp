#pragma once

// Expressions on parameters: "=0.5 * sin(2 * pi * time)". Parsed and run by muparser, with our own
// list of functions so that a document means the same whatever muparser's version brings.

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace graph {

// An expression that cannot be compiled; `position` counts bytes from its first.
struct ExpressionError : std::invalid_argument {
    ExpressionError(const std::string& what, std::size_t where, std::string help)
        : std::invalid_argument(what), position(where), suggestion(std::move(help))
    {}
    std::size_t position;
    std::string suggestion;
};

// A number that may change with the frame.
struct Expression {
    std::optional<double> constant;  // set when neither frame nor time has a say
    // Safe to call from several threads. Gives NaN or infinity where mathematics does.
    std::function<double(int frame, double time)> value;
};

// A number as a function of others, in the order of their names. Not from several threads.
using FunctionOf = std::function<double(std::span<const double>)>;

// The names that expressions of a document may use: `frame`, `time`, pi, functions, constants.
class Grammar {
public:
    Grammar();
    ~Grammar();
    Grammar(const Grammar&) = delete;
    Grammar& operator=(const Grammar&) = delete;

    // A constant of the document; free_name(name) must hold.
    void define(const std::string& name, double value);

    // A name that the document will define, for messages about its use before that.
    void announce(std::string name) { announced_.push_back(std::move(name)); }

    // Throws ExpressionError. Not from several threads.
    Expression compile(const std::string& text) const;

    // An expression of these names in the place of frame and time. Throws ExpressionError.
    FunctionOf compile_of(const std::string& text, const std::vector<std::string>& names) const;

    // Whether a variable may have this name: letters, digits and _, and nobody else's.
    static bool free_name(std::string_view name);

private:
    ExpressionError unknown(std::string name, std::size_t position) const;

    struct Parser;
    std::unique_ptr<Parser> parser_;
    std::vector<std::string> variables_, announced_;
};

// Smooth, deterministic noise in [-1, 1], zero at whole numbers; one bump or dip a unit.
double noise(double x);

}  // namespace graph

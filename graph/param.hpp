#pragma once

// Parameters: their description (what the loader, the reference, the schema and an editor read) and
// the binding of each to a member of a node's Inputs struct. Both come from one declaration.

#include <Eigen/Core>

#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

namespace graph {

enum class ParamKind {
    boolean,
    integer,
    number,
    vector,  // three numbers
    colour,  // three numbers in 0..1, linear RGB; documents may also say "#rrggbb" (sRGB)
    text,
    choice,    // one of `choices`
    path_in,   // a file to read; documents say it relative to themselves, a loaded graph absolute;
               // its bytes are part of the node's key
    path_out,  // a file to write, relative to the output folder
    list,      // any number of structs described by `children`
    block,     // one struct described by `children`
};

// A parameter's value for one frame. Choices are their name; blocks and lists nest.
struct ParamValue {
    std::variant<std::monostate, bool, std::int64_t, double, std::array<double, 3>, std::string,
                 std::vector<ParamValue>>
        is;

    bool operator==(const ParamValue&) const = default;
};
using ParamValues = std::vector<ParamValue>;

// What a number may be. `unit` is for people: "m", "Pa", "s", "deg".
struct Limits {
    double min = -std::numeric_limits<double>::infinity();
    double max = std::numeric_limits<double>::infinity();
    std::string unit = {};
};

// Show (and check) a parameter only while another of the same struct has one of these values.
struct ShownWhen {
    std::string param;
    std::vector<std::string> values;
};

struct Param {
    std::string name, doc;
    ParamKind kind = ParamKind::number;
    Limits limits;                     // integer, number; each component of vector and colour
    std::vector<std::string> choices;  // choice: in order of the enumerators
    std::vector<Param> children;       // list, block
    ShownWhen shown_when;              // empty name: always
    ParamValue fallback;               // the default

    bool numeric() const
    {
        return kind == ParamKind::integer || kind == ParamKind::number ||
               kind == ParamKind::vector || kind == ParamKind::colour;
    }
};

namespace detail {

template <class T>
concept Vector3 = std::is_same_v<T, Eigen::Vector3d> || std::is_same_v<T, Eigen::Vector3f>;

template <class T> void decode(const ParamValue& value, T& out)
{
    if constexpr (std::is_same_v<T, bool>) {
        out = std::get<bool>(value.is);
    } else if constexpr (std::is_integral_v<T>) {
        out = static_cast<T>(std::get<std::int64_t>(value.is));
    } else if constexpr (std::is_floating_point_v<T>) {
        out = static_cast<T>(std::get<double>(value.is));
    } else if constexpr (Vector3<T>) {
        const auto& a = std::get<std::array<double, 3>>(value.is);
        out = Eigen::Vector3d(a[0], a[1], a[2]).cast<typename T::Scalar>();
    } else {
        out = std::get<std::string>(value.is);
    }
}

// The number with the fewest digits that is this single: 0.7, not 0.699999988.
double as_written(float in);
inline double as_written(double in)
{
    return in;
}

template <class T> ParamValue encode(const T& in)
{
    if constexpr (std::is_same_v<T, bool>) {
        return {in};
    } else if constexpr (std::is_integral_v<T>) {
        return {static_cast<std::int64_t>(in)};
    } else if constexpr (std::is_floating_point_v<T>) {
        return {as_written(in)};
    } else if constexpr (Vector3<T>) {
        return {std::array<double, 3>{as_written(in[0]), as_written(in[1]), as_written(in[2])}};
    } else if constexpr (std::is_same_v<T, std::filesystem::path>) {
        return {in.generic_string()};
    } else {
        return {std::string(in)};
    }
}

// Which of the choices the value says. Throws std::invalid_argument when it says none.
std::size_t place_of(const ParamValue& value, const std::vector<std::string>& choices);

// The kind that a member of type T has unless its declaration says otherwise.
template <class T> constexpr ParamKind kind_of()
{
    if constexpr (std::is_same_v<T, bool>)
        return ParamKind::boolean;
    else if constexpr (std::is_integral_v<T>)
        return ParamKind::integer;
    else if constexpr (std::is_floating_point_v<T>)
        return ParamKind::number;
    else if constexpr (Vector3<T>)
        return ParamKind::vector;
    else {
        static_assert(std::is_same_v<T, std::string>, "no parameter kind for this member type");
        return ParamKind::text;
    }
}

}  // namespace detail

// The parameters of a struct: descriptions, and how each value finds its member. The struct's type
// is forgotten, so that all kinds of node share this code: a third less to compile.
struct ParamBinding {
    using Set = std::function<void(void* members, const ParamValue&)>;
    std::vector<Param> params;
    std::vector<Set> set;  // one a param

    void decode(const ParamValues& values, void* members) const
    {
        for (std::size_t i = 0; i < set.size(); ++i) set[i](members, values[i]);
    }

    // The parameter just added, for its caller to complete.
    Param& add(std::string& name, std::string& doc, ParamKind kind, ShownWhen& shown_when, Set how);
};

template <class S> class ParamsOf;
template <class S> using Describe = void (*)(ParamsOf<S>&);

// Declares parameters. `Self` is the builder that calls should return.
template <class S, class Self> class ParamBuilder {
public:
    // bool, any integer, float or double, std::string, Eigen::Vector3d or Vector3f.
    template <class T>
    Self& param(std::string name, T S::*member, std::string doc, Limits limits = {},
                ShownWhen shown_when = {})
    {
        if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>) {
            limits.min = std::max(limits.min, double(std::numeric_limits<T>::min()));
            limits.max = std::min(limits.max, double(std::numeric_limits<T>::max()));
        }
        Param& p = binding_.add(name, doc, detail::kind_of<T>(), shown_when, plain_setter(member));
        p.limits = std::move(limits);
        p.fallback = detail::encode(S{}.*member);
        return self();
    }

    // A colour: Eigen::Vector3f, linear RGB.
    Self& colour(std::string name, Eigen::Vector3f S::*member, std::string doc,
                 ShownWhen shown_when = {})
    {
        Param& p = binding_.add(name, doc, ParamKind::colour, shown_when, plain_setter(member));
        p.limits = {0, 1, {}};
        p.fallback = detail::encode(S{}.*member);
        return self();
    }

    // An enum whose enumerators are 0, 1, 2 ... in the order of `choices`.
    template <class E>
    requires std::is_enum_v<E> Self& choice(std::string name, E S::*member,
                                            std::vector<std::string> choices, std::string doc,
                                            ShownWhen shown_when = {})
    {
        auto set = [member, choices](void* s, const ParamValue& value) {
            of(s).*member = static_cast<E>(detail::place_of(value, choices));
        };
        Param& p = binding_.add(name, doc, ParamKind::choice, shown_when, std::move(set));
        p.fallback.is = choices.at(static_cast<std::size_t>(S{}.*member));
        p.choices = std::move(choices);
        return self();
    }

    // A file the node reads (part of its key by its bytes) or writes (below the output folder).
    Self& path_in(std::string name, std::filesystem::path S::*member, std::string doc,
                  ShownWhen shown_when = {})
    {
        Param& p = binding_.add(name, doc, ParamKind::path_in, shown_when, plain_setter(member));
        p.fallback = detail::encode(S{}.*member);
        return self();
    }
    Self& path_out(std::string name, std::filesystem::path S::*member, std::string doc,
                   ShownWhen shown_when = {})
    {
        Param& p = binding_.add(name, doc, ParamKind::path_out, shown_when, plain_setter(member));
        p.fallback = detail::encode(S{}.*member);
        return self();
    }

    // Parameters of a struct member, under one name of their own.
    template <class B>
    Self& block(std::string name, B S::*member, Describe<B> describe, std::string doc,
                ShownWhen shown_when = {})
    {
        auto inner = std::make_shared<const ParamBinding>(ParamsOf<B>::of(describe));
        auto set = [member, inner](void* s, const ParamValue& value) {
            B& block = of(s).*member = B();
            inner->decode(std::get<ParamValues>(value.is), &block);
        };
        Param& p = binding_.add(name, doc, ParamKind::block, shown_when, std::move(set));
        ParamValues fallback;
        for (const Param& child : inner->params) fallback.push_back(child.fallback);
        p.fallback.is = std::move(fallback);
        p.children = inner->params;
        return self();
    }

    // Any number of structs, none by default.
    template <class E>
    Self& list(std::string name, std::vector<E> S::*member, Describe<E> describe, std::string doc,
               ShownWhen shown_when = {})
    {
        auto inner = std::make_shared<const ParamBinding>(ParamsOf<E>::of(describe));
        auto set = [member, inner](void* s, const ParamValue& value) {
            for (const ParamValue& element : std::get<ParamValues>(value.is)) {
                inner->decode(std::get<ParamValues>(element.is), &(of(s).*member).emplace_back());
            }
        };
        Param& p = binding_.add(name, doc, ParamKind::list, shown_when, std::move(set));
        p.fallback.is = ParamValues{};
        p.children = inner->params;
        return self();
    }

protected:
    ParamBinding binding_;

private:
    static S& of(void* members) { return *static_cast<S*>(members); }
    template <class T> static ParamBinding::Set plain_setter(T S::*member)
    {
        return [member](void* s, const ParamValue& value) { detail::decode(value, of(s).*member); };
    }
    Self& self() { return static_cast<Self&>(*this); }
};

// Declares the parameters of a block or list element.
template <class S> class ParamsOf : public ParamBuilder<S, ParamsOf<S>> {
public:
    static ParamBinding of(Describe<S> describe)
    {
        ParamsOf builder;
        describe(builder);
        return std::move(builder.binding_);
    }
};

}  // namespace graph

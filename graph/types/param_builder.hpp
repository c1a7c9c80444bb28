#pragma once

// Declares parameters: one call per parameter gives its name, the member that it fills, what it is
// for and its limits. Description and binding come from that one declaration.
//
//   .param("count", &Inputs::count, "Number of points.", {.min = 1, .max = 100'000'000})
//   .choice("shape", &Inputs::shape, {"sphere", "box"}, "Shape of the mesh.")
//   .block("sphere", &Inputs::sphere, describe_sphere, "The sphere.", {"shape", {"sphere"}})

#include "graph/types/param_binding.hpp"

#include <algorithm>
#include <limits>
#include <memory>

namespace graph {

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

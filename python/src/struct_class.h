// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A struct of the library as a Python class of named values: keyword arguments with the struct's
// own defaults, attributes that check their values, ==, repr(), pickle and copy.
//
// @code
//   StructClass<Section>(m, "Section", "A section through a point.")
//       .field<&Section::point_mm>("point_mm", "Position of the crosshair [mm, LPS].")
//       .done();
// @endcode

#pragma once

#include <pliant/models/fem.h>
#include <pliant/models/fit.h>
#include <pliant/render.h>

#include <array>
#include <string_view>

#include "arrays.h"

namespace pliant::python {

/// Texts of an enumeration's values, in their order.
template <class E>
inline constexpr std::array<std::string_view, 0> kTextsOf{};
template <>
inline constexpr std::array<std::string_view, 2> kTextsOf<Polarity>{"rising", "falling"};
template <>
inline constexpr std::array<std::string_view, 2> kTextsOf<Style>{"plain", "real"};
template <>
inline constexpr std::array<std::string_view, 4> kTextsOf<Lining>{"airway", "colon", "sinus",
                                                                  "vessel"};
template <>
inline constexpr std::array<std::string_view, 3> kTextsOf<FieldStop>{"round", "octagon", "full"};
template <>
inline constexpr std::array<std::string_view, 3> kTextsOf<Orientation>{"axial", "coronal",
                                                                       "sagittal"};
template <>
inline constexpr std::array<std::string_view, 3> kTextsOf<LatticeLinks>{"edges", "edges_and_faces",
                                                                        "edges_faces_and_body"};
template <>
inline constexpr std::array<std::string_view, 2> kTextsOf<ReactionLaw>{"held", "relaxed"};
template <>
inline constexpr std::array<std::string_view, 2> kTextsOf<HexElement>{"trilinear",
                                                                      "incompatible_modes"};
template <>
inline constexpr std::array<std::string_view, 6> kTextsOf<BoxFace>{"low_x",  "high_x", "low_y",
                                                                   "high_y", "low_z",  "high_z"};
template <>
inline constexpr std::array<std::string_view, 3> kTextsOf<FitBoxGroups>{"uniform", "kinds",
                                                                        "directions"};
template <>
inline constexpr std::array<std::string_view, 3> kTextsOf<FitBound>{"none", "low", "high"};

/// "rising or falling"
template <class E>
std::string choices_of() {
    std::string list;
    for (std::size_t n = 0; n < kTextsOf<E>.size(); ++n)
        list.append(n == 0                       ? ""
                    : n + 1 < kTextsOf<E>.size() ? ", "
                                                 : " or ")
            .append(kTextsOf<E>[n]);
    return list;
}
template <class E>
std::string text_of(E value) {
    return std::string(kTextsOf<E>[std::size_t(value)]);
}

/// The enumerator with a text; another text is raised as an error of the named argument.
template <class E>
E choice_of(const std::string& text, const std::string& name) {
    for (std::size_t n = 0; n < kTextsOf<E>.size(); ++n)
        if (kTextsOf<E>[n] == text) return E(n);
    raise({ErrorCode::InvalidArgument, name + ": expected " + choices_of<E>() + ", found " + text,
           name, choices_of<E>(), text});
}

// Values of fields: to Python, from Python, the name of their type in the stubs, and words for
// messages.

template <class V>
struct FieldOf {
    static nb::object to(const V& value) {
        if constexpr (std::is_enum_v<V>)
            return nb::cast(text_of(value));
        else if constexpr (std::is_same_v<V, Rgb8>)
            return nb::make_tuple(value.r, value.g, value.b);
        else if constexpr (std::is_same_v<V, Vec3i>)
            return nb::make_tuple(value.x, value.y, value.z);
        else
            return nb::cast(value);
    }
    static V from(nb::handle given, const std::string& name) {
        if constexpr (std::is_enum_v<V>) {
            std::string text;
            if (!nb::try_cast(given, text)) raise_value(name, choices_of<V>(), given);
            return choice_of<V>(text, name);
        } else if constexpr (std::is_same_v<V, Rgb8> || std::is_same_v<V, Vec3i>) {
            constexpr bool is_colour = std::is_same_v<V, Rgb8>;
            Vec3d v{};
            const auto fits = [](double x) {
                return is_colour ? x >= 0 && x <= 255 : x >= -2147483648.0 && x <= 2147483647.0;
            };
            if (!vector_from(given, v) || !fits(v.x) || !fits(v.y) || !fits(v.z) ||
                v.x != double(int(v.x)) || v.y != double(int(v.y)) || v.z != double(int(v.z)))
                raise_value(name, words(), given);
            if constexpr (is_colour)
                return {std::uint8_t(v.x), std::uint8_t(v.y), std::uint8_t(v.z)};
            else
                return {int(v.x), int(v.y), int(v.z)};
        } else {
            V value{};
            if (!nb::try_cast(given, value)) raise_value(name, words(), given);
            return value;
        }
    }
    static std::string words() {
        if constexpr (std::is_same_v<V, bool>) return "True or False";
        if constexpr (std::is_same_v<V, Rgb8>) return "three whole numbers of 0 to 255";
        if constexpr (std::is_same_v<V, Vec3i>) return "three whole numbers";
        if constexpr (std::is_same_v<V, Vec3d>) return "three numbers";
        if constexpr (std::is_integral_v<V>) return "a whole number";
        if constexpr (std::is_floating_point_v<V>) return "a number";
        if constexpr (std::is_same_v<V, std::string>) return "a text";
        return "another value";
    }
    /// @param is_given  as an argument, which may be any sequence
    static std::string type(bool is_given) {
        if constexpr (std::is_same_v<V, bool>) return "bool";
        if constexpr (std::is_same_v<V, Rgb8> || std::is_same_v<V, Vec3i>)
            return is_given ? "collections.abc.Sequence[int]" : "tuple[int, int, int]";
        if constexpr (std::is_same_v<V, Vec3d>)
            return is_given ? "collections.abc.Sequence[float] | numpy.typing.NDArray[typing.Any]"
                            : "tuple[float, float, float]";
        if constexpr (std::is_integral_v<V>) return "int";
        if constexpr (std::is_floating_point_v<V>) return "float";
        return "str";
    }
};
template <class V>
struct FieldOf<std::optional<V>> {
    static nb::object to(const std::optional<V>& value) {
        return value ? FieldOf<V>::to(*value) : nb::none();
    }
    static std::optional<V> from(nb::handle given, const std::string& name) {
        if (given.is_none()) return {};
        return FieldOf<V>::from(given, name);
    }
    static std::string type(bool is_given) { return FieldOf<V>::type(is_given) + " | None"; }
};

/// A class of them. The values are those of the struct.
template <class T>
class StructClass {
  public:
    StructClass(nb::module_& m, const char* name, const char* text)
        : m_class(m, name, nb::is_weak_referenceable()), m_text(text) {}

    template <auto Member>
    StructClass& field(const char* name, const std::string& text) {
        using V = std::remove_cvref_t<decltype(std::declval<T&>().*Member)>;
        Row row{name, [](const T& t) { return FieldOf<V>::to(t.*Member); },
                [name](T& t, nb::handle given) { t.*Member = FieldOf<V>::from(given, name); },
                FieldOf<V>::type(true)};
        std::string about = text;
        if constexpr (std::is_enum_v<V>) {
            about.pop_back();
            about += ": " + choices_of<V>() + ".";
        }
        const std::string is = "def " + row.name + "(self, /) -> " + FieldOf<V>::type(false),
                          set = "def " + row.name + "(self, value: " + row.type + ", /) -> None";
        m_class.def_prop_rw(
            name, row.get, [set = row.set](T& t, const nb::object& given) { set(t, given); },
            nb::for_getter(nb::sig(is.c_str())), nb::for_setter(nb::sig(set.c_str())),
            nb::for_getter(about.c_str()));
        m_rows->push_back(std::move(row));
        return *this;
    }

    /// Adds the constructor and the methods that depend on all fields.
    nb::class_<T>& done() {
        const auto rows = m_rows;
        const auto set = [rows](T& t, const nb::dict& given) {
            T changed = t;
            for (const auto& [key, value] : given) {
                const std::string name = nb::cast<std::string>(key);
                const auto row = std::find_if(rows->begin(), rows->end(),
                                              [&](const Row& r) { return r.name == name; });
                if (row == rows->end()) {
                    std::string names;
                    for (const Row& r : *rows) names += (names.empty() ? "" : ", ") + r.name;
                    raise(unknown_setting(name, names));
                }
                row->set(changed, value);
            }
            t = std::move(changed);
        };
        const auto values = [rows](const T& t) {
            nb::dict dict;
            for (const Row& row : *rows) dict[row.name.c_str()] = row.get(t);
            return dict;
        };
        const T defaults{};
        std::string arguments, attributes;
        for (const Row& row : *rows) {
            const std::string argument = ", " + row.name + ": " + row.type + " = ";
            arguments += argument + nb::cast<std::string>(nb::repr(row.get(defaults)));
            attributes += argument + "...";
        }
        const std::string sig = "def __init__(self, *" + arguments + ") -> None";
        const std::string replaced = "def replaced(self, *" + attributes + ") -> typing.Self";
        m_class
            .def(
                "__init__",
                [set](T* self, const nb::kwargs& given) {
                    T made{};
                    set(made, given);
                    new (self) T(std::move(made));
                },
                nb::sig(sig.c_str()), "All arguments are attributes, described there.")
            .def(
                "replaced",
                [set](const T& t, const nb::kwargs& changes) {
                    T made = t;
                    set(made, changes);
                    return made;
                },
                nb::sig(replaced.c_str()), "A copy with some attributes changed.")
            .def(
                "__eq__",
                [values](const T& t, const nb::object& other) {
                    T same{};
                    return nb::try_cast(other, same) && values(t).equal(values(same));
                },
                nb::arg("other").none(), nb::sig("def __eq__(self, other: object, /) -> bool"))
            .def(
                "__hash__",
                [](const T&) -> Py_hash_t {
                    throw nb::type_error("it can be changed, so it has no hash");
                },
                nb::sig("def __hash__(self) -> int"))
            .def("__getstate__", values, nb::sig("def __getstate__(self) -> dict[str, typing.Any]"))
            .def(
                "__setstate__",
                [set](T& self, const nb::dict& state) {
                    new (&self) T();
                    set(self, state);
                },
                nb::sig("def __setstate__(self, state: dict[str, typing.Any], /) -> None"))
            .def("__repr__",
                 [rows, name = nb::cast<std::string>(m_class.attr("__name__"))](const T& t) {
                     const T at_rest{};
                     std::string text;
                     for (const Row& row : *rows)
                         if (const nb::object value = row.get(t); !value.equal(row.get(at_rest)))
                             text += (text.empty() ? "" : ", ") + row.name + "=" +
                                     nb::cast<std::string>(nb::repr(value));
                     return name + "(" + text + ")";
                 });
        m_class.attr("__doc__") = m_text.c_str();
        return m_class;
    }

  private:
    struct Row {
        std::string name;
        std::function<nb::object(const T&)> get;
        std::function<void(T&, nb::handle)> set;
        std::string type;
    };
    nb::class_<T> m_class;
    std::string m_text;
    std::shared_ptr<std::vector<Row>> m_rows = std::make_shared<std::vector<Row>>();
};

}  // namespace pliant::python

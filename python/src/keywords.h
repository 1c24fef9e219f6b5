// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings as keyword arguments in signatures and docstrings. Names, types, defaults, units and
// ranges are those of the rows that the library checks. The stub is made from the signatures, so
// editors and type checkers know every setting.
//
// @code
//   const Keywords settings = keywords_of(wall_rows());
//   m.def("make_wall", ..., nb::arg("settings"),
//         typed("def make_wall(mesh: TetMesh, *, **settings) -> Wall", settings),
//         described("Makes a wall.\n\nArgs:\n    **settings", settings));
// @endcode

#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "arrays.h"

namespace pliant::python {

/// A row in Python's syntax.
struct Keyword {
    std::string name;
    std::string type;
    std::string value;  ///< default; "..." if it isn't the same for all calls
    std::string text;   ///< meaning and range
};
using Keywords = std::vector<Keyword>;

Keyword keyword_of(const SettingInfo& row, const SettingValue& value);

/// All rows of a table, with the defaults of the struct.
template <class T>
Keywords keywords_of(SettingRows<T> rows) {
    const T defaults;
    Keywords keywords;
    for (const Setting<T>& row : rows) keywords.push_back(keyword_of(row, value_of(defaults, row)));
    return keywords;
}

/// Keywords of several tables. A name that several tables have takes the types of all.
Keywords together(std::initializer_list<Keywords> tables);
/// The keywords without some names.
Keywords without(Keywords keywords, std::initializer_list<std::string_view> names);
/// The keywords with "..." as default. @param names  empty: all
Keywords unset(Keywords keywords, std::initializer_list<std::string_view> names = {});

/// A signature, for nanobind's def().
struct Signature {
    std::string text;
};
/// A docstring, for nanobind's def().
struct Docstring {
    std::string text;
};

/// A signature with the keywords in place of "**settings", except those that it names itself.
Signature typed(std::string_view signature, const Keywords& keywords);
/// A docstring with a line for each keyword in place of "    **settings".
Docstring described(std::string_view text, const Keywords& keywords);

}  // namespace pliant::python

namespace nanobind::detail {

template <class F>
void func_extra_apply(F& f, const pliant::python::Signature& signature, size_t& argument) {
    func_extra_apply(f, sig(signature.text.c_str()), argument);
}
template <class F>
void func_extra_apply(F& f, const pliant::python::Docstring& docstring, size_t& argument) {
    func_extra_apply(f, docstring.text.c_str(), argument);
}

}  // namespace nanobind::detail

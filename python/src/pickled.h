// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Pickle and copy for structs of values: the state is a tuple of the named members.
//
// @code
//   nb::class_<CutReport>(m, "CutReport", "Result of a cut.")
//       .def(Pickled<&CutReport::cut_links, &CutReport::cut_ms>());
// @endcode

#pragma once

#include <type_traits>

#include "arrays.h"

namespace pliant::python {

template <auto... Members>
struct Pickled : nb::def_visitor<Pickled<Members...>> {
    template <class Class, class... Extra>
    void execute(Class& c, const Extra&...) {
        using T = typename Class::Type;
        c.def(
             "__getstate__",
             [](const T& values) { return nb::make_tuple(stored(values.*Members)...); },
             nb::sig("def __getstate__(self) -> tuple[typing.Any, ...]"))
            .def(
                "__setstate__",
                [](T& values, const nb::tuple& state) {
                    T made{};
                    std::size_t n = 0;
                    const bool fits = state.size() == sizeof...(Members) &&
                                      (restored(state[n++], made.*Members) && ...);
                    if (!fits) raise_value("state", "that of __getstate__()", state);
                    new (&values) T(std::move(made));
                },
                nb::sig("def __setstate__(self, state: tuple[typing.Any, ...], /) -> None"));
    }

  private:
    template <class V>
    static nb::object stored(const V& value) {
        if constexpr (std::is_enum_v<V>)
            return nb::cast(int(value));
        else if constexpr (std::is_same_v<V, Mat3d>)
            return nb::make_tuple(value.columns[0], value.columns[1], value.columns[2]);
        else
            return nb::cast(value);
    }
    template <class V>
    static bool restored(nb::handle from, V& to) {
        if constexpr (std::is_enum_v<V>) {
            int number = 0;
            if (!nb::try_cast(from, number)) return false;
            to = V(number);
            return true;
        } else if constexpr (std::is_same_v<V, Mat3d>) {
            nb::tuple columns;
            if (!nb::try_cast(from, columns) || columns.size() != 3) return false;
            for (std::size_t n = 0; n < 3; ++n)
                if (!vector_from(columns[n], to.columns[n])) return false;
            return true;
        } else {
            return nb::try_cast(from, to);
        }
    }
};

}  // namespace pliant::python

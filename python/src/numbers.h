// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Arrays of numbers and of vectors, in and out.

#pragma once

#include <span>
#include <type_traits>

#include "arrays.h"

namespace pliant::python {

template <class T>
constexpr const char* dtype_name() {
    if constexpr (std::is_same_v<T, double>) return "float64";
    if constexpr (std::is_same_v<T, float>) return "float32";
    if constexpr (std::is_same_v<T, std::int32_t>) return "int32";
    if constexpr (std::is_same_v<T, bool>) return "bool";
}

/// Numbers of an argument, in rows of a length, without a copy where type and order allow. An
/// array without elements has any shape. Columns 0: one axis; any number of axes before the rows'.
template <class T, std::size_t Columns>
class Numbers {
  public:
    Numbers(const nb::object& given, const char* name) {
        const nb::module_ numpy = nb::module_::import_("numpy");
        nb::object array = array_of_argument(given, name);
        const std::string kind = nb::cast<std::string>(array.attr("dtype").attr("kind"));
        const bool is_empty = nb::cast<std::size_t>(array.attr("size")) == 0;
        const auto ndim = nb::cast<std::size_t>(array.attr("ndim"));
        const char* const kinds = std::is_floating_point_v<T> ? "biuf"
                                  : std::is_same_v<T, bool>   ? "b"
                                                              : "iu";
        bool fits = is_empty || std::string_view(kinds).find(kind) != std::string_view::npos;
        if (Columns == 0)
            fits = fits && ndim == 1;
        else if (!is_empty)
            fits = fits && ndim >= 1 &&
                   nb::cast<std::size_t>(array.attr("shape")[nb::int_(ndim - 1)]) == Columns;
        if (!fits) refuse(name, array);
        for (std::size_t n = 0; n + (Columns == 0 ? 0 : 1) < ndim; ++n)
            m_leading.push_back(nb::cast<std::size_t>(array.attr("shape")[nb::int_(n)]));
        // No numbers: no rows, whatever the other axes say.
        if (is_empty && Columns > 0) m_leading = {0};
        if constexpr (std::is_integral_v<T> && !std::is_same_v<T, bool>)
            if (!is_empty && (nb::cast<double>(array.attr("min")()) < -2147483648.0 ||
                              nb::cast<double>(array.attr("max")()) > 2147483647.0))
                refuse(name, array);
        m_memory = numpy.attr("ascontiguousarray")(array, dtype_name<T>()).attr("reshape")(-1);
        m_numbers = nb::cast<Array>(m_memory);
    }

    std::size_t rows() const { return m_numbers.size() / std::max<std::size_t>(Columns, 1); }
    std::span<const T> numbers() const { return {m_numbers.data(), m_numbers.size()}; }
    std::span<const Vec3d> vectors() const {
        static_assert(std::is_same_v<T, double> && Columns == 3);
        return {reinterpret_cast<const Vec3d*>(m_numbers.data()), rows()};
    }
    std::vector<Vec3d> copied_vectors() const { return {vectors().begin(), vectors().end()}; }
    std::vector<T> copied() const { return {numbers().begin(), numbers().end()}; }
    std::vector<std::array<T, Columns>> copied_rows() const {
        const auto* const first = reinterpret_cast<const std::array<T, Columns>*>(m_numbers.data());
        return {first, first + rows()};
    }
    /// The shape without the last axis.
    const std::vector<std::size_t>& leading_shape() const { return m_leading; }

  private:
    using Array = nb::ndarray<const T, nb::ndim<1>, nb::c_contig, nb::device::cpu>;

    [[noreturn]] static void refuse(const char* name, const nb::object& array) {
        const std::string expected =
            (Columns == 0 ? std::string("one axis")
                          : "axes (..., " + std::to_string(Columns) + ")") +
            (std::is_floating_point_v<T> ? " of numbers"
             : std::is_same_v<T, bool>   ? " of flags"
                                         : " of whole numbers");
        const std::string found = shown(array.attr("shape")) + " of " + shown(array.attr("dtype"));
        raise({ErrorCode::InvalidArgument,
               std::string(name) + ": expected " + expected + ", found " + found, name, expected,
               found});
    }

    nb::object m_memory;
    Array m_numbers;
    std::vector<std::size_t> m_leading;
};

/// A number for each of `count` items, from one number or an array of `count`.
inline std::vector<double> spread(const nb::object& given, std::size_t count, const char* name) {
    double one = 0;
    if (nb::try_cast(given, one)) return std::vector<double>(count, one);
    std::vector<double> numbers = Numbers<double, 0>(given, name).copied();
    if (numbers.size() != count)
        raise({ErrorCode::InvalidArgument,
               std::string(name) + ": expected " + std::to_string(count) + " numbers, found " +
                   std::to_string(numbers.size()),
               name, std::to_string(count), std::to_string(numbers.size())});
    return numbers;
}

/// A writable array that keeps the values, of one number or of several each.
template <class T, class V>
nb::object array_owning(std::vector<V> values, std::span<const std::size_t> shape) {
    static_assert(sizeof(V) % sizeof(T) == 0);
    auto* const kept = new std::vector<V>(std::move(values));
    const nb::capsule owner(kept, [](void* p) noexcept { delete static_cast<std::vector<V>*>(p); });
    return nb::cast(nb::ndarray<nb::numpy, T>(kept->data(), shape.size(), shape.data(), owner));
}
template <class T>
nb::object array_owning(std::vector<T> values) {
    const std::array shape{values.size()};
    return array_owning<T>(std::move(values), shape);
}

/// A read-only array (n, 3) of vectors that the owner keeps.
inline nb::object viewed_rows(std::span<const Vec3d> vectors, nb::handle owner) {
    return nb::cast(nb::ndarray<nb::numpy, const double, nb::shape<-1, 3>>(
        reinterpret_cast<const double*>(vectors.data()), {vectors.size(), 3}, owner));
}

}  // namespace pliant::python

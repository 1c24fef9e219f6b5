// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include "formats/recorded_files.h"

#include <limits>

#include "base/text.h"

namespace pliant::test {
namespace {

template <class T>
NumberType type_of(const char* name, std::vector<std::string> nrrd, std::vector<std::string> meta,
                   std::int16_t nifti) {
    using Limits = std::numeric_limits<T>;
    std::vector<T> values = {Limits::lowest(), Limits::max(), T(0), T(1), T(100), T(101)};
    constexpr double kWide[] = {-1,     -1000.0, -32768, 32767,    32768, 65535,
                                65536,  70000,   -70000, 16777217, -3e9,  4e9,
                                1.25e6, 3071,    -1024,  1e12,     -1e15, 12345678};
    constexpr double kBroken[] = {0.5, -1000.25, 1e-30, 3.4e38, 1.1, 1e30};
    for (const double wide : kWide) {
        const bool fits = Limits::is_iec559 ||
                          (wide >= double(Limits::lowest()) && wide <= double(Limits::max()));
        values.push_back(fits ? T(wide) : T(values.size()));
    }
    if (Limits::is_iec559)
        for (std::size_t n = 0; n < std::size(kBroken); ++n) values[n] = T(kBroken[n]);
    if (sizeof(T) == 8 && Limits::is_iec559) {  // of which the floats are made
        values[0] = T(1e300);
        values[1] = T(0.1);
    }
    NumberType type{name, std::move(nrrd), std::move(meta), nifti, sizeof(T), packed(values), {}};
    for (std::size_t n = 0; n < values.size(); ++n) {
        if constexpr (Limits::is_iec559)
            type.text += text_of(double(values[n]));
        else
            type.text += std::to_string(values[n]);
        type.text += n % 4 == 3 ? "\n" : " ";
    }
    return type;
}

}  // namespace

const std::vector<NumberType>& number_types() {
    static const std::vector<NumberType> kTypes = {
        type_of<std::int8_t>("int8", {"signed char", "int8", "int8_t"}, {"MET_CHAR"}, 256),
        type_of<std::uint8_t>("uint8", {"uchar", "unsigned char", "uint8", "uint8_t"},
                              {"MET_UCHAR"}, 2),
        type_of<std::int16_t>(
            "int16", {"short", "short int", "signed short", "signed short int", "int16", "int16_t"},
            {"MET_SHORT"}, 4),
        type_of<std::uint16_t>(
            "uint16", {"ushort", "unsigned short", "unsigned short int", "uint16", "uint16_t"},
            {"MET_USHORT"}, 512),
        type_of<std::int32_t>("int32", {"int", "signed int", "int32", "int32_t"},
                              {"MET_INT", "MET_LONG"}, 8),
        type_of<std::uint32_t>("uint32", {"uint", "unsigned int", "uint32", "uint32_t"},
                               {"MET_UINT", "MET_ULONG"}, 768),
        type_of<std::int64_t>("int64",
                              {"longlong", "long long", "long long int", "signed long long",
                               "signed long long int", "int64", "int64_t"},
                              {"MET_LONG_LONG"}, 1024),
        type_of<std::uint64_t>(
            "uint64",
            {"ulonglong", "unsigned long long", "unsigned long long int", "uint64", "uint64_t"},
            {"MET_ULONG_LONG"}, 1280),
        type_of<float>("float32", {"float", "FLOAT"}, {"MET_FLOAT"}, 16),
        type_of<double>("float64", {"double"}, {"MET_DOUBLE"}, 64)};
    return kTypes;
}

}  // namespace pliant::test

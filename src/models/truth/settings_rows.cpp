// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/data/truth.h>

namespace pliant {
namespace {

using T = TruthSettings;

constexpr Setting<T> kTruthSettings[] = {
    setting<&T::kinds>({.name = "kinds",
                        .text = "motions that are drawn from: contact, slide, cut, interface, "
                                "breathing, separated by commas"}),
    setting<&T::motions>({.name = "motions", .range = {1, 50}, .text = "of a case"}),
    setting<&T::contact_mm>({.name = "contact_mm",
                             .unit = "mm",
                             .range = {0.5, 100},
                             .text = "largest length of a push"}),
    setting<&T::slide_mm>({.name = "slide_mm",
                           .unit = "mm",
                           .range = {0.5, 200},
                           .text = "largest length of a slide along a wall"}),
    setting<&T::cut_mm>({.name = "cut_mm",
                         .unit = "mm",
                         .range = {0.5, 100},
                         .text = "largest distance by which the halves of a cut are moved apart"}),
    setting<&T::interface_mm>(
        {.name = "interface_mm",
         .unit = "mm",
         .range = {0.5, 100},
         .text = "largest distance by which the sides of a cut slide along each other"}),
    setting<&T::breathing_mm>({.name = "breathing_mm",
                               .unit = "mm",
                               .range = {0.5, 60},
                               .text = "largest displacement of breathing"}),
    setting<&T::tool_radius_mm>({.name = "tool_radius_mm",
                                 .unit = "mm",
                                 .range = {0.5, 50},
                                 .text = "largest radius of pushing and sliding spheres"}),
    setting<&T::cut_length_mm>({.name = "cut_length_mm",
                                .unit = "mm",
                                .range = {2, 200},
                                .text = "largest length of a cut, which is half as deep"}),
    setting<&T::band_mm>({.name = "band_mm",
                          .unit = "mm",
                          .range = {0, 20},
                          .text = "distance from a wall or a cut up to which a voxel is at it"}),
    setting<&T::landmarks>({.name = "landmarks", .range = {0, 100000}, .text = "of a case"}),
};

template <std::size_t N, class E>
std::string_view entry(const std::array<std::string_view, N>& names, E e) {
    const auto n = std::size_t(e);
    return n < N ? names[n] : std::string_view{};
}

}  // namespace

SettingRows<TruthSettings> truth_rows() noexcept {
    return kTruthSettings;
}

std::string_view name_of(TruthKind kind) noexcept {
    static constexpr std::array<std::string_view, kTruthKinds> kNames{"contact", "slide", "cut",
                                                                      "interface", "breathing"};
    return entry(kNames, kind);
}
std::string_view name_of(TruthLabel label) noexcept {
    static constexpr std::array<std::string_view, kTruthLabels> kNames{"air",  "interior",  "bone",
                                                                       "wall", "interface", "cut"};
    return entry(kNames, label);
}
std::string_view name_of(TruthMask mask) noexcept {
    static constexpr std::array<std::string_view, 5> kNames{"exact", "outside", "gap", "ambiguous",
                                                            "closed_lumen"};
    return entry(kNames, mask);
}
std::string_view name_of(TruthRow row) noexcept {
    static constexpr std::array<std::string_view, kTruthRows> kNames{
        "moved", "interior", "wall", "interface", "cut", "still", "bone", "landmarks"};
    return entry(kNames, row);
}

}  // namespace pliant

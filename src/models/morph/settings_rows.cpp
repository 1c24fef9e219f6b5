// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

#include <pliant/data/morph.h>

namespace pliant {
namespace {

using M = MorphSettings;

constexpr Setting<M> kMorphSettings[] = {
    setting<&M::prior>({.name = "prior",
                        .choices = "auto|supine|none",
                        .text = "of the elastic lungs of a patient who lies on the back; auto: "
                                "where a label has the shape of two lungs"}),
    setting<&M::point_softness_mm>({.name = "point_softness_mm",
                                    .unit = "mm",
                                    .range = {1e-6, 1e6},
                                    .text = "of the spline at known points; small: they are met"}),
    setting<&M::slide_softness_mm>({.name = "slide_softness_mm",
                                    .unit = "mm",
                                    .range = {1e-3, 1e9},
                                    .text = "of the spline at sliding surfaces beside points"}),
    setting<&M::poisson_ratio>({.name = "poisson_ratio",
                                .range = {-1, 0.5},
                                .above_low = true,
                                .below_high = true,
                                .text = "of the elastic bodies"}),
    setting<&M::bending_mm2>({.name = "bending_mm2",
                              .unit = "mm2",
                              .range = {0, 1e9},
                              .text = "second-order modulus of the bodies over the shear modulus"}),
    setting<&M::least_volume>({.name = "least_volume",
                               .range = {1e-3, 0.9},
                               .text = "smallest share of its volume that an element may keep"}),
};

}  // namespace

SettingRows<MorphSettings> morph_rows() noexcept {
    return kMorphSettings;
}

}  // namespace pliant

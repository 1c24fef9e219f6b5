// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colours of the tissues behind a wall, for each kind of lumen; linear red, green and blue. The
// page has the same table (viewer/src/views/linings.ts).

#pragma once

#include <pliant/render.h>

namespace pliant::render {

struct LiningColours {
    Vec3d mucosa;
    Vec3d pale;       ///< over cartilage
    Vec3d fatty;      ///< over fat
    Vec3d bony;       ///< over bone
    Vec3d thin_wall;  ///< with air behind
    /// Maximum share by which each tissue replaces the mucosa's colour.
    double fat_share, pale_share, bone_share, thin_share;
    double vein_share;  ///< opacity of blood vessels
    double mottle;      ///< contrast of patches
    double gloss;       ///< of the film of liquid
};

inline LiningColours lining_colours(Lining lining) {
    switch (lining) {
        case Lining::Colon:
            return {.mucosa = {0.66, 0.225, 0.15},
                    .pale = {0.74, 0.4, 0.31},
                    .fatty = {0.74, 0.33, 0.2},
                    .bony = {0.8, 0.62, 0.46},
                    .thin_wall = {0.62, 0.19, 0.13},
                    .fat_share = 0.25,
                    .pale_share = 0.3,
                    .bone_share = 0.3,
                    .thin_share = 0.3,
                    .vein_share = 0.8,
                    .mottle = 0.5,
                    .gloss = 1.3};
        case Lining::Sinus:
            return {.mucosa = {0.68, 0.225, 0.21},
                    .pale = {0.76, 0.4, 0.34},
                    .fatty = {0.76, 0.34, 0.25},
                    .bony = {0.8, 0.54, 0.42},
                    .thin_wall = {0.6, 0.165, 0.15},
                    .fat_share = 0.3,
                    .pale_share = 0.4,
                    .bone_share = 0.3,
                    .thin_share = 0.25,
                    .vein_share = 0.45,
                    .mottle = 0.55,
                    .gloss = 1.2};
        case Lining::Vessel:
            return {.mucosa = {0.73, 0.355, 0.26},
                    .pale = {0.8, 0.6, 0.46},
                    .fatty = {0.8, 0.48, 0.28},
                    .bony = {0.86, 0.74, 0.55},
                    .thin_wall = {0.6, 0.24, 0.17},
                    .fat_share = 0.35,
                    .pale_share = 0.5,
                    .bone_share = 0.7,
                    .thin_share = 0.3,
                    .vein_share = 0.25,
                    .mottle = 0.45,
                    .gloss = 0.8};
        case Lining::Airway:
            break;
    }
    return {.mucosa = {0.67, 0.23, 0.165},
            .pale = {0.8, 0.45, 0.35},
            .fatty = {0.79, 0.38, 0.21},
            .bony = {0.82, 0.6, 0.45},
            .thin_wall = {0.56, 0.14, 0.115},
            .fat_share = 0.5,
            .pale_share = 0.6,
            .bone_share = 0.6,
            .thin_share = 0.4,
            .vein_share = 0.65,
            .mottle = 0.55,
            .gloss = 1.0};
}

/// Colour of cut or carved tissue in every lumen.
inline constexpr Vec3d kFlesh{0.46, 0.036, 0.038};

}  // namespace pliant::render

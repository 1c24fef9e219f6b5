// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Colours of the tissues behind a wall, for each kind of lumen; linear red, green and blue. The
// page has the same table (viewer/src/linings.ts).

#pragma once

#include <pliant/render.h>

namespace pliant::render {

struct LiningColours {
    Vec3d mucosa, pale, fat, bone, thin;  ///< pale: over cartilage; thin: with air behind
    Vec3d vein;
    double fat_share, pale_share, thin_share;  ///< of the mucosa's colour that is replaced at most
    double veins;                              ///< opacity of blood vessels
    double mottle;                             ///< contrast of patches
    double gloss;                              ///< of the film of liquid
};

inline LiningColours lining_colours(Lining lining) {
    switch (lining) {
        case Lining::Colon:
            return {{0.66, 0.215, 0.125},
                    {0.74, 0.40, 0.30},
                    {0.78, 0.36, 0.18},
                    {0.80, 0.62, 0.44},
                    {0.60, 0.17, 0.11},
                    {0.34, 0.03, 0.035},
                    0.30,
                    0.30,
                    0.30,
                    0.80,
                    0.50,
                    1.3};
        case Lining::Sinus:
            return {{0.66, 0.205, 0.165},
                    {0.78, 0.45, 0.37},
                    {0.78, 0.38, 0.22},
                    {0.82, 0.60, 0.45},
                    {0.60, 0.17, 0.15},
                    {0.40, 0.04, 0.05},
                    0.30,
                    0.45,
                    0.25,
                    0.45,
                    0.55,
                    1.2};
        case Lining::Vessel:
            return {{0.70, 0.34, 0.22},
                    {0.80, 0.60, 0.42},
                    {0.80, 0.50, 0.24},
                    {0.86, 0.74, 0.55},
                    {0.60, 0.24, 0.17},
                    {0.45, 0.08, 0.06},
                    0.35,
                    0.50,
                    0.30,
                    0.25,
                    0.45,
                    0.8};
        case Lining::Airway:
            break;
    }
    return {{0.66, 0.19, 0.135},
            {0.80, 0.45, 0.35},
            {0.79, 0.38, 0.20},
            {0.82, 0.60, 0.45},
            {0.56, 0.13, 0.11},
            {0.34, 0.028, 0.036},
            0.50,
            0.60,
            0.40,
            0.65,
            0.55,
            1.0};
}

/// Tissue that was cut or carved, everywhere.
inline constexpr Vec3d kFlesh{0.36, 0.022, 0.026};

}  // namespace pliant::render

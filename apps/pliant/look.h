// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Conversion of the options' words to an endoscope.

#pragma once

#include <pliant/render.h>

#include "options.h"

namespace pliant::app {

inline FieldStop field_stop_of(const LookOptions& look) {
    return look.field_stop == "octagon" ? FieldStop::Octagon
           : look.field_stop == "full"  ? FieldStop::Full
                                        : FieldStop::Round;
}

/// Sets style, lining and field stop. auto chooses by the endoscope's polarity. @pre the words
/// passed add_look
inline void set_look(const LookOptions& look, Endoscope& endoscope) {
    endoscope.style = look.style == "real" ? Style::Real : Style::Plain;
    const bool vessel = endoscope.polarity == Polarity::Falling;
    endoscope.lining = look.lining == "colon"    ? Lining::Colon
                       : look.lining == "sinus"  ? Lining::Sinus
                       : look.lining == "vessel" ? Lining::Vessel
                       : look.lining == "airway" ? Lining::Airway
                       : vessel                  ? Lining::Vessel
                                                 : Lining::Airway;
    endoscope.field_stop = field_stop_of(look);
}

}  // namespace pliant::app

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Shaders, concatenated from the files of src/shaders. The bundler includes their text.

import blend from '../shaders/blend.frag.glsl';
import camera from '../shaders/camera.glsl';
import catheter from '../shaders/catheter.glsl';
import copy from '../shaders/copy.frag.glsl';
import endoscope from '../shaders/endoscope.frag.glsl';
import field from '../shaders/field.glsl';
import fluoroscopy from '../shaders/fluoroscopy.frag.glsl';
import full from '../shaders/full.vert.glsl';
import instrument from '../shaders/instrument.glsl';
import labels from '../shaders/labels.glsl';
import overlay from '../shaders/overlay.glsl';
import real from '../shaders/real.glsl';
import rest from '../shaders/rest.glsl';
import section from '../shaders/section.frag.glsl';
import slab from '../shaders/slab.glsl';
import srgb from '../shaders/srgb.glsl';
import surface from '../shaders/surface.glsl';
import vesselFragment from '../shaders/vessel.frag.glsl';
import vesselVertex from '../shaders/vessel.vert.glsl';

export const kFullScreen = full;
export const kEndoscope =
    field +
    surface +
    overlay +
    labels +
    rest +
    camera +
    instrument +
    catheter +
    real +
    srgb +
    endoscope;
export const kSection = field + overlay + labels + slab + section;
export const kCopy = copy;
export const kFluoroscopy = '#define SHADOW\n' + field + catheter + fluoroscopy;
export const kBlend = field + surface + overlay + camera + instrument + catheter + srgb + blend;
export const kVesselVertex = vesselVertex;
export const kVesselFragment = vesselFragment;

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Set-ups of measurements on scans that are not in the repository.

import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { kFolder } from './browser.ts';
import type { Push } from './latency.ts';

export const kData = process.env.PLIANT_SHARED_DATA ?? join(kFolder, '../../shared/data');
export const kThorax = join(kData, 'thorax_ct_256.nrrd');
export const kAorta = join(kData, 'aorta_cta_1p5mm.nii.gz');
export const kAbdomen = join(kData, 'abdomen_ct_3mm.nii.gz');

/// Path of the thorax. @throws an Error if it or the program is missing
export function thorax(): string {
    if (process.env.PLIANT_SERVER && existsSync(kThorax)) return kThorax;
    throw new Error(`expected PLIANT_SERVER, a program, and ${kThorax}`);
}

/// Push in the heart: 2 mm to and fro, 60 mm/s, moves more than 50 thousand elements.
export const kHeart: Push = { centre: [0, 118, -627], radius: 36, mm: 2 };
export const kHertz = 30;
export const kRun = { ...kHeart, warmUp: 10, hertz: kHertz };

/// Pushes of a few hundred to ten thousands of elements.
export const kBalls: readonly Push[] = [
    [3, 1],
    [6, 2],
    [10, 4],
    [15, 6],
    [18, 11],
    [30, 16],
].map(([radius, mm]) => ({ centre: kHeart.centre, radius: radius!, mm: mm! }));

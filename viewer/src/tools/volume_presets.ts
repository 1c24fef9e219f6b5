// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Presets of the volume rendering that suit the present scan.

import { levelsOf } from '../maths/levels.ts';
import { kCtPresets, kLevelPresets, type TransferPreset } from '../maths/transfer.ts';
import type { VolumeInfo } from '../net/protocol.ts';
import { isInHu, scaleOf } from '../state/units.ts';
import type { Scene } from './scene.ts';

/// Presets of a scan: those of CT for values in HU only.
export const presetsOf = (info: VolumeInfo): TransferPreset[] => [
    ...(isInHu(info) ? kCtPresets : []),
    ...kLevelPresets,
];

/// Takes a preset, with its own opacity and values. Its extinctions are those for a body; a smaller
/// scan is as dense.
export function usePreset(scene: Scene, { name, transferOf }: TransferPreset): void {
    const scale = scaleOf(scene.store.state.scan.volume);
    const transfer = transferOf(() => levelsOf(scene.volume!.halves)).map((point) => ({
        ...point,
        perMm: point.perMm / scale,
    }));
    scene.store.set({ rendering: { preset: name, transfer, opacity: 1, shift: 0 } });
}

/// Takes the first preset of a scan when its volume is shown for the first time.
export function followScan(scene: Scene): void {
    scene.store.watch(
        ({ scan, view, rendering }) => [
            view.outside && view.blended && scan.loaded === 1 && !rendering.preset,
        ],
        (wanted) => {
            const info = scene.store.state.scan.volume;
            if (wanted && info) usePreset(scene, presetsOf(info)[0]!);
        },
    );
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Presets of the volume rendering that suit the present scan.

import { levelsOf } from '../maths/levels.ts';
import { kCtPresets, kLevelPresets, type TransferPreset } from '../maths/transfer.ts';
import type { VolumeInfo } from '../net/protocol.ts';
import type { Scene } from './scene.ts';

const kAirHu = -500; // a scan with lower values is a CT

/// Presets of a scan: those in HU for a CT only.
export const presetsOf = (info: VolumeInfo): TransferPreset[] => [
    ...(info.range_hu[0] < kAirHu ? kCtPresets : []),
    ...kLevelPresets,
];

/// Takes a preset, with its own opacity and values.
export function usePreset(scene: Scene, { name, transferOf }: TransferPreset): void {
    const transfer = transferOf(() => levelsOf(scene.volume!.halves));
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

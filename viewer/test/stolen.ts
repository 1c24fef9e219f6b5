// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// How much of the processors' time the machine didn't get, being a virtual one among others. Times
// that were taken meanwhile say more about those than about what was measured.

import { readFileSync } from 'node:fs';

/// Of all processors since the start: what others took, and all of it. Zeros where nothing says so.
function ticks(): [number, number] {
    try {
        const all = readFileSync('/proc/stat', 'utf8').split('\n')[0]!.split(/\s+/).slice(1, 9);
        return [Number(all[7]), all.reduce((sum, n) => sum + Number(n), 0)];
    } catch {
        return [0, 0];
    }
}

/// The share of the time that was stolen while something was done.
export async function watched<T>(work: () => Promise<T>): Promise<T & { stolen: number }> {
    const [stolen, all] = ticks();
    const result = await work();
    const [stolenNow, allNow] = ticks();
    return { ...result, stolen: allNow > all ? (stolenNow - stolen) / (allNow - all) : 0 };
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Steal time of a virtual machine: processor time taken by others. Times measured with a large
// share of it are not meaningful.

import { readFileSync } from 'node:fs';

/// Steal time and total time of all processors since the start; zeros if unknown.
function ticks(): [number, number] {
    try {
        const all = readFileSync('/proc/stat', 'utf8').split('\n')[0]!.split(/\s+/).slice(1, 9);
        return [Number(all[7]), all.reduce((sum, n) => sum + Number(n), 0)];
    } catch {
        return [0, 0];
    }
}

/// Runs a function. @returns the share of steal time meanwhile
export async function watched<T>(work: () => Promise<T>): Promise<T & { stolen: number }> {
    const [stolen, all] = ticks();
    const result = await work();
    const [stolenNow, allNow] = ticks();
    return { ...result, stolen: allNow > all ? (stolenNow - stolen) / (allNow - all) : 0 };
}

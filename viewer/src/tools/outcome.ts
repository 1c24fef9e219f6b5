// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Outcomes of commands in a user's words, with the position of the bone that stopped a tool. They
// are shown at the tool and go away by themselves.

import { norm, sub, type Vec3 } from '../maths/vec.ts';
import type { Answer, Done, Refusal } from '../net/protocol.ts';
import { nameOfClient } from '../state/company.ts';
import type { Outcome, State } from '../state/state.ts';
import { lengthText } from '../state/units.ts';
import type { Store } from '../state/store.ts';

const kShowMs = 2500;

/// Position and direction of a tool when a command was sent.
export interface Motion {
    readonly from: Vec3;
    readonly by: Vec3;
    readonly radius: number;
}

/// Outcome of a command; null: it went as wished.
export function outcomeOf(
    done: Done,
    state: State,
    motion: Motion | undefined,
): Outcome | null {
    const place = motion?.from ?? state.sections.cursor;
    const plain = (text: string): Outcome => ({ text, place, obstacle: null, isStopped: false });
    if (done.cut_links !== undefined)
        return plain(done.cut_links ? `cut: ${done.cut_links} links` : 'no tissue here');
    // A sphere that touches nothing moves freely.
    if (done.grabbed_elements === 0 && done.limited_by !== 'bone')
        return done.do === 'grab' ? plain('no tissue here') : null;
    if (done.status === undefined || done.status === 'applied') return null;
    const stopped = (text: string, obstacle: Vec3 | null = null): Outcome => ({
        text,
        place,
        obstacle,
        isStopped: true,
    });
    switch (done.limited_by) {
        case 'bone': {
            if (!done.bone) return stopped('stopped by bone');
            const gap = Math.max(norm(sub(done.bone, place)) - (motion?.radius ?? 0), 0);
            const far = lengthText(state.scan.volume, gap, 1);
            return stopped(`stopped by bone, ${far} mm away`, done.bone);
        }
        case 'movement':
            return stopped('stopped: this tissue gives no more');
        case 'wall':
            return stopped('stopped by the wall');
        case 'fold':
            return stopped('stopped: the tissue would fold');
        default:
            return stopped(done.message || 'stopped');
    }
}

/// A refusal in words for a person; empty: there is nothing to say.
export function wordsOf(refusal: Refusal, state: State): string {
    switch (refusal.code) {
        case 'nothing':
        case 'not_holding': // it was let go meanwhile
            return '';
        case 'held_by_other':
            if (refusal.do === 'haptics') return 'the device is held by somebody else';
            return `${nameOfClient(state.shared, state.shared?.holder ?? 0)} holds the tissue`;
        case 'no_tissue':
            return 'no tissue here';
        default:
            return refusal.message;
    }
}

export class Outcomes {
    private fading = 0;

    constructor(private readonly store: Store) {}

    /// Shows the outcome of a command; one that went as wished takes the last away.
    take(answer: Answer | undefined, motion?: Motion): void {
        if (answer?.t !== 'done') return;
        this.show(outcomeOf(answer, this.store.state, motion));
    }

    show(outcome: Outcome | null): void {
        clearTimeout(this.fading);
        this.store.set({ tool: { outcome } });
        if (outcome) this.fading = setTimeout(() => this.show(null), kShowMs) as unknown as number;
    }
}

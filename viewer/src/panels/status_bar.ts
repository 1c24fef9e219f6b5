// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Status bar: value under the pointer, messages, times, connection.

import { quantile } from '../net/latencies.ts';
import type { LinkStatus } from '../state/state.ts';
import type { Session } from '../tools/session.ts';
import { h } from './dom.ts';
import { pointerText } from './overlay.ts';

const kShowMs = 6000; // of a message
const kTimesMs = 400; // between two updates of the times

/// Shows messages, each for some seconds; screen readers read them.
export class MessageLine {
    readonly element = h('span', { class: 'message', role: 'status', 'aria-live': 'polite' });
    private fading = 0;

    say(text: string, isWarning = false): void {
        this.element.classList.toggle('warning', isWarning);
        this.element.textContent = text;
        clearTimeout(this.fading);
        this.fading = window.setTimeout(() => {
            this.element.textContent = '';
        }, kShowMs);
    }
}

export class StatusBar {
    readonly pointer = h('span', { class: 'pointer', id: 'pointer' });
    readonly times = h('span', { class: 'times', id: 'times' });
    readonly link = h('span', { class: 'link', id: 'link' });
    readonly element: HTMLElement;
    private lastTimes = 0;

    constructor(
        private readonly session: Session,
        message: MessageLine,
    ) {
        this.element = h('footer', {}, this.pointer, message.element, this.times, this.link);
        session.store.watch(
            ({ link, shared, replay }) => [link, shared, replay.isOn],
            (link, shared, isWatched) => {
                const { status, role, silent } = link;
                const people = shared?.clients.length ?? 0;
                const company = people > 1 ? `, ${people} in this session` : '';
                const isLost = status === 'open' && shared?.recorded === false;
                const unrecorded = isLost ? ', NOT RECORDED' : '';
                this.link.title = isLost
                    ? "The session's file can't be written: is there room on the server's disk?"
                    : '';
                const viewing = isWatched ? 'watching a recording' : 'viewing';
                const texts: Record<LinkStatus, string> = {
                    connecting: 'connecting…',
                    open: `${role === 'view' ? viewing : 'connected'}${company}${unrecorded}`,
                    lost: 'connecting again…',
                    ended: 'not connected',
                    refused: 'not connected',
                };
                this.link.textContent = silent ? 'no answer' : texts[status];
                this.link.dataset.link = isLost || silent ? 'lost' : status;
            },
        );
    }

    /// Updates the value under the pointer and the times, once per frame.
    refresh(now: number): void {
        const text = pointerText(this.session);
        if (this.pointer.textContent !== text) this.pointer.textContent = text;
        const { display, shared, overlay, hands } = this.session.store.state;
        this.times.hidden = !display.timings;
        if (!display.timings || now - this.lastTimes < kTimesMs) return;
        this.lastTimes = now;
        const { latencies, stage } = this.session;
        const timing = shared?.timing;
        const ms = (v: number | undefined): string => (v === undefined ? '–' : v.toFixed(1));
        const both = (list: readonly number[]): string =>
            `${ms(quantile(list, 0.5))}, ${ms(quantile(list, 0.99))}`;
        this.times.textContent = [
            `frame ${ms(stage.frameMs || undefined)} ms`,
            `solve ${ms(timing?.solve_ms)}`,
            `resample ${ms(timing?.resample_ms)}`,
            ...(overlay.kind === 'none' ? [] : [`overlay ${ms(timing?.overlay_ms)}`]),
            ...(hands.energy_per_mm ? [`energy ${hands.energy_per_mm.toFixed(1)} per mm`] : []),
            `${(timing?.moved_elements ?? 0).toLocaleString('en')} moved`,
            `to voxels p50, p99: ${both(latencies.arrivedMs)}`,
            `to picture: ${both(latencies.drawnMs)}`,
        ].join(' · ');
    }
}

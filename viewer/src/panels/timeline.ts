// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Time line of a recorded session, below the views. Clients that only view see it without control.

import type { ReplayMark } from '../net/company.ts';
import { nameOfClient } from '../state/company.ts';
import type { Session } from '../tools/session.ts';
import { button, h, svg } from './dom.ts';

const kSpeeds = [0.25, 0.5, 1, 2, 4, 8, 16];
const kMaxTicks = 400; // marks that are closer together share a tick

// Drawn, since fonts lack some of these signs or show them as emoji.
const kIcons = {
    play: 'M4 2l10 6-10 6z',
    pause: 'M3 2h4v12H3zM9 2h4v12H9z',
    before: 'M2 2h2v12H2zM14 2v12L5 8z',
    after: 'M12 2h2v12h-2zM2 2l9 6-9 6z',
} as const;

function setIcon(element: HTMLElement, name: keyof typeof kIcons): void {
    if (element.dataset.icon === name) return;
    element.dataset.icon = name;
    const icon = svg('svg', { viewBox: '0 0 16 16', width: 14, height: 14, 'aria-hidden': 'true' });
    icon.append(svg('path', { d: kIcons[name], fill: 'currentColor' }));
    element.replaceChildren(icon);
}

/// Time as m:ss.
export function timeText(ms: number): string {
    const seconds = Math.floor(ms / 1000);
    return `${Math.floor(seconds / 60)}:${String(seconds % 60).padStart(2, '0')}`;
}

/// Ticks of marks: their times and titles.
export function ticksOf(
    marks: readonly ReplayMark[],
    length: number,
    nameOf: (client: number) => string,
): { at: number; title: string }[] {
    const ticks: { at: number; title: string; more: number }[] = [];
    for (const { at_ms, client, do: command } of marks) {
        const last = ticks[ticks.length - 1];
        if (last && at_ms - last.at < length / kMaxTicks) ++last.more;
        else {
            const title = `${timeText(at_ms)} ${command.replaceAll('_', ' ')}, ${nameOf(client)}`;
            ticks.push({ at: at_ms, title, more: 0 });
        }
    }
    return ticks.map(({ at, title, more }) => ({
        at,
        title: more ? `${title}, and ${more} more` : title,
    }));
}

export class Timeline {
    private readonly play = button('', () => this.session.replay.toggle());
    private readonly before = button(
        '',
        () => this.session.replay.step(-1),
        'previous command (,)',
    );
    private readonly after = button('', () => this.session.replay.step(1), 'next command (.)');
    private readonly range = h('input', {
        type: 'range',
        min: '0',
        step: '1',
        'aria-label': 'Time of the session',
        oninput: () => this.session.replay.jump(Number(this.range.value)),
        onkeydown: (event) => {
            if ((event as KeyboardEvent).code !== 'Space') return;
            this.session.replay.toggle(); // as elsewhere: a slider needs no Space
            event.preventDefault();
        },
    });
    private readonly ticks = h('div', { class: 'ticks', 'aria-hidden': 'true' });
    private readonly time = h('span', { class: 'time' });
    private readonly speed = h(
        'select',
        {
            'aria-label': 'Speed',
            title: 'speed',
            onchange: () => this.session.replay.setSpeed(Number(this.speed.value)),
        },
        ...kSpeeds.map((speed) => h('option', { value: String(speed) }, `${speed}×`)),
    );
    private readonly news = h('span', { class: 'news', role: 'status' });
    readonly element = h(
        'section',
        { class: 'timeline', 'aria-label': 'Recorded session', hidden: true },
        this.before,
        this.play,
        this.after,
        h('div', { class: 'track' }, this.ticks, this.range),
        this.time,
        this.speed,
        this.news,
    );

    constructor(private readonly session: Session) {
        this.before.setAttribute('aria-label', 'Previous command');
        this.after.setAttribute('aria-label', 'Next command');
        this.play.classList.add('play');
        setIcon(this.before, 'before');
        setIcon(this.after, 'after');
        const { store } = session;
        store.watch(
            ({ replay, link }) => [replay, link.status],
            (replay, status) => {
                this.element.hidden = !replay.isOn;
                const idle = !replay.controls || status !== 'open';
                for (const part of [this.before, this.play, this.after, this.range, this.speed])
                    part.disabled = idle;
                this.showTime();
            },
        );
        store.watch(
            ({ replay, shared }) => [replay.marks, replay.length, shared?.clients],
            () => this.showTicks(),
        );
    }

    private showTime(): void {
        const { at, length, speed, playing, seeking, failure, controls } =
            this.session.store.state.replay;
        const label = playing ? 'Pause' : 'Play';
        setIcon(this.play, playing ? 'pause' : 'play');
        this.play.setAttribute('aria-label', label);
        this.play.title = `${label.toLowerCase()} (Space)`;
        this.range.max = String(length);
        this.range.value = String(at);
        const time = `${timeText(at)} of ${timeText(length)}`;
        this.range.setAttribute('aria-valuetext', time);
        if (this.time.textContent !== time) this.time.textContent = time;
        if (document.activeElement !== this.speed) this.speed.value = String(speed);
        const waits = seeking ? 'seeking…' : controls ? '' : 'shown by others';
        const news = failure ? `the session ends here: ${failure}` : waits;
        this.news.classList.toggle('failure', failure !== '');
        if (this.news.textContent !== news) this.news.textContent = news;
    }

    private showTicks(): void {
        const { replay, shared } = this.session.store.state;
        const nameOf = (client: number): string => nameOfClient(shared, client);
        this.ticks.replaceChildren(
            ...ticksOf(replay.marks, replay.length, nameOf).map(({ at, title }) => {
                const tick = h('i', { title, onclick: () => this.session.replay.jump(at) });
                tick.style.left = `${(100 * at) / Math.max(replay.length, 1)}%`;
                return tick;
            }),
        );
    }
}

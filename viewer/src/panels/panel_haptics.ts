// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of devices with force feedback: choice of the device, workspace scale, force, timing of the
// servo, and a large stop button.

import type { HapticsNews, VolumeInfo } from '../net/protocol.ts';
import type { Link } from '../state/state.ts';
import { lengthText } from '../state/units.ts';
import { type Felt, kPlotSeconds } from '../tools/haptics.ts';
import { button, checkbox, h, slider } from './dom.ts';
import { type Parts, section, tissue } from './panel_parts.ts';

const kWidth = 240; // of the plot [pixels]
const kHeight = 72;
const kSpeakMs = 1000; // between two updates of the plot's label

const newtons = (n: number): string => `${n.toFixed(2)} N`;

/// Round number at or above the largest force, for the plot's axis.
export function plotTop(largest: number): number {
    return [0.1, 0.2, 0.5, 1, 2, 5, 10].find((top) => largest <= top) ?? Math.ceil(largest);
}

const deviceTitle = (name: string): string =>
    name === 'browser' ? 'mouse or game pad' : name.replace(/^virtual:/, 'simulated: ');

export function feltText(
    news: HapticsNews | null,
    felt: readonly Felt[],
    scan: VolumeInfo | null = null,
): string {
    if (!news) return 'no device';
    const now = news.lost ? 0 : Math.hypot(...news.force_n!);
    const most = Math.max(0, ...felt.map((f) => f.newtons));
    const depth = lengthText(scan, news.depth_mm ?? 0);
    const contact = news.lost
        ? 'the device can’t be read'
        : news.stopped
          ? 'stopped'
          : news.holds
            ? `holds the catheter, ${depth} mm ahead of it`
            : news.contact
              ? `${depth} mm deep`
              : 'free';
    return `${newtons(now)} now, ${newtons(most)} at most in ${kPlotSeconds} s; ${contact}`;
}

export function servoRows(news: HapticsNews): [string, string][] {
    const s = news.servo!;
    return [
        ['rate', `${s.rate_hz} Hz`],
        ['period, 99 %', `${(s.period_p99_us / 1000).toFixed(2)} ms`],
        ['period, longest', `${(s.period_max_us / 1000).toFixed(1)} ms`],
        ['above 1.5 ms', `${s.misses_per_million} per million`],
        ['computing, 99 %', `${s.compute_p99_us.toFixed(1)} µs`],
        ['age of the model', `${s.age_ms.toFixed(0)} ms`],
    ];
}

function draw(canvas: HTMLCanvasElement, felt: readonly Felt[], now: number): void {
    const ratio = window.devicePixelRatio || 1;
    if (canvas.width !== kWidth * ratio) {
        canvas.width = kWidth * ratio;
        canvas.height = kHeight * ratio;
    }
    const context = canvas.getContext('2d')!;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, kWidth, kHeight);
    const style = getComputedStyle(canvas);
    const top = plotTop(Math.max(0, ...felt.map((f) => f.newtons)));
    const y = (n: number): number => kHeight - 3 - ((kHeight - 16) * n) / top;
    context.strokeStyle = context.fillStyle = style.color;
    context.globalAlpha = 0.35;
    context.beginPath();
    for (const share of [0, 0.5, 1]) {
        context.moveTo(0, y(share * top));
        context.lineTo(kWidth, y(share * top));
    }
    context.stroke();
    context.globalAlpha = 0.8;
    context.font = '10px sans-serif';
    context.fillText(`${top} N`, 2, y(top) - 2);
    context.globalAlpha = 1;
    context.strokeStyle = style.accentColor === 'auto' ? style.color : style.accentColor;
    context.lineWidth = 1.5;
    context.beginPath();
    for (const f of felt)
        context.lineTo(kWidth * (1 - (now - f.at) / (1000 * kPlotSeconds)), y(f.newtons));
    context.stroke();
}

export function hapticsPanel(parts: Parts): HTMLElement {
    const { session } = parts;
    const { device: haptics, store } = session;
    const picker = h('select', {
        'aria-label': 'Device',
        onchange: () => {
            haptics.device = picker.value;
            refresh();
        },
    });
    const start = button(
        'Start',
        () => void haptics.start(),
        'places the middle of the workspace at the endoscope’s tip',
    );
    const end = button('End', () => haptics.end(), 'closes the device');
    const puck = button(
        'SpaceMouse…',
        () => void haptics.openSpaceMouse(),
        'lets the browser use a SpaceMouse (WebHID); game pads are found by themselves',
    );
    const stop = button('Stop', () => haptics.toggleStop());
    stop.className = 'stop';
    const plot = h('canvas', { class: 'force', role: 'img', 'aria-label': 'Force' });
    const text = h('p', { class: 'felt' });
    const servo = h('dl', { class: 'servo' });
    const note = h('small', { class: 'quiet' });
    const element = section(
        'Device',
        false,
        tissue(
            h('label', { class: 'field' }, 'Device', picker),
            parts.add(
                slider({
                    label: 'Workspace scale',
                    unit: '×',
                    low: 0.05,
                    high: 5,
                    step: 0.05,
                    curved: true,
                    hint: 'motion in the scene over motion of the device; from the next start on',
                    value: () => haptics.scale,
                    input: (value) => {
                        haptics.scale = Math.min(Math.max(value, 0.05), 20);
                    },
                }),
            ),
            parts.add(
                checkbox(
                    'Endoscope follows the tool',
                    () => haptics.follows,
                    (on) => {
                        haptics.follows = on;
                    },
                    'the device holds the endoscope instead of a tool',
                ),
            ),
            h('div', { class: 'row' }, start, end, puck),
            stop,
        ),
        plot,
        text,
        servo,
        note,
    );
    let spoken = 0;
    let shown = '';
    const refresh = (): void => {
        const { news } = store.state.device;
        const { role, status } = store.state.link;
        start.textContent = haptics.isOwn ? 'Start again' : 'Start';
        start.disabled = news !== null && !haptics.isOwn;
        end.disabled = !news;
        puck.hidden = (haptics.device || picker.value) !== 'browser';
        stop.disabled = !news || role === 'view' || status !== 'open';
        const back = news?.stopped && haptics.isOwn;
        stop.textContent = back ? 'Go on' : 'Stop';
        stop.title = `${back ? 'resumes the force' : 'ends all force at once'} (H)`;
        note.textContent = news?.note ?? '';
        const said = feltText(news, haptics.felt, store.state.scan.volume);
        if (text.textContent !== said) text.textContent = said;
        const now = performance.now();
        if (!(element as HTMLDetailsElement).open) return;
        const rows = news ? servoRows(news) : [];
        const numbers = JSON.stringify(rows);
        if (numbers !== shown)
            servo.replaceChildren(
                ...rows.flatMap(([name, value]) => [h('dt', {}, name), h('dd', {}, value)]),
            );
        shown = numbers;
        draw(plot, haptics.felt, now);
        if (now - spoken < kSpeakMs) return;
        spoken = now;
        plot.setAttribute('aria-label', `Force over the last ${kPlotSeconds} s: ${said}`);
    };
    const offer = (offered: readonly string[], { status, features }: Link): void => {
        element.hidden = status === 'open' && !features.includes('haptics');
        picker.replaceChildren(
            ...offered.map((name) =>
                h('option', { value: name }, deviceTitle(name)),
            ),
        );
        if (haptics.device) picker.value = haptics.device;
    };
    store.watch(
        ({ device, link }) => [device.offered, link],
        (offered, link) => offer(offered, link),
    );
    store.watch(({ device, link }) => [device, link], refresh);
    element.addEventListener('toggle', refresh);
    return element;
}

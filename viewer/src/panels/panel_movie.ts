// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panel of movies: the list of keyframes, each with its time since the previous one.

import { lengthOf } from '../maths/keyframes.ts';
import { button, h } from './dom.ts';
import { type Parts, section } from './panel_parts.ts';

export function moviePanel(parts: Parts): HTMLElement {
    const { session, actions } = parts;
    const { movie, store } = session;
    const list = h('ol', { class: 'keyframes', 'aria-label': 'Keyframes' });
    const total = h('span', { class: 'hint' });
    const play = button(
        'Play',
        () => movie.play(),
        'plays from the first keyframe, or stops (Shift+K)',
    );
    const record = button(
        'Record',
        () => movie.record(),
        'plays the movie and saves the pictures of the views',
    );
    const save = button('Save', () => movie.saveFile(), 'saves the keyframes');
    store.watch(
        ({ movie: { keyframes } }) => [keyframes],
        (keyframes) => {
            list.replaceChildren(...keyframes.map((_, i) => line(parts, i)));
            total.textContent = keyframes.length
                ? `${keyframes.length} keyframes, ${lengthOf(keyframes).toFixed(1)} s`
                : 'fly to a place and press Add; repeat; then Play';
            play.disabled = record.disabled = keyframes.length < 2;
            save.disabled = !keyframes.length;
        },
    );
    store.watch(
        ({ movie: { playing } }) => [playing],
        (playing) => {
            play.setAttribute('aria-pressed', String(playing));
            record.setAttribute('aria-pressed', String(playing && movie.isRecording));
        },
    );
    const file = h('input', {
        type: 'file',
        accept: '.json',
        hidden: true,
        'aria-label': 'keyframes file',
        onchange: () => {
            const chosen = file.files?.[0];
            if (chosen) void actions.openFile(chosen);
            file.value = '';
        },
    });
    return section(
        'Movie',
        false,
        h(
            'div',
            { class: 'row' },
            button('Add', () => movie.add(), 'adds the present view as a keyframe (K)'),
            play,
            record,
        ),
        total,
        list,
        h(
            'div',
            { class: 'row' },
            save,
            button('Load…', () => file.click()),
            file,
        ),
    );
}

function line(parts: Parts, at: number): HTMLElement {
    const { movie } = parts.session;
    const frames = parts.state.movie.keyframes;
    const seconds = h('input', {
        type: 'number',
        min: '0.5',
        max: '600',
        step: '0.5',
        value: String(frames[at]!.seconds),
        'aria-label': `seconds to keyframe ${at + 1}`,
        onchange: () => movie.setSeconds(at, Number(seconds.value)),
    });
    const up = button('↑', () => movie.move(at, -1), 'earlier');
    const down = button('↓', () => movie.move(at, 1), 'later');
    up.disabled = at === 0;
    down.disabled = at === frames.length - 1;
    const name = button(`${at + 1}`, () => movie.goTo(at), 'go there');
    name.setAttribute('aria-label', `go to keyframe ${at + 1}`);
    return h(
        'li',
        { class: 'row' },
        name,
        at === 0 ? h('span', {}, 'start') : seconds,
        at > 0 && h('span', {}, 's'),
        up,
        down,
        button('×', () => movie.remove(at), 'delete'),
    );
}

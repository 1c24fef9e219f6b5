// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// On-screen stick in the endoscope's view, for fingers: up and down fly ahead and back, sideways
// turns. With the tool Catheter it inserts and rotates. Shown on touch screens.

import type { Session } from '../tools/session.ts';
import { h } from './dom.ts';

const kReach = 34; // motion of the knob at full speed [pixels]
const kDead = 0.12; // share of it without an effect

const strength = (x: number): number => {
    const beyond = (Math.abs(x) - kDead) / (1 - kDead);
    return beyond > 0 ? Math.sign(x) * Math.min(beyond, 1) : 0;
};

export function stick(session: Session): HTMLElement {
    const knob = h('i');
    const element = h('div', { class: 'stick', 'aria-hidden': 'true' }, knob);
    let finger: number | undefined;
    const put = (x: number, y: number): void => {
        knob.style.transform = `translate(${x}px, ${y}px)`;
        session.stick.ahead = strength(-y / kReach);
        session.stick.right = strength(x / kReach);
    };
    const move = (event: PointerEvent): void => {
        const box = element.getBoundingClientRect();
        const x = event.clientX - box.left - box.width / 2;
        const y = event.clientY - box.top - box.height / 2;
        const shrink = Math.min(1, kReach / Math.max(Math.hypot(x, y), 1e-6));
        put(x * shrink, y * shrink);
    };
    const end = (event: PointerEvent): void => {
        if (event.pointerId !== finger) return;
        finger = undefined;
        put(0, 0);
    };
    element.addEventListener('pointerdown', (event) => {
        event.stopPropagation();
        if (finger !== undefined) return;
        finger = event.pointerId;
        element.setPointerCapture(event.pointerId);
        session.store.set({ pointer: { active: 'endoscope' } });
        move(event);
    });
    element.addEventListener('pointermove', (event) => {
        event.stopPropagation();
        if (event.pointerId === finger) move(event);
    });
    element.addEventListener('pointerup', end);
    element.addEventListener('pointercancel', end);
    // A finger anywhere shows it, also where a mouse is the main pointer.
    window.addEventListener(
        'pointerdown',
        ({ pointerType }) => {
            if (pointerType === 'touch') document.body.classList.add('touched');
        },
        { capture: true },
    );
    session.store.watch(
        ({ view, tool }) => [view.outside, tool.name],
        (outside, name) => {
            element.hidden = outside && name !== 'catheter';
        },
    );
    return element;
}

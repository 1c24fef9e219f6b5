// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Tour at the first start: flying, pushing, the threshold, undo. Each step waits until the user has
// done it or presses Next.

import type { State } from '../state/state.ts';
import type { Session } from '../tools/session.ts';
import { button, h } from './dom.ts';

interface Step {
    readonly title: string;
    readonly text: string;
    readonly done: (now: State, then: State) => boolean;
}

const kSteps: readonly Step[] = [
    {
        title: 'Look and fly',
        text:
            'Top left is the endoscope. Drag in it to look around, hold W to fly ahead, S ' +
            'to fly back, or use the stick on a touch screen. The tip stops at walls.',
        done: (now, then) => now.view.camera.eye !== then.view.camera.eye,
    },
    {
        title: 'Push',
        text:
            'Choose Push above and hold a wall in the endoscope: the probe goes into it. Or ' +
            'drag in any view. All four views follow the probe and show the deformed scan.',
        done: (now, then) => (now.shared?.step ?? 0) > (then.shared?.step ?? 0),
    },
    {
        title: 'Threshold',
        text:
            'Move the Threshold slider on the right: it separates lumen and wall. ' +
            'Nothing is segmented, so any value is possible.',
        done: (now, then) => now.shared?.iso_hu !== then.shared?.iso_hu,
    },
    {
        title: 'Undo',
        text:
            'Ctrl+Z undoes everything: pushes, the threshold, the window, the flight. ' +
            'The key ? shows all keys.',
        done: (now, then) =>
            (now.shared?.redo.steps ?? 0) > (then.shared?.redo.steps ?? 0) ||
            now.view.camera !== then.view.camera,
    },
];

export class Tour {
    readonly element = h('div', {
        class: 'tour',
        role: 'dialog',
        'aria-label': 'Tour',
        hidden: true,
    });
    private index = 0;
    private then: State | undefined;

    constructor(
        private readonly session: Session,
        private readonly onEnd: () => void,
    ) {
        session.store.listen((state) => {
            if (!this.then) return;
            if (kSteps[this.index]!.done(state, this.then)) {
                this.then = undefined;
                setTimeout(() => this.show(this.index + 1), 1200);
            }
        });
    }

    start(): void {
        this.show(0);
    }

    stop(): void {
        this.then = undefined;
        this.element.hidden = true;
        this.onEnd();
    }

    private show(index: number): void {
        const step = kSteps[index];
        if (!step || (index > 0 && this.element.hidden)) {
            this.stop();
            return;
        }
        this.index = index;
        this.then = this.session.store.state;
        this.element.hidden = false;
        const last = index + 1 === kSteps.length;
        this.element.replaceChildren(
            h('strong', {}, `${index + 1} of ${kSteps.length}: ${step.title}`),
            h('p', {}, step.text),
            h(
                'div',
                { class: 'row' },
                button(last ? 'Done' : 'Next', () => this.show(index + 1)),
                !last && button('Skip the tour', () => this.stop()),
            ),
        );
    }
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Keyboard: bindings of keys, and the help for keys and mouse. Keys that are held (flight) are
// polled each frame (steering.ts).

import { roundTo } from '../maths/steps.ts';
import { kTools, type SectionName, type State, type ToolName } from '../state/state.ts';
import { roundLength, valueScale, valueStep } from '../state/units.ts';
import type { Actions } from './actions.ts';
import { keysDrive } from './catheter_hand.ts';
import type { Session } from './session.ts';
import { inEndoscope, isFlightKey } from './steering.ts';

const kIsoStep = 25; // [HU]

interface Binding {
    readonly code: string; ///< of KeyboardEvent: position on the keyboard
    readonly ctrl?: boolean;
    readonly shift?: boolean; ///< absent: either
    readonly alt?: boolean;
    readonly when?: (state: State) => boolean;
    readonly run: () => void;
}

export interface HelpLine {
    readonly keys: string;
    readonly text: string;
}

const watches = ({ replay }: State): boolean => replay.isOn;
const isOfSprings = ({ shared }: State): boolean => shared?.tissue?.model === 'springs';
const inSection = (state: State): boolean => !inEndoscope(state);

export const kHelp: readonly { title: string; lines: readonly HelpLine[] }[] = [
    {
        title: 'Endoscope',
        lines: [
            { keys: 'W S', text: 'forward, back' },
            { keys: 'A D, R F', text: 'left and right, up and down' },
            { keys: 'Arrows, left drag', text: 'look around' },
            { keys: 'Q E', text: 'roll' },
            { keys: 'Space', text: 'stop' },
            { keys: 'Wheel', text: 'forward and back in steps' },
            { keys: 'Ctrl+Wheel, right drag', text: 'field of view' },
            { keys: 'C', text: 'at walls: stop, push, pass' },
            { keys: 'J, Ctrl+double click', text: 'the endoscope comes to the crosshair; here' },
            { keys: 'O', text: 'view from outside, cut open at the tip' },
            { keys: 'Shift+O', text: 'volume rendering of the scan, from outside' },
            { keys: 'B, Shift+B', text: 'fluoroscopy: X-rays through the scan; in two planes' },
            { keys: '7, two clicks', text: 'a path through the lumen between two points' },
            { keys: 'N', text: 'fly along the path, or pause' },
            { keys: 'K, Shift+K', text: 'add a keyframe; play the movie, or stop' },
            {
                keys: 'Keypad 1, 3, 7',
                text: 'outside: front, right, top; with Ctrl from the other side',
            },
        ],
    },
    {
        title: 'Sections',
        lines: [
            { keys: 'Wheel, Up Down', text: 'one slice' },
            { keys: 'PgUp PgDn', text: 'ten slices' },
            { keys: 'Click, Shift+move', text: 'crosshair in all views' },
            { keys: 'W+left drag', text: 'window (sideways) and level (up and down)' },
            { keys: 'Shift+Wheel', text: 'window' },
            { keys: 'U', text: 'slab (10 mm of a body): maximum, minimum, mean; a plane again' },
            { keys: 'Middle drag', text: 'pan' },
            { keys: 'Right drag, Ctrl+Wheel', text: 'zoom' },
            { keys: 'Home', text: 'show all' },
        ],
    },
    {
        title: 'Tools',
        lines: [
            {
                keys: '1 … 9',
                text: 'look, window, push, grab, cut, carve, path, catheter, measure',
            },
            { keys: 'Left drag', text: 'use the tool; the wheel moves it deeper' },
            { keys: 'Hold still', text: 'Push: into the wall, as long as the button is held' },
            { keys: '9, clicks', text: 'point, ruler or angle; drag a point to move it' },
            { keys: 'Enter', text: 'use the tool at the crosshair' },
            {
                keys: 'Alt+Arrows',
                text: 'push or drag the tissue at the crosshair (1 mm in a body)',
            },
            { keys: '[ ]', text: 'smaller, larger' },
            { keys: 'X', text: 'tissue springs back by itself, or stays' },
            { keys: 'Shift+X', text: 'springs: find the depth of forces for the held tissue' },
            { keys: 'L', text: 'release the tissue' },
            { keys: ', .', text: 'threshold lower, higher' },
            { keys: 'H', text: 'stop the device’s force; again: resume' },
            {
                keys: 'Left drag in the endoscope',
                text: 'moves the device that the mouse simulates; the wheel: forward, back',
            },
            { keys: 'Ctrl+Z, Ctrl+Shift+Z', text: 'undo, redo: tissue, threshold, window, camera' },
        ],
    },
    {
        title: 'Catheter, in the scene of a vessel',
        lines: [
            { keys: '8, then Up Down', text: 'insert, withdraw while held; or the left stick' },
            { keys: 'Left Right', text: 'rotate' },
            { keys: 'Shift+Arrows', text: 'bend the tip; or the right stick' },
            { keys: 'Space', text: 'stop' },
            { keys: 'I', text: 'the endoscope rides on the tip, until another motion of it' },
        ],
    },
    {
        title: 'Page',
        lines: [
            { keys: 'Space; , .', text: 'recorded session: play, pause; previous, next command' },
            { keys: 'Double click, V', text: 'maximise a view; the next one' },
            { keys: 'G', text: 'coordinates in LPS or RAS' },
            { keys: 'M', text: 'colours: displacement, volume change, none' },
            { keys: 'T', text: 'frame, solve and resample times' },
            { keys: 'Ctrl+O, Ctrl+S', text: 'open a scan; save the deformed volume' },
            { keys: 'P', text: 'save a picture' },
            { keys: 'Tab, F6', text: 'next control; next view' },
            { keys: 'Esc', text: 'cancel; close; all four views' },
            { keys: '?', text: 'this table' },
        ],
    },
    {
        title: 'Fingers',
        lines: [
            { keys: 'One', text: 'the tool; with Look: slices, or look around' },
            { keys: 'Two', text: 'zoom and pan' },
            { keys: 'Tap', text: 'crosshair' },
            { keys: 'Stick', text: 'fly and turn, or drive the catheter' },
        ],
    },
];

/// Controls for typing.
const kTyping = 'input:not([type=range], [type=checkbox], [type=radio], [type=file]), textarea';

export class Keymap {
    private readonly bindings: Binding[];

    constructor(
        private readonly session: Session,
        actions: Actions,
        private readonly held: Set<string>,
        hooks: {
            help: () => void;
            cancel: () => void;
            nextView: () => void;
            open: () => void;
            save: () => void;
            stop: () => void;
        },
    ) {
        const { store, history } = session;
        const scroll = (slices: number) => (): void =>
            actions.scroll(store.state.pointer.active as SectionName, slices);
        const nudge = (x: number, y: number) => (): void => {
            const mm = roundLength(store.state.scan.volume, 1);
            void actions.nudge([mm * x, mm * y]);
        };
        const tool = (name: ToolName) => (): void => actions.choose(name);
        const radius = (factor: number): void => {
            const { scan, tool: now } = store.state;
            const [least, most] = [0.1, 30].map((mm) => roundLength(scan.volume, mm)) as [
                number,
                number,
            ];
            store.set({ tool: { radius: Math.min(Math.max(now.radius * factor, least), most) } });
        };
        const { threshold, movie } = session;
        const iso = (direction: number) => (): void => {
            const { volume } = store.state.scan;
            const step = roundTo(kIsoStep * valueScale(volume), valueStep(volume));
            threshold.ask({ iso_hu: threshold.wanted + direction * step });
        };
        const toggleSpace = (): void => {
            const { space } = store.state.display;
            store.set({ display: { space: space === 'LPS' ? 'RAS' : 'LPS' } });
        };
        const toggleTimings = (): void =>
            store.set({ display: { timings: !store.state.display.timings } });
        this.bindings = [
            { code: 'KeyZ', ctrl: true, shift: false, run: () => void history.undo() },
            { code: 'KeyZ', ctrl: true, shift: true, run: () => void history.redo() },
            { code: 'KeyY', ctrl: true, run: () => void history.redo() },
            { code: 'KeyO', ctrl: true, run: hooks.open },
            { code: 'KeyS', ctrl: true, run: hooks.save },
            { code: 'ArrowUp', alt: true, run: nudge(0, 1) },
            { code: 'ArrowDown', alt: true, run: nudge(0, -1) },
            { code: 'ArrowLeft', alt: true, run: nudge(-1, 0) },
            { code: 'ArrowRight', alt: true, run: nudge(1, 0) },
            { code: 'ArrowUp', when: inSection, run: scroll(1) },
            { code: 'ArrowDown', when: inSection, run: scroll(-1) },
            { code: 'PageUp', when: inSection, run: scroll(10) },
            { code: 'PageDown', when: inSection, run: scroll(-10) },
            { code: 'Home', run: () => actions.fit() },
            {
                code: 'Space',
                when: keysDrive,
                run: () => {
                    this.stop();
                    hooks.stop();
                },
            },
            { code: 'Space', when: watches, run: () => session.replay.toggle() },
            { code: 'Space', when: inEndoscope, run: () => this.stop() },
            { code: 'KeyV', run: () => actions.cycleViews() },
            { code: 'KeyO', shift: true, run: () => actions.toggleBlended() },
            { code: 'KeyO', run: () => actions.toggleOutside() },
            { code: 'KeyU', run: () => actions.cycleSlab() },
            { code: 'KeyB', shift: true, run: () => actions.toggleBiplane() },
            { code: 'KeyB', run: () => actions.toggleFluoroscopy() },
            { code: 'KeyI', run: () => session.ride.toggle() },
            { code: 'KeyJ', run: () => actions.endoscopeTo(store.state.sections.cursor) },
            { code: 'KeyC', run: () => actions.cycleWall() },
            { code: 'KeyX', shift: true, when: isOfSprings, run: () => void session.findDepth() },
            { code: 'KeyX', run: () => actions.relax() },
            { code: 'KeyL', run: () => void session.ask({ do: 'release' }) },
            { code: 'KeyG', run: toggleSpace },
            { code: 'KeyT', run: toggleTimings },
            { code: 'KeyH', run: () => session.device.toggleStop() },
            { code: 'KeyM', run: () => actions.cycleOverlay() },
            { code: 'KeyP', run: () => void actions.snapshot() },
            { code: 'KeyK', shift: false, run: () => movie.add() },
            { code: 'KeyK', shift: true, run: () => movie.play() },
            { code: 'KeyN', run: () => session.path.toggle() },
            { code: 'BracketLeft', run: () => radius(1 / 1.25) },
            { code: 'BracketRight', run: () => radius(1.25) },
            { code: 'Comma', when: watches, run: () => session.replay.step(-1) },
            { code: 'Period', when: watches, run: () => session.replay.step(1) },
            { code: 'Comma', run: iso(-1) },
            { code: 'Period', run: iso(1) },
            { code: 'Enter', run: () => void actions.applyAtCursor() },
            { code: 'F6', run: hooks.nextView },
            { code: 'Escape', run: hooks.cancel },
            { code: 'Numpad1', run: () => actions.standardView([0, 1, 0], [0, 0, 1]) },
            { code: 'Numpad1', ctrl: true, run: () => actions.standardView([0, -1, 0], [0, 0, 1]) },
            { code: 'Numpad3', run: () => actions.standardView([1, 0, 0], [0, 0, 1]) },
            { code: 'Numpad3', ctrl: true, run: () => actions.standardView([-1, 0, 0], [0, 0, 1]) },
            { code: 'Numpad7', run: () => actions.standardView([0, 0, -1], [0, -1, 0]) },
            { code: 'Numpad7', ctrl: true, run: () => actions.standardView([0, 0, 1], [0, -1, 0]) },
            ...kTools.map((name, i) => ({ code: `Digit${i + 1}`, run: tool(name) })),
        ];
        window.addEventListener('keydown', (e) => this.down(e, hooks.help));
        window.addEventListener('keyup', (e) => this.held.delete(e.code));
        window.addEventListener('blur', () => this.held.clear());
    }

    private down(event: KeyboardEvent, help: () => void): void {
        const typing = event.target as HTMLElement;
        const inField = typing.matches(kTyping);
        const modal = document.querySelector('dialog[open]') !== null;
        if (modal || (inField && event.code !== 'Escape')) return;
        if (event.key === '?') {
            help();
            event.preventDefault();
            return;
        }
        if (this.isForCatheter(event)) {
            this.held.add(event.code);
            event.preventDefault();
            return;
        }
        // Controls keep the keys that they use themselves.
        const control = typing.matches('input, select, button, summary, a, label');
        const own = /^(Arrow|Page|Home|Enter|Space)/.test(event.code);
        if (control && own && !event.altKey) return;
        const ctrl = event.ctrlKey || event.metaKey;
        const binding = this.bindings.find(
            (b) =>
                b.code === event.code &&
                (b.ctrl ?? false) === ctrl &&
                (b.alt ?? false) === event.altKey &&
                (b.shift ?? event.shiftKey) === event.shiftKey &&
                (b.when?.(this.session.store.state) ?? true),
        );
        if (binding) {
            binding.run();
            event.preventDefault();
        } else if (!ctrl && !event.altKey) {
            this.held.add(event.code);
            if (isFlightKey(event.code) && !typing.matches('select')) event.preventDefault();
        }
    }

    /// Tests whether an arrow key drives the catheter: not while a slider or a list has the focus.
    private isForCatheter(event: KeyboardEvent): boolean {
        const { ctrlKey, altKey, metaKey, code } = event;
        const needs = (event.target as HTMLElement).matches('input, select');
        const arrow = code.startsWith('Arrow') && !ctrlKey && !altKey && !metaKey;
        return arrow && !needs && keysDrive(this.session.store.state);
    }

    private stop(): void {
        this.held.clear();
    }
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mouse, pen and wheel in the views, with the conventions of common viewers:
//
//   wheel        slices; in the endoscope forward and back        Shift: window   Ctrl: zoom
//   left drag    use of the tool; with W held in a section: window and level
//   left click   crosshair                                        Shift and move: crosshair too
//   middle drag  pan                right drag  zoom              double click: maximise the view
//
// With the tools Measure and Path, which set points, a double click is one click.
//
// One finger is a left drag; in a section it scrolls slices with the tool Look. Two fingers zoom
// and pan.

import { frameOf } from '../maths/rays.ts';
import { add, along, mul, norm, sub, type Vec3 } from '../maths/vec.ts';
import { kViews, type SectionName, type ViewName } from '../state/state.ts';
import { scaleOf } from '../state/units.ts';
import { orbitTurned } from '../views/orbit.ts';
import { worldOfPixel } from '../views/section_geometry.ts';
import type { Actions } from './actions.ts';
import { dragFrame, planeAt, pointAt, rayAt, type Spot } from './aim.ts';
import { CarveWall } from './carve_wall.ts';
import { Fingers, type Pinch } from './fingers.ts';
import { Pressing } from './pressing.ts';
import type { Session } from './session.ts';
import { inEndoscope, isFlightKey } from './steering.ts';
import { CarveStroke, CutStroke, GrabStroke, PushStroke, type Stroke } from './strokes.ts';

// Lengths in a body.
const kPressLead = 3; // of the probe's target before the probe [mm]
const kDoubleMs = 500; // longest time between the clicks of a double click
const kClickPixels = 3; // smallest motion of a drag; less is a click
const kTapPixels = 10; // the same for fingers
const kSlicePixels = 8; // motion of a finger per slice
const kLookRate = 0.25; // degrees per pixel at 80 degrees of field
const kWindowRate = 4; // HU per pixel, or the same share of the range
const kWheelTurn = 100; // delta of one notch of the wheel
const kWheelStep = 1.5; // motion of the endoscope per notch [mm]
const kWheelDeep = 1; // motion of a device per notch [mm]
const kWheelTool = 0.5; // motion of a tool per notch [mm]

type DragKind =
    | 'look'
    | 'device'
    | 'orbit'
    | 'window'
    | 'pan'
    | 'zoom'
    | 'scroll'
    | 'mark'
    | 'tissue'
    | 'none';

/// Takes the number in a field that has the focus: keys are commands again over a view.
function leaveNumber(): void {
    const field = document.activeElement;
    if (field instanceof HTMLInputElement && field.type === 'number') field.blur();
}

/// Tests whether a drag changes the view, as one step of undo.
const hasUndo = (kind: DragKind): boolean =>
    kind !== 'tissue' && kind !== 'device' && kind !== 'none';

const isNear = (a: Spot, b: Spot | undefined): boolean =>
    b?.view === a.view && Math.hypot(a.x - b.x, a.y - b.y) < 2 * kClickPixels;

interface Drag {
    readonly kind: DragKind;
    readonly button: number;
    readonly start: Spot;
    readonly slop: number; ///< motion that is still a click [pixels]
    last: Spot;
    moved: boolean;
    place: Vec3 | undefined; ///< of the tool
    wall: CarveWall | undefined; ///< that a scoop follows
}

export class Pointer {
    private drag: Drag | undefined;
    private wheelRest = 0;
    private readonly fingers = new Fingers();
    private readonly pressing = new Pressing();
    private clicked = -Infinity; // time of the last click [ms]
    private clickedAt: Spot | undefined;
    private clickedWith = ''; // the tool's name
    private beforeClick: Vec3 | undefined; // the crosshair before it, or before two in a row

    constructor(
        private readonly session: Session,
        private readonly actions: Actions,
        private readonly views: Record<ViewName, HTMLElement>,
        private readonly held: ReadonlySet<string>,
    ) {
        for (const view of kViews) this.listen(view, views[view]);
    }

    /// Ends the drag under way.
    cancel(): void {
        if (!this.drag) return;
        const { kind } = this.drag;
        this.drag = undefined;
        this.pressing.stop();
        this.session.hand.poise(undefined);
        this.session.marks.letGo();
        if (kind === 'tissue') void this.session.hand.end();
        else if (hasUndo(kind)) this.session.history.end(kind);
    }

    private listen(view: ViewName, element: HTMLElement): void {
        element.addEventListener('pointerdown', (e) => this.down(view, e));
        element.addEventListener('pointermove', (e) => this.move(view, e));
        element.addEventListener('pointerup', (e) => this.up(e));
        element.addEventListener('pointercancel', (e) => {
            if (this.fingers.up(e)) this.session.history.end('pinch');
            this.cancel();
        });
        element.addEventListener('pointerenter', () => {
            leaveNumber();
            if (!this.drag) this.hover(view);
        });
        element.addEventListener('pointerleave', () => {
            if (!this.drag) this.session.store.set({ pointer: { under: null } });
        });
        element.addEventListener('wheel', (e) => this.wheel(view, e), { passive: false });
        element.addEventListener('dblclick', (e) => this.doubleClick(view, e));
        element.addEventListener('contextmenu', (e) => e.preventDefault());
        element.addEventListener('focus', () => this.activate(view));
    }

    /// Keys act on the view under the pointer; keys that fly go on until they are released.
    private hover(view: ViewName): void {
        const { state } = this.session.store;
        const flies = inEndoscope(state) && [...this.held].some(isFlightKey);
        if (!flies) this.activate(view);
    }

    /// Maximises a view. The clicks before have moved the crosshair: it returns.
    private doubleClick(view: ViewName, event: MouseEvent): void {
        if ((event.target as HTMLElement).closest('button')) return;
        const { store } = this.session;
        this.clicked = -Infinity;
        if (this.setsPoints && !event.ctrlKey && !event.metaKey) return;
        if (this.beforeClick) store.set({ sections: { cursor: this.beforeClick } });
        if (event.ctrlKey || event.metaKey) {
            const { volume } = this.session;
            const place = volume && pointAt(volume, store.state, this.spot(view, event));
            if (place) this.actions.endoscopeTo(place);
        } else this.actions.toggleMaximised(view);
    }

    private get setsPoints(): boolean {
        const { name } = this.session.store.state.tool;
        return name === 'measure' || name === 'path';
    }

    private activate(view: ViewName): void {
        this.session.store.set({ pointer: { active: view } });
    }

    private spot(view: ViewName, event: Pick<MouseEvent, 'clientX' | 'clientY'>): Spot {
        const box = this.views[view].getBoundingClientRect();
        return {
            view,
            x: event.clientX - box.left,
            y: event.clientY - box.top,
            width: box.width,
            height: box.height,
        };
    }

    private down(view: ViewName, event: PointerEvent): void {
        if ((event.target as HTMLElement).closest('button')) return;
        const isTouch = event.pointerType === 'touch';
        if (isTouch && this.fingers.down(event)) {
            this.cancel();
            this.session.history.begin();
        }
        if (this.drag || this.fingers.pinch) return;
        const element = this.views[view];
        element.setPointerCapture(event.pointerId);
        element.focus({ preventScroll: true });
        this.activate(view);
        const spot = this.spot(view, event);
        const kind = this.kindOf(view, event);
        if (event.button === 1) event.preventDefault(); // no automatic scrolling
        const { button } = event;
        const slop = isTouch ? kTapPixels : kClickPixels;
        this.drag = {
            kind,
            button,
            start: spot,
            slop,
            last: spot,
            moved: false,
            place: undefined,
            wall: undefined,
        };
        if (hasUndo(kind)) this.session.history.begin();
        const { volume, store } = this.session;
        if (kind === 'tissue' && volume && store.state.scan.loaded === 1)
            this.session.hand.poise(pointAt(volume, store.state, spot));
        if (kind === 'tissue' && view === 'endoscope' && store.state.tool.name === 'push')
            this.pressing.wait(
                () => this.beginPress(),
                (way) => this.press(way),
            );
    }

    /// Length scale of the scan; 1 for a patient.
    private get scale(): number {
        return scaleOf(this.session.store.state.scan.volume);
    }

    private beginPress(): boolean {
        const { drag, session } = this;
        if (!drag || drag.moved || session.store.state.scan.loaded < 1) return false;
        this.beginStroke(drag);
        drag.moved = true;
        return drag.place !== undefined;
    }

    /// Moves the probe into the wall, no farther ahead of the tissue than kPressLead.
    private press(way: number): void {
        const { drag, session } = this;
        const { stroke } = session.hand;
        const { tool } = session.store.state;
        if (!drag?.place || !stroke || tool.outcome?.isStopped || tool.strength === 0) return;
        const there = stroke.path[stroke.path.length - 1]!;
        const { direction } = rayAt(session.store.state, drag.last);
        const { scale } = this;
        const next = along(drag.place, scale * way * tool.strength, direction);
        if (norm(sub(next, there)) > scale * kPressLead) return;
        drag.place = next;
        session.hand.drag(next);
    }

    private kindOf(view: ViewName, event: PointerEvent): DragKind {
        const { tool, view: shown, link } = this.session.store.state;
        if (event.button === 1) return 'pan';
        if (event.button === 2) return 'zoom';
        if (event.shiftKey) return 'none'; // the crosshair follows
        if (tool.name === 'measure' && this.session.marks.hold(this.spot(view, event)))
            return 'mark';
        const section = view !== 'endoscope';
        if (section && (tool.name === 'window' || this.held.has('KeyW'))) return 'window';
        const looks = ['look', 'window', 'path', 'catheter', 'measure'].includes(tool.name);
        if (!looks && link.role === 'control') return 'tissue';
        if (section) return event.pointerType === 'touch' ? 'scroll' : 'none';
        if (this.session.device.isLedHere) return 'device';
        return shown.outside ? 'orbit' : 'look';
    }

    private move(view: ViewName, event: PointerEvent): void {
        const spot = this.spot(view, event);
        const { session, drag } = this;
        if (!session.volume || session.store.state.scan.loaded < 1) return;
        if (this.fingers.pinch) {
            const pinch = this.fingers.move(event);
            if (pinch) this.pinch(view, pinch);
            return;
        }
        this.fingers.move(event);
        if (!drag) {
            this.hover(view);
            const point = pointAt(session.volume, session.store.state, spot);
            session.store.set({ pointer: { under: point ? { view, point } : null } });
            if (event.shiftKey && point) this.actions.setCursor(point);
            return;
        }
        const dx = spot.x - drag.last.x;
        const dy = spot.y - drag.last.y;
        const way = Math.hypot(spot.x - drag.start.x, spot.y - drag.start.y);
        if (!drag.moved && way < drag.slop) return;
        this.pressing.yieldTo(way);
        if (!drag.moved && drag.kind === 'tissue') this.beginStroke(drag);
        drag.moved = true;
        drag.last = spot;
        this.continueDrag(drag, spot, dx, dy, event.shiftKey);
    }

    private continueDrag(drag: Drag, spot: Spot, dx: number, dy: number, shift: boolean): void {
        const { session, actions } = this;
        const { state } = session.store;
        const rate = (kLookRate * Math.PI) / 180;
        const section = spot.view as SectionName;
        switch (drag.kind) {
            case 'look': {
                const slower = state.view.fieldOfView / 80;
                session.endoscope.turn(dx * rate * slower, -dy * rate * slower);
                break;
            }
            case 'device':
                session.device.lead(dx, dy);
                break;
            case 'orbit':
                session.store.set({
                    view: { orbit: orbitTurned(state.view.orbit, -2 * dx * rate, -2 * dy * rate) },
                });
                break;
            case 'window':
                actions.windowBy(kWindowRate * dx, -kWindowRate * dy);
                break;
            case 'pan':
                if (spot.view === 'endoscope') this.panEndoscope(spot, dx, dy);
                else actions.pan(section, dx, dy, spot.width, spot.height);
                break;
            case 'zoom':
                actions.zoom(spot.view, Math.exp(-0.01 * dy));
                break;
            case 'scroll': {
                this.wheelRest -= dy / kSlicePixels;
                const whole = Math.trunc(this.wheelRest);
                this.wheelRest -= whole;
                if (whole) actions.scroll(section, whole);
                break;
            }
            case 'tissue':
                this.moveStroke(drag, spot, dx, dy);
                break;
            case 'mark': {
                const point = pointAt(session.volume!, state, spot);
                if (point) session.marks.dragTo(point);
                break;
            }
            case 'none': {
                const point = shift && pointAt(session.volume!, state, spot);
                if (point) actions.setCursor(point);
                break;
            }
        }
    }

    /// Zooms and pans by two fingers.
    private pinch(view: ViewName, { factor, dx, dy, middle }: Pinch): void {
        const { session, actions } = this;
        const { volume, store } = session;
        const spot = this.spot(view, { clientX: middle.x, clientY: middle.y });
        const plane = planeAt(volume!, store.state, spot);
        actions.zoom(view, factor, plane && worldOfPixel(plane, spot.x, spot.y));
        if (view === 'endoscope') this.panEndoscope(spot, dx, dy);
        else actions.pan(view, dx, dy, spot.width, spot.height);
    }

    private up(event: PointerEvent): void {
        if (this.fingers.up(event)) this.session.history.end('pinch');
        const { drag, session } = this;
        if (!drag || event.button !== drag.button) return;
        this.drag = undefined;
        this.pressing.stop();
        session.hand.poise(undefined);
        if (drag.kind === 'tissue' && drag.moved) void session.hand.end();
        else if (hasUndo(drag.kind)) session.history.end(drag.kind);
        session.marks.letGo();
        if (!drag.moved && drag.button === 0) this.click(drag.start);
    }

    private click(spot: Spot): void {
        const { volume, store, history } = this.session;
        if (!volume || store.state.scan.loaded < 1) return;
        const now = performance.now();
        const { name } = store.state.tool;
        const isDouble =
            now - this.clicked < kDoubleMs &&
            name === this.clickedWith &&
            isNear(spot, this.clickedAt);
        if (now - this.clicked > kDoubleMs) this.beforeClick = store.state.sections.cursor;
        this.clicked = now;
        this.clickedAt = spot;
        this.clickedWith = name;
        if (isDouble && this.setsPoints) return;
        const point = pointAt(volume, store.state, spot);
        if (!point) return;
        if (store.state.tool.name === 'measure') {
            this.session.marks.click(point, spot);
            return;
        }
        history.step('crosshair', () => this.actions.setCursor(point));
        if (store.state.tool.name === 'path') void this.session.path.click(point);
    }

    private wheel(view: ViewName, event: WheelEvent): void {
        event.preventDefault();
        const { session, actions, drag } = this;
        if (!session.volume) return;
        // With Shift some browsers report sideways scrolling.
        const delta = event.deltaY || event.deltaX;
        const notches = -(event.deltaMode === 0 ? delta / kWheelTurn : delta / 3);
        if (drag?.kind === 'tissue') {
            this.deepenStroke(drag, notches);
        } else if (drag?.kind === 'device') {
            session.device.lead(0, 0, notches * this.scale * kWheelDeep);
        } else if (event.ctrlKey || event.metaKey) {
            const at = planeAt(session.volume, session.store.state, this.spot(view, event));
            const { x, y } = this.spot(view, event);
            const fixed = at && worldOfPixel(at, x, y);
            session.history.step('zoom', () => actions.zoom(view, Math.exp(0.15 * notches), fixed));
        } else if (view === 'endoscope') {
            if (session.store.state.view.outside)
                session.history.step('zoom', () => actions.zoom(view, Math.exp(0.15 * notches)));
            else this.flyBy(notches * this.scale * kWheelStep);
        } else if (event.shiftKey) {
            session.history.step('window', () => actions.windowBy(-40 * notches, 0));
        } else {
            // Touchpads report fractions of a notch.
            this.wheelRest += notches;
            const whole = Math.trunc(this.wheelRest + 1e-6 * Math.sign(notches));
            this.wheelRest -= whole;
            if (whole) actions.scroll(view, whole);
        }
    }

    private flyBy(way: number): void {
        const { session } = this;
        const { view, flight } = session.store.state;
        const { forward } = frameOf(view.camera);
        session.history.step('flight', () =>
            session.endoscope.fly(mul(way * flight.speed, forward)),
        );
    }

    private panEndoscope(spot: Spot, dx: number, dy: number): void {
        const { session } = this;
        const { state } = session.store;
        const { camera, outside, orbit } = state.view;
        const point = add(camera.eye, mul(10 * this.scale, frameOf(camera).forward));
        const place = outside ? orbit.centre : point;
        const { right, up, mmPerPixel } = dragFrame(session.volume!, state, spot, place);
        const motion = along(mul(-dx * mmPerPixel, right), dy * mmPerPixel, up);
        if (outside)
            session.store.set({ view: { orbit: { ...orbit, centre: add(place, motion) } } });
        else session.endoscope.fly(motion);
    }

    // --- strokes

    private beginStroke(drag: Drag): void {
        const { session } = this;
        const { store } = session;
        const place = pointAt(session.volume!, store.state, drag.start);
        if (!place) return;
        drag.place = place;
        if (store.state.tool.name === 'carve')
            drag.wall = new CarveWall(session.volume!, store.state, drag.start, place);
        const frame = dragFrame(session.volume!, store.state, drag.start, place);
        const make = (): Stroke => {
            switch (store.state.tool.name) {
                case 'grab':
                    return new GrabStroke(session, place);
                case 'carve':
                    return new CarveStroke(session, place);
                case 'cut': {
                    const centred = drag.start.view !== 'endoscope';
                    return new CutStroke(session, place, frame.ahead, centred);
                }
                default:
                    return new PushStroke(session, place);
            }
        };
        session.hand.begin(make());
    }

    private moveStroke(drag: Drag, spot: Spot, dx: number, dy: number): void {
        const { session } = this;
        const { state } = session.store;
        if (!drag.place || !session.hand.stroke) return;
        const { name, strength } = state.tool;
        if (name === 'cut' || drag.wall) {
            const point = drag.wall
                ? drag.wall.at(state, spot)
                : pointAt(session.volume!, state, spot);
            if (point) session.hand.drag(point);
            return;
        }
        const { right, up, mmPerPixel } = dragFrame(session.volume!, state, spot, drag.place);
        const share = name === 'push' ? strength : 1;
        const across = share * dx * mmPerPixel;
        drag.place = along(along(drag.place, across, right), -share * dy * mmPerPixel, up);
        session.hand.drag(drag.place);
    }

    /// Moves the tool away from the viewer or back by the wheel, while the button is held.
    private deepenStroke(drag: Drag, notches: number): void {
        const { session } = this;
        if (!drag.moved) {
            this.beginStroke(drag);
            drag.moved = true;
        }
        if (!drag.place || !session.hand.stroke) return;
        const { state } = session.store;
        if (drag.wall) {
            drag.wall.depth += notches * this.scale * kWheelTool;
            const point = drag.wall.at(state, drag.last);
            if (point) session.hand.drag(point);
            return;
        }
        const { ahead } = dragFrame(session.volume!, state, drag.last, drag.place);
        drag.place = along(drag.place, notches * this.scale * kWheelTool, ahead);
        session.hand.drag(drag.place);
    }
}

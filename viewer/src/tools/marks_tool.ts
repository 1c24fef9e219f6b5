// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Marks and measurements: set by clicks, moved by drags, listed in the panel, read and written as
// files. Marks belong to the tissue: see maths/marks.ts.

import { voxelFromWorld } from '../maths/grid.ts';
import {
    freeName,
    kPointsOf,
    lengthOf,
    type Mark,
    type OffsetAt,
    presentOf,
    type Value,
    valueOf,
    valueText,
} from '../maths/marks.ts';
import {
    kMaxMarks,
    kMaxNameLength,
    placedOf,
    readMarks,
    writeMarkups,
    writeTable,
} from '../maths/marks_file.ts';
import { add, mul, norm, sub, type Vec3 } from '../maths/vec.ts';
import type { MarksNews, SharedMark } from '../net/protocol.ts';
import type { Marks } from '../state/state.ts';
import { planeUnder } from '../views/planes.ts';
import { lengthText, scaleOf } from '../state/units.ts';
import { spotInView } from '../views/projection.ts';
import { pixelOfWorld } from '../views/section_geometry.ts';
import { planeAt, type Spot } from './aim.ts';
import { saveBlob } from './download.ts';
import type { Scene } from './scene.ts';

const markOf = ({ key, kind, name = '', points, shown = true }: SharedMark): Mark | undefined =>
    kind === 'none' || !points ? undefined : { key, kind, name, rest: points, shown };

/// A mark's point that is dragged.
interface Held {
    readonly key: string;
    readonly point: number;
}

const kLeastStep = 0.01; // between the points of a mark, in a body [mm]
const kClose = 0.005; // sufficient accuracy of a present position [mm]
const kReachPixels = 9; // of a press from a mark's point
const kBackOff = 25; // distance of the endoscope from a mark that it goes to, in a body [mm]

const newKey = (): string =>
    [...crypto.getRandomValues(new Uint8Array(8))]
        .map((byte) => byte.toString(16).padStart(2, '0'))
        .join('');

export class MarksTool {
    private held: Held | undefined;
    /// Marks as the server has them, by key; undefined: not shared.
    private known: Map<string, Mark> | undefined;
    /// Keys of marks that the server has had.
    private readonly confirmed = new Set<string>();
    private keeps = false; // own marks that the server lacks are sent to it
    /// Last known present positions, by mark, and the version of the field they are of.
    private readonly places = new WeakMap<Mark, { rest: unknown; at: number; points: Vec3[] }>();

    constructor(private readonly scene: Scene) {
        scene.store.listen((state, before) => {
            if (state.marks.list !== before.marks.list) this.share();
        });
    }

    private get marks(): Marks {
        return this.scene.store.state.marks;
    }
    private set(marks: Partial<Marks>): void {
        this.scene.store.set({ marks });
    }
    /// Changes the list, as a step of undo.
    private change(name: string, list: readonly Mark[], more: Partial<Marks> = {}): void {
        const { history } = this.scene;
        history.begin();
        this.set({ ...more, list });
        history.end(name);
    }

    // --- sharing

    /// Subscribes to the marks that the clients of the scan share.
    /// @param resumed  the server knows this client, and so the marks that it has made
    ask(resumed: boolean): void {
        const { connection, store } = this.scene;
        this.known = undefined;
        this.keeps = !resumed;
        if (store.state.link.features.includes('marks'))
            void connection.ask({ do: 'marks', on: true });
    }

    forget(): void {
        this.known = undefined;
        this.set({ list: [], pending: [], selected: '' });
    }

    /// Takes the server's marks, or the change of one of them.
    take(news: MarksNews): void {
        const list = [...this.marks.list];
        if (news.t === 'marks') {
            const theirs = news.marks.flatMap((mark) => markOf(mark) ?? []);
            this.known = new Map(theirs.map((mark) => [mark.key, mark]));
            // Marks of a server that was started anew, or that were made without a connection;
            // others were deleted meanwhile.
            const own = list.filter(
                ({ key }) => !this.known!.has(key) && (this.keeps || !this.confirmed.has(key)),
            );
            for (const { key } of theirs) this.confirmed.add(key);
            this.set({ list: [...theirs, ...own] });
            this.share();
            return;
        }
        const mark = markOf(news);
        const at = list.findIndex(({ key }) => key === news.key);
        if (!mark) {
            this.known?.delete(news.key);
            if (at >= 0) list.splice(at, 1);
        } else {
            this.known?.set(mark.key, mark);
            this.confirmed.add(mark.key);
            if (at >= 0) list[at] = mark;
            else list.push(mark);
        }
        this.set({ list });
    }

    /// Sends the changes since the server's marks. Viewers' marks stay their own.
    private share(): void {
        const { known } = this;
        const { connection, store } = this.scene;
        if (!known || store.state.link.role === 'view') return;
        const { list } = this.marks;
        for (const mark of list) {
            if (known.get(mark.key) === mark) continue;
            known.set(mark.key, mark);
            const { key, kind, name, rest, shown } = mark;
            const command = { do: 'mark', key, kind, name, points: rest, shown } as const;
            void connection.ask(command, (answer) => {
                if (answer?.t === 'done') this.confirmed.add(key);
            });
        }
        const keys = new Set(list.map(({ key }) => key));
        for (const key of [...known.keys()].filter((k) => !keys.has(k))) {
            known.delete(key);
            void connection.ask({ do: 'mark', key, kind: 'none' });
        }
    }

    // --- positions

    /// Offset of the tissue at a present position [mm, LPS].
    private readonly offsetAt: OffsetAt = (place) => {
        const { rest } = this.scene.stage;
        return rest ? rest.at(voxelFromWorld(rest.grid, place)).offset : [0, 0, 0];
    };

    /// Position at rest of the tissue at a present position.
    restOf(place: Vec3): Vec3 {
        return sub(place, this.offsetAt(place));
    }

    /// Present positions of a mark's points [mm, LPS].
    present(mark: Mark): readonly Vec3[] {
        const { rest } = this.scene.stage;
        const at = this.scene.store.state.versions.rest;
        const last = this.places.get(mark);
        if (last && last.rest === rest && last.at === at) return last.points;
        const points = mark.rest.map((p, n) => this.presentPoint(p, last?.points[n]));
        this.places.set(mark, { rest, at, points });
        return points;
    }

    presentPoint(rest: Vec3, guess?: Vec3): Vec3 {
        const field = this.scene.stage.rest;
        if (!field) return rest;
        // The iteration may fail at kinks of the field, so it has several beginnings.
        const h = Math.min(...field.grid.spacing);
        const off = (p: Vec3): number => norm(sub(sub(p, this.offsetAt(p)), rest));
        let best = rest;
        let least = Infinity;
        for (const from of [guess ?? rest, rest, add(rest, this.offsetAt(rest))]) {
            const found = presentOf(rest, this.offsetAt, from, h);
            const miss = off(found);
            if (miss < least) [best, least] = [found, miss];
            if (least < kClose) break;
        }
        return best;
    }

    /// Text of a mark's value; empty for a point.
    textOf(mark: Mark): string {
        const value = valueOf(mark.kind, this.present(mark));
        return value ? this.valueText(value) : '';
    }
    /// Text of a value in the scan's unit of length.
    valueText(value: Value): string {
        return valueText(value, scaleOf(this.scene.store.state.scan.volume));
    }

    // --- setting marks

    /// Takes a click at a present position. On a mark's point it selects that mark, except while
    /// another one is being set.
    /// @param spot  of the click; undefined: by the keyboard
    click(place: Vec3, spot?: Spot): void {
        const { kind, pending, list } = this.marks;
        if (!pending.length && spot && this.near(spot)) return;
        const rest = this.restOf(place);
        const last = pending[pending.length - 1];
        const least = kLeastStep * scaleOf(this.scene.store.state.scan.volume);
        if (last && norm(sub(rest, last)) < least) {
            this.scene.say(`${kind}: the last point is here; click another one`);
            return;
        }
        const points = [...pending, rest];
        if (points.length < kPointsOf[kind]) {
            this.set({ pending: points });
            const more = kPointsOf[kind] - points.length;
            this.scene.say(`${kind}: ${more === 1 ? 'one more click' : `${more} more clicks`}`);
            return;
        }
        if (list.length >= kMaxMarks) {
            this.scene.say(`expected up to ${kMaxMarks} marks; delete some first`);
            return;
        }
        const name = freeName(kind, list);
        const mark: Mark = { key: newKey(), kind, name, rest: points, shown: true };
        this.change(kind, [...list, mark], { pending: [], selected: mark.key });
        const text = this.textOf(mark);
        this.scene.say(text ? `${name}: ${text}` : name);
    }

    /// Forgets the points of an incomplete mark.
    cancel(): void {
        if (this.marks.pending.length) this.set({ pending: [] });
    }

    choose(kind: Marks['kind']): void {
        this.set({ kind, pending: [] });
        this.scene.store.set({ tool: { name: 'measure' } });
    }

    // --- moving points

    /// Takes hold of the shown mark's point that is nearest to a spot, for dragTo().
    /// @returns whether there is one
    hold(spot: Spot): boolean {
        this.held = this.near(spot);
        if (this.held) this.set({ selected: this.held.key });
        return this.held !== undefined;
    }

    private near(spot: Spot): Held | undefined {
        const { volume, store } = this.scene;
        if (!volume) return undefined;
        const plane = planeAt(volume, store.state, spot);
        const { view, spot: inView } = planeUnder(store.state, spot);
        let best: Held | undefined;
        const scale = scaleOf(store.state.scan.volume);
        let least = kReachPixels;
        for (const mark of this.marks.list) {
            if (!mark.shown || mark.kind === 'curve') continue;
            this.present(mark).forEach((place, point) => {
                const at = plane
                    ? pixelOfWorld(plane, place)
                    : spotInView(view, place, inView, scale);
                const { x, y } = plane ? spot : inView;
                const off = at ? Math.hypot(at[0] - x, at[1] - y) : Infinity;
                if (off > least) return;
                least = off;
                best = { key: mark.key, point };
            });
        }
        return best;
    }

    /// Moves the held point to a present position. @pre within a step of undo
    dragTo(place: Vec3): void {
        const { held } = this;
        if (!held) return;
        const rest = this.restOf(place);
        this.set({
            list: this.marks.list.map((mark) =>
                mark.key === held.key
                    ? { ...mark, rest: mark.rest.map((p, n) => (n === held.point ? rest : p)) }
                    : mark,
            ),
        });
    }

    letGo(): void {
        this.held = undefined;
    }

    // --- the list

    private find(key: string): Mark | undefined {
        return this.marks.list.find((mark) => mark.key === key);
    }
    private replace(name: string, key: string, change: Partial<Mark>): void {
        const list = this.marks.list.map((mark) =>
            mark.key === key ? { ...mark, ...change } : mark,
        );
        this.change(name, list);
    }

    rename(key: string, name: string): void {
        const text = name.trim().slice(0, kMaxNameLength);
        if (text && text !== this.find(key)?.name) this.replace('rename', key, { name: text });
    }
    show(key: string, shown: boolean): void {
        this.replace(shown ? 'show' : 'hide', key, { shown });
    }
    remove(key: string): void {
        this.change(
            'delete mark',
            this.marks.list.filter((mark) => mark.key !== key),
        );
    }
    clear(): void {
        if (this.marks.list.length) this.change('delete marks', []);
    }

    /// Moves the crosshair to a mark, and turns the endoscope towards it if it is near.
    goTo(key: string): void {
        const mark = this.find(key);
        if (!mark) return;
        const points = this.present(mark);
        const sum = points.reduce((a, b) => add(a, b));
        // An angle is at its vertex.
        const place = mark.kind === 'angle' ? points[1]! : mul(1 / points.length, sum);
        const { history, store } = this.scene;
        history.begin();
        store.set({ sections: { cursor: place }, marks: { selected: key } });
        const { camera, outside } = store.state.view;
        const way = sub(place, camera.eye);
        const scale = scaleOf(store.state.scan.volume);
        if (!outside && norm(way) > 0.5 * scale && norm(way) < scale * kBackOff)
            store.set({ view: { camera: { ...camera, look: mul(1 / norm(way), way) } } });
        history.end('go to mark');
    }

    // --- files

    private get placed(): ReturnType<typeof placedOf>[] {
        return this.marks.list.map((mark) => placedOf(mark, this.present(mark)));
    }
    saveMarkups(): void {
        const blob = new Blob([writeMarkups(this.placed)], { type: 'application/json' });
        saveBlob(blob, 'marks.mrk.json');
    }
    saveTable(): void {
        saveBlob(new Blob([writeTable(this.placed)], { type: 'text/csv' }), 'marks.csv');
    }

    /// Adds the marks of a file. @throws an Error with the reason why it has none
    open(text: string, name: string): void {
        const read = readMarks(text, name);
        const { list } = this.marks;
        if (list.length + read.length > kMaxMarks)
            throw new Error(
                `${name}: expected up to ${kMaxMarks} marks together, found ` +
                    `${list.length + read.length}`,
            );
        const more = read.map(({ kind, name: own, points, shown }): Mark => ({
            key: newKey(),
            kind,
            name: own,
            rest: points.map((p) => this.restOf(p)),
            shown,
        }));
        this.change('open marks', [...list, ...more]);
        this.scene.say(`${name}: ${more.length} ${more.length === 1 ? 'mark' : 'marks'}`);
    }

    /// Adds the present path as a curve.
    addPath(): void {
        const { path } = this.scene.store.state.way;
        if (!path) return;
        const { list } = this.marks;
        const name = freeName('curve', list);
        const rest = path.points.map((p) => this.restOf(p));
        this.change('curve', [...list, { key: newKey(), kind: 'curve', name, rest, shown: true }]);
        const { volume } = this.scene.store.state.scan;
        this.scene.say(`${name}: ${lengthText(volume, lengthOf(path.points))} mm`);
    }
}

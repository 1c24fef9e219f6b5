// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Labels beside the scan: their field from the server, names under the pointer, and warnings when a
// tool touches a structure at risk.

import { voxelFromWorld } from '../maths/grid.ts';
import { along, norm, normalized, sub, type Vec3 } from '../maths/vec.ts';
import type { BoxFrame, LabelsNews } from '../net/protocol.ts';
import {
    type Label,
    type LabelLook,
    labelsOf,
    lookOf,
    nameOf,
    readNames,
} from '../state/labels.ts';
import { scaleOf } from '../state/units.ts';
import { LabelField } from '../views/label_field.ts';
import type { Scene } from './scene.ts';

const kBehind = 1.2; // as in shaders/labels.glsl [voxels]
const kTouchMs = 60; // between two tests of the tools
const kMargin = 0.5; // distance at which a tool touches, in a body [mm]

export class LabelsTool {
    /// Sends a label map to the server.
    send: (file: File) => Promise<void> = async () => {};
    private lastTouch = 0;

    constructor(private readonly scene: Scene) {}

    /// Subscribes to the label map. The subscription ends with the connection and with the scan.
    ask(): void {
        const { connection, store } = this.scene;
        if (store.state.link.features.includes('labels'))
            void connection.ask({ do: 'labels', on: true });
    }

    /// Takes the list of another map; its boxes follow.
    take(news: LabelsNews): void {
        const { stage, store, volume } = this.scene;
        if (!volume || news.volume !== store.state.scan.volume?.id) return;
        const list = labelsOf(news);
        stage.setLabels(list.length ? new LabelField(volume.grid) : undefined);
        const { version, file } = store.state.labels;
        store.set({ labels: { file: news.name, list, version: version + 1, touched: [] } });
        const isOwn = list.every(({ body }) => body > 0); // the bodies of the scene
        if (news.name && news.name !== file && !isOwn)
            this.scene.say(
                `${news.name}: ${list.length} ${list.length === 1 ? 'label' : 'labels'}`,
            );
    }

    box(frame: BoxFrame): void {
        const { stage, store } = this.scene;
        if (!stage.labels) return;
        stage.labels.patch(frame.box, frame.halves);
        if (frame.last) store.set({ labels: { version: store.state.labels.version + 1 } });
    }

    forget(): void {
        this.scene.stage.setLabels(undefined);
        this.scene.store.set({ labels: { file: '', list: [], touched: [] } });
    }

    /// Changes how a label is shown.
    look(label: Label, change: Partial<LabelLook>): void {
        const { store } = this.scene;
        const { labels } = store.state;
        const look = { ...lookOf(labels, label), ...change };
        store.set({ labels: { looks: { ...labels.looks, [label.value]: look } } });
    }
    showAll(shown: boolean): void {
        const { store } = this.scene;
        const { labels } = store.state;
        const looks = Object.fromEntries(
            labels.list.map((label) => [label.value, { ...lookOf(labels, label), shown }]),
        );
        store.set({ labels: { looks: { ...labels.looks, ...looks } } });
    }

    /// Takes names from a table. @throws an Error if there is none
    openNames(text: string, file: string): void {
        const names = readNames(text, file);
        this.scene.store.set({ labels: { names } });
        this.scene.say(`${file}: ${Object.keys(names).length} names of labels`);
    }

    /// Moves the crosshair to a label's centre at rest.
    goTo(label: Label): void {
        const { history, store } = this.scene;
        history.step('go to label', () => store.set({ sections: { cursor: label.centre } }));
    }

    /// Label at a present position.
    at(place: Vec3): Label | undefined {
        const { stage, store } = this.scene;
        const number = stage.labels?.numberAt(voxelFromWorld(stage.labels.grid, place)) ?? 0;
        return store.state.labels.list[number - 1];
    }

    /// Name of the label under the pointer, else at the crosshair; empty: none.
    get under(): string {
        const { stage, store } = this.scene;
        const { pointer, sections, view, labels } = store.state;
        if (!stage.labels) return '';
        let place = pointer.under?.point ?? sections.cursor;
        if (pointer.under?.view === 'endoscope') {
            // The tissue behind the wall.
            const eye = view.outside ? sub(place, view.orbit.direction) : view.camera.eye;
            const step = kBehind * Math.min(...stage.labels.grid.spacing);
            place = along(place, step, normalized(sub(place, eye)));
        }
        const label = this.at(place);
        return label ? nameOf(labels, label) : '';
    }

    /// Warns when an own tool touches a structure at risk. @param now  [ms]
    tick(now: number): void {
        const { stage, store } = this.scene;
        const { labels } = store.state;
        if (now - this.lastTouch < kTouchMs) return;
        this.lastTouch = now;
        const risks = labels.list.filter((label) => lookOf(labels, label).risk);
        const tools = risks.length ? stage.balls.filter((ball) => ball.own) : [];
        const margin = scaleOf(store.state.scan.volume) * kMargin;
        const found = new Set<number>();
        for (const { centre, radius } of tools)
            for (const number of this.numbersIn(centre, radius + margin)) found.add(number);
        const touched = risks
            .filter(({ number }) => found.has(number))
            .map((label) => nameOf(labels, label));
        const same = touched.join('\n') === labels.touched.join('\n');
        if (same) return;
        store.set({ labels: { touched } });
        if (touched.length) this.scene.say(`touches ${touched.join(', ')}`);
    }

    /// Numbers of the labels in a sphere.
    private numbersIn(centre: Vec3, radius: number): Set<number> {
        const { labels } = this.scene.stage;
        const numbers = new Set<number>();
        if (!labels) return numbers;
        const { grid } = labels;
        const step = Math.max(Math.min(...grid.spacing), radius / 12);
        const count = Math.ceil(radius / step);
        for (let k = -count; k <= count; ++k)
            for (let j = -count; j <= count; ++j)
                for (let i = -count; i <= count; ++i) {
                    const off: Vec3 = [i * step, j * step, k * step];
                    if (norm(off) > radius) continue;
                    numbers.add(labels.numberAt(voxelFromWorld(grid, along(centre, 1, off))));
                }
        numbers.delete(0);
        return numbers;
    }
}

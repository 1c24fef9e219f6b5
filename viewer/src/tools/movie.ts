// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Makes, plays and records movies of keyframes. A recording has the canvas of all views while the
// movie plays, without the lines over it.

import {
    isKeyframes,
    type Keyframe,
    lengthOf,
    readKeyframes,
    shotAt,
    writeKeyframes,
} from '../maths/keyframes.ts';
import { nearestStep, roundTo } from '../maths/steps.ts';
import { norm, sub } from '../maths/vec.ts';
import type { State } from '../state/state.ts';
import { scaleOf, valueScale } from '../state/units.ts';
import { saveBlob } from './download.ts';
import type { PathTool } from './path_tool.ts';
import type { Scene } from './scene.ts';
import type { ThresholdTool } from './threshold.ts';

const kSpeed = 20; // of the eye, for the times of new keyframes, in a body [mm/s]
const kShortest = 0.5; // between two keyframes [s]
const kFrameRate = 30;
const kBitsPerSecond = 8_000_000;
// VP8 is cheapest and takes any size; H.264 needs even numbers of pixels.
const kTypes = ['video/webm;codecs=vp8', 'video/webm', 'video/mp4;codecs=avc1', 'video/mp4'];

export class Movie {
    private time = 0;
    private recorder: MediaRecorder | undefined;

    constructor(
        private readonly scene: Scene,
        private readonly path: PathTool,
        private readonly threshold: ThresholdTool,
    ) {}

    private get state(): State {
        return this.scene.store.state;
    }
    private get frames(): readonly Keyframe[] {
        return this.state.movie.keyframes;
    }
    private set(frames: readonly Keyframe[]): void {
        this.stop();
        const keyframes = frames.map((f, i) => (i ? f : { ...f, seconds: 0 }));
        this.scene.store.set({ movie: { keyframes } });
    }

    get isRecording(): boolean {
        return this.recorder !== undefined;
    }

    // --- the list

    /// Appends the present view as a keyframe.
    add(): void {
        const { camera, fieldOfView } = this.state.view;
        const { window, level } = this.state.sections;
        const last = this.frames[this.frames.length - 1];
        const way = last ? norm(sub(camera.eye, last.camera.eye)) : 0;
        const speed = scaleOf(this.state.scan.volume) * kSpeed;
        const seconds = Math.max(Math.round((2 * way) / speed) / 2, 2 * kShortest);
        const { iso } = this.scene.surface;
        this.set([...this.frames, { seconds, camera, fieldOfView, iso, window, level }]);
        this.scene.say(`keyframe ${this.frames.length}`);
    }
    remove(at: number): void {
        this.set(this.frames.filter((_, i) => i !== at));
    }
    /// Moves a keyframe to the front (−1) or to the back (1) by one position.
    move(at: number, by: -1 | 1): void {
        const frames = [...this.frames];
        const [frame, other] = [frames[at], frames[at + by]];
        if (!frame || !other) return;
        // Times keep their positions, so that the length of the movie stays the same.
        frames[at + by] = { ...frame, seconds: other.seconds };
        frames[at] = { ...other, seconds: frame.seconds };
        this.set(frames);
    }
    setSeconds(at: number, seconds: number): void {
        const valid = Math.min(Math.max(Number.isFinite(seconds) ? seconds : 0, kShortest), 600);
        this.set(this.frames.map((f, i) => (i === at ? { ...f, seconds: valid } : f)));
    }
    goTo(at: number): void {
        const frame = this.frames[at];
        if (!frame) return;
        this.stop();
        this.scene.history.step('keyframe', () => this.show(frame));
    }

    // --- playing

    play(): void {
        if (this.state.movie.playing) this.stop();
        else this.start();
    }

    private start(): boolean {
        if (this.frames.length < 2) {
            this.scene.warn('a movie needs at least two keyframes: fly to a place and press Add');
            return false;
        }
        this.path.pause();
        this.time = 0;
        this.scene.history.begin();
        this.scene.store.set({ movie: { playing: true } });
        return true;
    }

    stop(): void {
        if (!this.state.movie.playing) return;
        this.scene.store.set({ movie: { playing: false } });
        this.scene.history.end('movie');
        // The last picture has not been drawn yet.
        const { recorder } = this;
        this.recorder = undefined;
        if (recorder) setTimeout(() => recorder.stop(), 400);
    }

    /// Shows the movie's next picture. @returns whether it is playing
    tick(seconds: number): boolean {
        if (!this.state.movie.playing) return false;
        this.time += seconds;
        this.show(shotAt(this.frames, this.time));
        if (this.time >= lengthOf(this.frames)) this.stop();
        return true;
    }

    private show({ camera, fieldOfView, iso, window, level }: Omit<Keyframe, 'seconds'>): void {
        this.scene.store.set({
            view: { camera, fieldOfView },
            sections: { cursor: camera.eye, window, level },
        });
        // The threshold is shared: it is sent only if it differs.
        const now = this.state.shared?.iso_hu ?? iso;
        const step = nearestStep(valueScale(this.state.scan.volume));
        if (this.state.link.role === 'control' && Math.abs(iso - now) >= step)
            this.threshold.ask({ iso_hu: roundTo(iso, step) });
    }

    // --- recording

    /// Plays the movie from its start and saves it as a file; called again: stops.
    record(): void {
        if (this.recorder) {
            this.stop();
            return;
        }
        const canvas = this.scene.stage.renderer.domElement;
        const type =
            typeof MediaRecorder === 'undefined' || !canvas.captureStream
                ? undefined
                : kTypes.find((t) => MediaRecorder.isTypeSupported(t));
        if (!type) {
            this.scene.say(
                'this browser can’t record; save the keyframes and use pliant render --keyframes',
            );
            return;
        }
        this.stop();
        if (this.frames.length < 2) {
            this.start(); // shows the reason
            return;
        }
        const chunks: Blob[] = [];
        const stream = canvas.captureStream(kFrameRate);
        const recorder = new MediaRecorder(stream, {
            mimeType: type,
            videoBitsPerSecond: kBitsPerSecond,
        });
        recorder.ondataavailable = ({ data }) => chunks.push(data);
        recorder.onstop = () => {
            for (const track of stream.getTracks()) track.stop();
            const kind = type.split(';')[0]!;
            if (!chunks.some((chunk) => chunk.size > 0)) {
                this.scene.warn('the browser recorded no picture; is the machine too busy?');
                return;
            }
            saveBlob(new Blob(chunks, { type: kind }), `pliant.${kind.split('/')[1]}`);
            this.scene.say('the movie is saved');
        };
        recorder.onerror = () => this.scene.warn('the browser could not record the movie');
        this.recorder = recorder;
        recorder.start();
        this.start();
    }

    // --- files

    saveFile(): void {
        const blob = new Blob([writeKeyframes(this.frames)], { type: 'application/json' });
        saveBlob(blob, 'pliant_keyframes.json');
    }
    /// Loads keyframes. @returns whether the text is of keyframes; @throws an Error for invalid
    /// ones
    open(text: string, name: string): boolean {
        if (!isKeyframes(text)) return false;
        this.set(readKeyframes(text, name));
        this.scene.say(`${name}: ${this.frames.length} keyframes`);
        return true;
    }
}

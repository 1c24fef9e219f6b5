// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Makes, plays and records movies of keyframes. What is recorded is what the views show while the
// movie plays: the canvas, without the lines that lie over it.

import {
    isKeyframes,
    type Keyframe,
    lengthOf,
    readKeyframes,
    shotAt,
    writeKeyframes,
} from '../maths/keyframes.ts';
import { norm, sub } from '../maths/vec.ts';
import type { State } from '../state/store.ts';
import type { Session } from './session.ts';

const kSpeed = 20; // of the eye between keyframes that are new [mm/s]
const kShortest = 0.5; // between two keyframes [s]
const kFrameRate = 30;
const kBitsPerSecond = 8_000_000;
// VP8 costs least and takes pictures of any size; H.264 wants even numbers of pixels.
const kTypes = ['video/webm;codecs=vp8', 'video/webm', 'video/mp4;codecs=avc1', 'video/mp4'];

export class Movie {
    private time = 0;
    private recorder: MediaRecorder | undefined;

    constructor(
        private readonly session: Session,
        private readonly setIso: (iso: number) => void,
        private readonly save: (blob: Blob, name: string) => void,
    ) {
        session.playMovie = (dt) => this.tick(dt);
        session.stopMovie = () => this.stop();
    }

    private get state(): Readonly<State> {
        return this.session.store.state;
    }
    private get frames(): readonly Keyframe[] {
        return this.state.keyframes;
    }
    private set(frames: readonly Keyframe[]): void {
        this.stop();
        this.session.store.set({ keyframes: frames.map((f, i) => (i ? f : { ...f, seconds: 0 })) });
    }

    get isRecording(): boolean {
        return this.recorder !== undefined;
    }

    // --- the list

    /// What is shown now, after the last keyframe.
    add(): void {
        const { camera, fieldOfView, window, level, shared } = this.state;
        const last = this.frames[this.frames.length - 1];
        const way = last ? norm(sub(camera.eye, last.camera.eye)) : 0;
        const seconds = Math.max(Math.round((2 * way) / kSpeed) / 2, 2 * kShortest);
        const iso = shared?.iso_hu ?? -500;
        this.set([...this.frames, { seconds, camera, fieldOfView, iso, window, level }]);
        this.session.say(`keyframe ${this.frames.length}`);
    }
    remove(at: number): void {
        this.set(this.frames.filter((_, i) => i !== at));
    }
    /// Earlier (−1) or later (1) by one place.
    move(at: number, by: -1 | 1): void {
        const frames = [...this.frames];
        const [frame, other] = [frames[at], frames[at + by]];
        if (!frame || !other) return;
        // The times stay where they are, so that the movie stays as long.
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
        this.session.history.step('keyframe', () => this.show(frame));
    }

    // --- playing

    play(): void {
        if (this.state.moviePlaying) this.stop();
        else this.start();
    }

    private start(): boolean {
        if (this.frames.length < 2) {
            this.session.say('a movie needs two keyframes or more: fly somewhere, Add');
            return false;
        }
        if (this.state.pathFlying) this.session.togglePath();
        this.time = 0;
        this.session.history.begin();
        this.session.store.set({ moviePlaying: true });
        return true;
    }

    stop(): void {
        if (!this.state.moviePlaying) return;
        this.session.store.set({ moviePlaying: false });
        this.session.history.end('movie');
        // The last picture is still being drawn.
        const { recorder } = this;
        this.recorder = undefined;
        if (recorder) setTimeout(() => recorder.stop(), 400);
    }

    private tick(dt: number): boolean {
        if (!this.state.moviePlaying) return false;
        this.time += dt;
        this.show(shotAt(this.frames, this.time));
        if (this.time >= lengthOf(this.frames)) this.stop();
        return true;
    }

    private show({ camera, fieldOfView, iso, window, level }: Omit<Keyframe, 'seconds'>): void {
        this.session.store.set({ camera, cursor: camera.eye, fieldOfView, window, level });
        // The threshold is shared, and only asked for where it is another one.
        const now = this.state.shared?.iso_hu ?? iso;
        if (this.state.role === 'control' && Math.abs(iso - now) >= 1) this.setIso(Math.round(iso));
    }

    // --- recording

    /// Plays the movie from its start and saves it as a file.
    record(): void {
        if (this.recorder) {
            this.stop();
            return;
        }
        const canvas = this.session.stage.renderer.domElement;
        const type =
            typeof MediaRecorder === 'undefined' || !canvas.captureStream
                ? undefined
                : kTypes.find((t) => MediaRecorder.isTypeSupported(t));
        if (!type) {
            this.session.say(
                'this browser can’t record; save the keyframes and use pliant render --keyframes',
            );
            return;
        }
        this.stop();
        if (this.frames.length < 2) {
            this.start(); // says why not
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
                this.session.say('the browser recorded no picture; is the machine too busy?');
                return;
            }
            this.save(new Blob(chunks, { type: kind }), `pliant.${kind.split('/')[1]}`);
            this.session.say('the movie is saved');
        };
        recorder.onerror = () => this.session.say('the browser could not record the movie');
        this.recorder = recorder;
        recorder.start();
        this.start();
    }

    // --- files

    saveFile(): void {
        const blob = new Blob([writeKeyframes(this.frames)], { type: 'application/json' });
        this.save(blob, 'pliant_keyframes.json');
    }
    /// @returns whether the text is keyframes; throws an Error where they are wrong
    open(text: string, name: string): boolean {
        if (!isKeyframes(text)) return false;
        this.set(readKeyframes(text, name));
        this.session.say(`${name}: ${this.frames.length} keyframes`);
        return true;
    }
}

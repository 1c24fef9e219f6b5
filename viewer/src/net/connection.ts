// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Connection to the server: one WebSocket for commands with answers and frames of voxels. A broken
// connection is resumed, and the server sends the changes since. After a reload of the page the
// session (with its undo steps) is resumed, and all voxels are sent again. A server that answers no
// ping counts as silent until it says something.

import type { CompanyNews, OwnCamera } from './company.ts';
import {
    type Answer,
    type BoxFrame,
    type Command,
    decodeFrame,
    type Done,
    type HapticPose,
    type HapticsNews,
    kCoarseFormat,
    kLabelFormat,
    kProtocol,
    kRestFormat,
    type LabelsNews,
    type MarksNews,
    type Pose,
    type Refusal,
    type Role,
    type Seen,
    type ServerText,
    type SharedState,
    type Tool,
    type VolumeInfo,
    type Welcome,
} from './protocol.ts';
import type { SurfaceFrame, VesselFrame } from './vessel.ts';

export interface Listener {
    welcome(message: Welcome): void;
    newVolume(info: VolumeInfo): void;
    state(state: SharedState): void;
    box(frame: BoxFrame): void;
    coarseBox(frame: BoxFrame): void;
    overlayBox(frame: BoxFrame): void;
    restBox(frame: BoxFrame): void;
    labelBox(frame: BoxFrame): void;
    labels(news: LabelsNews): void;
    marksNews(news: MarksNews): void;
    companyNews(news: CompanyNews): void;
    tools(tools: Tool[]): void;
    haptics(news: HapticsNews): void;
    vesselFrame(frame: SurfaceFrame | VesselFrame): void;
    refused(refusal: Refusal): void;
    /// The connection is lost; with the status lost another attempt follows.
    lost(status: 'lost' | 'ended' | 'refused', reason: string): void;
    /// The server has stopped answering, or answers again.
    silent(is: boolean): void;
    /// A command is done. sent: its time of sending [ms]
    done(answer: Done, sent: number): void;
}

export interface Memory {
    getItem(key: string): string | null;
    setItem(key: string, value: string): void;
}

/// Close codes after which another attempt would fail as well.
const kFinal = new Set([4000, 4005]);
const kRetryMs = [250, 500, 1000, 2000, 4000];
const kPingMs = 1000;
const kSilentMs = 3500; // time without any message after which the server counts as silent
const kResumeKey = 'pliant.resume';

type Waiting = (answer: Answer | undefined) => void;

export class Connection {
    role: Role = 'view';
    client = 0;
    private socket: WebSocket | undefined;
    private readonly waiting = new Map<number, { sent: number; resolve: Waiting }>();
    private nextId = 1;
    private attempts = 0;
    private bye = '';
    private heldVolume = 0; ///< id of the volume in the mirror
    private heldStep: number | undefined;
    private ended = false;
    private heard = 0; ///< time of the last message, or of the attempt to connect [ms]
    private pinged = 0; ///< time of the first ping since then; 0: none
    private ticked = 0; ///< time of the last call of ping() [ms]
    private isSilent = false;
    private listener!: Listener; // set by open()

    constructor(
        private readonly url: string,
        private readonly hello: { role: Role; name: string },
        private readonly memory: Memory,
    ) {}

    /// Connects, and reconnects after each loss.
    open(listener: Listener): void {
        this.listener = listener;
        this.connect();
        setInterval(() => this.ping(), kPingMs);
    }

    private connect(): void {
        const socket = new WebSocket(this.url);
        this.socket = socket;
        this.hear();
        this.pinged = this.heard; // the welcome is awaited
        socket.binaryType = 'arraybuffer';
        socket.onopen = () => this.greet(socket);
        socket.onmessage = (event: MessageEvent) => {
            this.hear();
            try {
                if (typeof event.data === 'string') this.onText(JSON.parse(event.data));
                else this.onFrame(event.data as ArrayBuffer);
            } catch (error) {
                this.ended = true;
                const reason = `invalid message from the server: ${(error as Error).message}`;
                this.listener.lost('ended', reason);
                socket.close();
            }
        };
        socket.onclose = (event: CloseEvent) => this.onClose(socket, event);
    }

    /// Changes the own name: connects again, since clients tell their names at the beginning.
    rename(name: string): void {
        this.hello.name = name;
        if (!this.isOpen) return; // told with the next connection
        const old = this.socket!;
        this.client = 0;
        for (const { resolve } of this.waiting.values()) resolve(undefined);
        this.waiting.clear();
        this.connect();
        old.close();
    }

    close(): void {
        this.ended = true;
        this.socket?.close();
    }

    get isOpen(): boolean {
        return this.socket?.readyState === WebSocket.OPEN && this.client !== 0;
    }

    /// Notes a sign of life.
    private hear(): void {
        this.heard = performance.now();
        this.pinged = 0;
        this.setSilent(false);
    }

    /// Asks for a sign of life. After a pause of the page itself the wait begins again: messages
    /// that have arrived meanwhile come later than this call.
    private ping(): void {
        const now = performance.now();
        const paused = now - this.ticked > 2 * kPingMs;
        this.ticked = now;
        if (this.pinged && paused) this.pinged = now;
        if (this.ended || !this.socket || this.socket.readyState > WebSocket.OPEN) return;
        if (this.pinged && now - this.pinged > kSilentMs) this.setSilent(true);
        if (this.pinged || this.client === 0) return;
        this.pinged = now;
        this.socket.send(JSON.stringify({ do: 'ping' }));
    }

    private setSilent(is: boolean): void {
        if (is === this.isSilent) return;
        this.isSilent = is;
        this.listener.silent(is);
    }

    /// Sends a command. @returns the answer; undefined if the connection was lost before
    /// @param arrived  called synchronously with the answer, before any later message
    ask(
        command: Command,
        arrived?: (answer: Answer | undefined) => void,
    ): Promise<Answer | undefined> {
        if (!this.isOpen) return Promise.resolve(undefined);
        const id = this.nextId++;
        this.socket!.send(JSON.stringify({ ...command, id }));
        return new Promise((resolve) =>
            this.waiting.set(id, {
                sent: performance.now(),
                resolve: (answer) => {
                    arrived?.(answer);
                    resolve(answer);
                },
            }),
        );
    }

    tell(message: Pose | Seen | HapticPose | OwnCamera): void {
        if (this.isOpen) this.socket!.send(JSON.stringify(message));
    }

    private greet(socket: WebSocket): void {
        const resume = this.memory.getItem(kResumeKey) ?? undefined;
        const step = resume && this.heldStep !== undefined ? { step: this.heldStep } : {};
        socket.send(
            JSON.stringify({
                do: 'hello',
                protocol: kProtocol,
                lz4: false,
                coarse: true,
                ...this.hello,
                ...(resume ? { resume } : {}),
                ...step,
            }),
        );
    }

    private onText(message: ServerText): void {
        switch (message.t) {
            case 'welcome':
                this.attempts = 0;
                this.client = message.client;
                this.role = message.role;
                this.memory.setItem(kResumeKey, message.resume);
                if (!message.resumed || message.volume.id !== this.heldVolume)
                    this.heldStep = undefined;
                this.heldVolume = message.volume.id;
                this.listener.welcome(message);
                break;
            case 'volume':
                this.heldVolume = message.id;
                this.heldStep = undefined;
                this.listener.newVolume(message);
                break;
            case 'state':
                this.listener.state(message);
                break;
            case 'haptics':
                this.listener.haptics(message);
                break;
            case 'labels':
                this.listener.labels(message);
                break;
            case 'marks':
            case 'mark':
                this.listener.marksNews(message);
                break;
            case 'camera':
            case 'replay':
            case 'replay_marks':
                this.listener.companyNews(message);
                break;
            case 'error':
                this.answer(message.id, message);
                this.listener.refused(message);
                break;
            case 'done':
            case 'checksum':
            case 'path':
                this.answer(message.id, message);
                break;
            case 'bye':
                this.bye = message.message;
                break;
            case 'pong':
                break;
        }
    }

    private answer(id: number, message: Answer): void {
        const asked = this.waiting.get(id);
        this.waiting.delete(id);
        if (asked && message.t === 'done') this.listener.done(message, asked.sent);
        asked?.resolve(message);
    }

    private onFrame(buffer: ArrayBuffer): void {
        const frame = decodeFrame(buffer);
        if (frame.kind === 'tools') {
            this.listener.tools(frame.tools);
            return;
        }
        if (frame.volume !== this.heldVolume) return;
        if (frame.kind !== 'box') {
            this.listener.vesselFrame(frame);
            return;
        }
        if (frame.format !== 1) {
            if (frame.format === kCoarseFormat) {
                this.listener.coarseBox(frame);
                return;
            }
            if (frame.format === kRestFormat) this.listener.restBox(frame);
            else if (frame.format === kLabelFormat) this.listener.labelBox(frame);
            else this.listener.overlayBox(frame);
            const { step, format } = frame;
            if (frame.last) this.tell({ do: 'seen', step, format });
            return;
        }
        this.listener.box(frame);
        if (frame.last) {
            this.heldStep = frame.step;
            this.tell({ do: 'seen', step: frame.step });
        }
    }

    private onClose(socket: WebSocket, event: CloseEvent): void {
        if (socket !== this.socket) return;
        const wasOpen = this.client !== 0;
        this.client = 0;
        this.pinged = 0;
        this.setSilent(false);
        for (const { resolve } of this.waiting.values()) resolve(undefined);
        this.waiting.clear();
        if (this.ended) return;
        void this.comeBack(event, wasOpen);
    }

    private async comeBack(event: CloseEvent, wasOpen: boolean): Promise<void> {
        const why = this.bye || event.reason || 'the connection to the server is lost';
        this.bye = '';
        if (kFinal.has(event.code)) {
            this.listener.lost('ended', why);
            return;
        }
        const wait = kRetryMs[Math.min(this.attempts++, kRetryMs.length - 1)]!;
        this.listener.lost('lost', why);
        if (!wasOpen && (await this.isRefused())) {
            this.listener.lost('refused', 'this link is not valid, or no longer');
            return;
        }
        setTimeout(() => this.connect(), wait);
    }

    /// Tests whether the server refuses the link's token: browsers don't tell why a WebSocket was
    /// not opened.
    private async isRefused(): Promise<boolean> {
        const url = new URL(this.url);
        url.protocol = url.protocol.replace('ws', 'http');
        url.pathname = url.pathname.replace(/ws$/, 'save/');
        try {
            return (await fetch(url)).status === 403;
        } catch {
            return false; // no answer comes
        }
    }
}

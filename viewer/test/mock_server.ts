// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Mock of `pliant serve` for tests of the page: docs/developers/protocol.md with the files of
// dist/, one scene, several clients, undo, checksums, resuming, opening and saving.

import { readFile } from 'node:fs/promises';
import { createServer, type IncomingMessage, type Server, type ServerResponse } from 'node:http';
import { join } from 'node:path';
import { type Box, boxCount } from '../src/maths/grid.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { Path } from '../src/maths/path.ts';
import { norm, sub, type Vec3 } from '../src/maths/vec.ts';
import { kLabelFormat, kRestFormat } from '../src/net/protocol.ts';
import { kRestStep, restCounts } from '../src/views/rest_field.ts';
import { kGrid, kTubeRadius, MockScene, tubeCentre } from './mock_scene.ts';
import { MockReplay, type RecordedPush } from './mock_replay.ts';
import { MockSocket } from './mock_socket.ts';

const kSlab = 8; // slices in a box of a snapshot
const kTypes: Record<string, string> = {
    html: 'text/html; charset=utf-8',
    js: 'text/javascript',
    css: 'text/css',
    txt: 'text/plain',
};
const kFeatures = ['save', 'open', 'overlay', 'path', 'rest', 'labels', 'marks', 'follow'];
// The real server's policy, which tests/hub/test_hostile.cpp has too.
const kPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; " +
    "connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

// eslint-disable-next-line @typescript-eslint/no-explicit-any
type Message = Record<string, any>;

interface Client {
    socket: MockSocket;
    number: number;
    role: 'control' | 'view';
    name: string;
    resume: string;
    tool: Buffer | undefined;
    overlay: string;
    rest: boolean;
    labels: boolean;
    marks: boolean;
    camera: Message;
    leader: number; ///< client that is followed; 0: none
}

/// Grows a box by a voxel on each side: volume changes depend on neighbours.
const grown = (box: Box): Box => ({
    begin: box.begin.map((b) => Math.max(b - 1, 0)) as unknown as Vec3,
    end: box.end.map((e, a) => Math.min(e + 1, kGrid.size[a]!)) as unknown as Vec3,
});

/// Path along the tube's centre, or an error about its ends.
function tubeWay(from: Vec3, to: Vec3): object | string {
    for (const [name, end] of Object.entries({ from, to }))
        if (norm(sub(end, tubeCentre(end[2]))) > kTubeRadius + 5)
            return `path: ${name}: expected a position in the lumen, found one in the tissue`;
    const count = Math.max(Math.ceil(Math.abs(to[2] - from[2]) / 2), 1);
    const points = Array.from({ length: count + 1 }, (_, i) =>
        tubeCentre(from[2] + (i / count) * (to[2] - from[2])),
    );
    const length_mm = new Path(points).length;
    return { length_mm, points, radii: points.map(() => kTubeRadius) };
}

export class MockServer {
    scene = new MockScene();
    token = 'mock';
    private frozen = false;
    private unheard: (() => void)[] = []; ///< messages while it was frozen
    private volumeId = 1;
    private scanName = 'mock tube';
    /// File names of uploads in parts.
    readonly parts: string[] = [];
    private readonly clients = new Set<Client>();
    private readonly known = new Map<string, { number: number; name: string; missed: boolean }>();
    private nextNumber = 1;
    overlaysSeen = 0;
    restsSeen = 0;
    private readonly marks = new Map<string, Message>();
    private relaxing = false;
    private replay: MockReplay | undefined;
    private readonly server: Server;

    constructor(private readonly folder: string) {
        this.server = createServer((request, response) => {
            if (/^\/(open|save)\b/.test(request.url ?? '')) {
                void this.transfer(request, response);
                return;
            }
            const name = (request.url ?? '/').split('?')[0]!.slice(1) || 'index.html';
            readFile(join(this.folder, name.replaceAll('..', ''))).then(
                (data) => {
                    response.writeHead(200, {
                        'Content-Type': kTypes[name.split('.').pop()!] ?? 'text/plain',
                        'Content-Security-Policy': kPolicy,
                    });
                    response.end(data);
                },
                () => response.writeHead(404).end(),
            );
        });
        this.server.on('upgrade', (request, stream) => {
            if (!request.url?.includes(`token=${this.token}`))
                stream.end('HTTP/1.1 403 Forbidden\r\n\r\n');
            else this.greet(new MockSocket(request, stream));
        });
        this.watchScene();
    }

    private watchScene(): void {
        this.scene.onChange = (box) => {
            for (const place of this.known.values()) place.missed = true;
            for (const client of this.clients) {
                this.sendBox(client, box, true);
                if (client.overlay !== 'none') this.sendOverlay(client, grown(box));
                if (client.rest) this.sendRest(client, box);
                if (client.labels && this.scene.labels) this.sendLabels(client, box);
            }
        };
    }

    /// Opens a file: anything that begins like a NRRD is the same tube under another name.
    private async transfer(request: IncomingMessage, response: ServerResponse): Promise<void> {
        const url = new URL(request.url!, 'http://mock');
        const name = url.searchParams.get('name') ?? '';
        const pieces: Buffer[] = [];
        for await (const piece of request) pieces.push(piece as Buffer);
        const body = Buffer.concat(pieces);
        const answer = (status: number, line: string): void => {
            response.writeHead(status, { 'Content-Type': 'text/plain' }).end(`${line}\n`);
        };
        if (url.searchParams.get('token') !== this.token) answer(403, 'token: wrong');
        else if (url.pathname.startsWith('/save/'))
            response
                .writeHead(200, { 'Content-Type': 'application/octet-stream' })
                .end(Buffer.alloc(1000, url.pathname));
        else if (url.pathname === '/open/part') {
            this.parts.push(name);
            answer(200, 'taken');
        } else if (url.pathname === '/open/labels') {
            const fault = this.scene.readLabels(name, body);
            if (fault) answer(400, fault);
            else {
                for (const client of this.clients) if (client.labels) this.tellLabels(client);
                answer(200, 'opened');
            }
        } else if (url.pathname === '/open' && !body.toString('latin1').startsWith('NRRD'))
            answer(400, `${name}: is no NRRD file`);
        else {
            this.openScan(name);
            answer(200, 'opened');
        }
    }

    private openScan(name: string): void {
        const { step } = this.scene;
        this.scene = new MockScene();
        this.scene.step = step + 1;
        this.watchScene();
        ++this.volumeId;
        this.marks.clear();
        this.scanName = name;
        for (const client of this.clients) {
            client.tool = undefined;
            client.labels = client.marks = false;
            client.socket.text({ t: 'volume', ...this.volume() });
            this.sendSnapshot(client);
        }
        this.sendState();
    }

    /// Starts the server. @returns its link
    async start(): Promise<string> {
        await new Promise<void>((resolve) => this.server.listen(0, '127.0.0.1', resolve));
        const { port } = this.server.address() as { port: number };
        return `http://127.0.0.1:${port}/#token=${this.token}`;
    }

    /// Shows a recorded session to all clients, after they have connected again.
    watch(pushes: readonly RecordedPush[], length: number): void {
        this.scene.reset();
        this.replay = new MockReplay(this.scene, pushes, length, () => {
            for (const client of this.clients) client.socket.text(this.replay!.news());
        });
        this.breakLines();
    }

    stop(): void {
        this.replay?.stop();
        this.breakLines();
        this.server.close();
        this.server.closeAllConnections();
    }

    /// Answers nothing, or goes on with all messages since.
    freeze(on: boolean): void {
        this.frozen = on;
        if (!on) for (const hear of this.unheard.splice(0)) hear();
    }

    /// Ends all connections without a close frame.
    breakLines(): void {
        for (const client of this.clients) client.socket.cut();
        this.clients.clear();
    }

    private greet(socket: MockSocket): void {
        let client: Client | undefined;
        socket.onText = (text) => {
            const message = JSON.parse(text) as Message;
            const hear = (): void => {
                if (client) this.carryOut(client, message);
                else client = this.welcome(socket, message);
            };
            if (this.frozen) this.unheard.push(hear);
            else hear();
        };
        socket.onClose = () => {
            if (!client) return;
            this.clients.delete(client);
            const { number, name } = client;
            this.known.set(client.resume, { number, name, missed: false });
            client.camera = {};
            this.tellCamera(client);
            for (const other of this.clients) if (other.leader === number) other.leader = 0;
            this.sendTools();
            this.sendState();
        };
    }

    private welcome(socket: MockSocket, hello: Message): Client {
        const place = this.known.get(hello.resume ?? '');
        const resumed = place !== undefined && hello.step !== undefined;
        const client: Client = {
            socket,
            number: place?.number ?? this.nextNumber++,
            role: hello.role === 'view' ? 'view' : 'control',
            name: String(hello.name || (place?.name ?? '')),
            resume: place ? hello.resume : Math.random().toString(36).slice(2),
            tool: undefined,
            overlay: 'none',
            rest: false,
            labels: false,
            marks: false,
            camera: {},
            leader: 0,
        };
        this.clients.add(client);
        socket.text({
            t: 'welcome',
            protocol: 2,
            program: 'mock 1',
            client: client.number,
            role: client.role,
            resume: client.resume,
            resumed,
            rate_hz: 60,
            features: this.replay ? [...kFeatures, 'replay'] : kFeatures,
            open_bytes: 100_000_000,
            volume: this.volume(),
            state: this.state(),
        });
        if (!resumed) this.sendSnapshot(client);
        else if (place.missed) this.sendBox(client, { begin: [0, 0, 0], end: kGrid.size }, true);
        this.sendState();
        if (this.replay) {
            socket.text(this.replay.marks());
            socket.text(this.replay.news());
        }
        return client;
    }

    private volume(): object {
        const eye = tubeCentre(-20);
        return {
            id: this.volumeId,
            name: this.scanName,
            size: kGrid.size,
            spacing_mm: kGrid.spacing,
            origin_mm: kGrid.origin,
            direction: kGrid.direction,
            range_hu: [-1000, 800],
            start: { eye_mm: eye, look: [0, 0, 1], up: [0, -1, 0] },
            landmarks: [
                {
                    name: 'middle',
                    point_mm: tubeCentre(0),
                    push_mm: [4, 0, 0],
                    eye_mm: tubeCentre(0),
                    look: [0, 0, 1],
                },
            ],
        };
    }

    private state(): object {
        const { scene } = this;
        const last = (steps: { name: string }[]): object => ({
            steps: steps.length,
            next: steps[steps.length - 1]?.name ?? '',
        });
        return {
            step: scene.step,
            iso_hu: scene.iso,
            polarity: scene.polarity,
            materials: scene.materials,
            relaxing: this.relaxing,
            settled: true,
            holder: 0,
            undo: last(scene.undoSteps),
            redo: last(scene.redoSteps),
            clients: [...this.clients].map((c) => ({
                client: c.number,
                name: c.name,
                role: c.role,
            })),
            timing: { solve_ms: 1, resample_ms: 1, tick_ms: 2, moved_elements: 1000 },
        };
    }

    private sendState(): void {
        for (const client of this.clients) client.socket.text({ t: 'state', ...this.state() });
    }

    private sendSnapshot(client: Client): void {
        const [nx, ny, nz] = kGrid.size;
        for (let k = 0; k < nz; k += kSlab) {
            const end = Math.min(k + kSlab, nz);
            this.sendBox(client, { begin: [0, 0, k], end: [nx, ny, end] }, end === nz);
        }
    }

    private tellLabels(client: Client): void {
        const { labels } = this.scene;
        const list = (labels?.values ?? []).map((value, n) => ({
            value,
            name: labels!.names.get(value) ?? '',
            voxels: labels!.at.filter((x) => x === n + 1).length,
            centre_mm: [0, 0, 0],
        }));
        const name = labels?.name ?? '';
        client.socket.text({ t: 'labels', volume: this.volumeId, name, labels: list });
        if (labels) this.sendLabels(client, { begin: [0, 0, 0], end: kGrid.size });
    }

    private sendLabels(client: Client, box: Box): void {
        this.sendBox(client, box, true, kLabelFormat, (i) => halfOfFloat(this.scene.labelAt(i)));
    }

    private sendOverlay(client: Client, box: Box): void {
        const { overlay } = client;
        this.sendBox(client, box, true, overlay === 'displacement' ? 2 : 3, (i) =>
            halfOfFloat(this.scene.overlayAt(overlay, i)),
        );
    }

    /// Box of the nodes whose voxels lie in a box.
    private sendRest(client: Client, voxels: Box): void {
        const counts = restCounts(kGrid);
        const begin = voxels.begin.map((b) => Math.ceil(b / kRestStep));
        const end = voxels.end.map((e, a) =>
            e >= kGrid.size[a]! ? counts[a]! : Math.ceil(e / kRestStep),
        );
        const halves: number[] = [];
        for (let k = begin[2]!; k < end[2]!; ++k)
            for (let j = begin[1]!; j < end[1]!; ++j)
                for (let i = begin[0]!; i < end[0]!; ++i) {
                    const [x, y, z] = [i, j, k].map((n, a) =>
                        Math.min(kRestStep * n, kGrid.size[a]! - 1),
                    );
                    const at = x! + kGrid.size[0] * (y! + kGrid.size[1] * z!);
                    halves.push(...this.scene.restAt(at).map(halfOfFloat));
                }
        if (!halves.length) return;
        const frame = Buffer.alloc(32 + 2 * halves.length);
        this.head(frame, 1, 2, kRestFormat);
        for (let a = 0; a < 3; ++a) {
            frame.writeUInt16LE(begin[a]!, 16 + 2 * a);
            frame.writeUInt16LE(end[a]! - begin[a]!, 22 + 2 * a);
        }
        halves.forEach((half, n) => frame.writeUInt16LE(half, 32 + 2 * n));
        client.socket.binary(frame);
    }

    private sendBox(
        client: Client,
        box: Box,
        last: boolean,
        format = 1,
        halfAt = (i: number): number => this.scene.halves[i]!,
    ): void {
        const frame = Buffer.alloc(32 + 2 * boxCount(box));
        this.head(frame, 1, last ? 2 : 0, format);
        for (let a = 0; a < 3; ++a) {
            frame.writeUInt16LE(box.begin[a]!, 16 + 2 * a);
            frame.writeUInt16LE(box.end[a]! - box.begin[a]!, 22 + 2 * a);
        }
        let at = 32;
        const [nx, ny] = kGrid.size;
        for (let k = box.begin[2]; k < box.end[2]; ++k)
            for (let j = box.begin[1]; j < box.end[1]; ++j)
                for (let i = box.begin[0]; i < box.end[0]; ++i, at += 2)
                    frame.writeUInt16LE(halfAt(i + nx * (j + ny * k)), at);
        client.socket.binary(frame);
    }

    private head(frame: Buffer, type: number, flags: number, format: number): void {
        frame.write('PLNT', 0, 'latin1');
        frame[4] = type;
        frame[5] = flags;
        frame.writeUInt16LE(format, 6);
        frame.writeUInt32LE(this.scene.step, 8);
        frame.writeUInt32LE(this.volumeId, 12);
        frame.writeUInt32LE(frame.length - 32, 28);
    }

    private sendTools(): void {
        const tools = [...this.clients].flatMap((c) => (c.tool ? [c.tool] : []));
        const frame = Buffer.concat([Buffer.alloc(32), ...tools]);
        this.head(frame, 2, 0, tools.length);
        for (const client of this.clients) client.socket.binary(frame);
    }

    /// Sends a camera to its followers. @param only  one of them
    private tellCamera(of: Client, only?: Client): void {
        const news = { t: 'camera', client: of.number, ...of.camera };
        for (const client of only ? [only] : this.clients)
            if (client.leader === of.number) client.socket.text(news);
    }

    private takeTool(client: Client, m: Message): void {
        const tool = Buffer.alloc(80);
        tool.writeUInt32LE(client.number, 0);
        tool[4] = m.kind === 'sphere' ? 2 : 1;
        const vectors = [m.position, m.direction, m.up ?? [0, 0, 1]] as Vec3[];
        vectors.forEach((v, i) => v.forEach((x, a) => tool.writeFloatLE(x, 8 + 12 * i + 4 * a)));
        tool.writeFloatLE(m.radius ?? 0, 44);
        tool.writeFloatLE(1, 72);
        client.tool = m.kind === 'none' ? undefined : tool;
        this.sendTools();
    }

    private carryOut(client: Client, m: Message): void {
        const { scene } = this;
        const done = (more: object = {}): void => {
            const answer = { t: 'done', id: m.id ?? 0, do: m.do, step: scene.step };
            client.socket.text({ ...answer, status: 'applied', step_fraction: 1, ...more });
            this.sendState();
        };
        const refuse = (code: string, message: string): void =>
            client.socket.text({ t: 'error', id: m.id ?? 0, do: m.do, code, message });
        const free = ['tool', 'checksum', 'seen', 'ping', 'overlay', 'rest', 'path'];
        free.push('labels', 'marks', 'camera', 'follow');
        if (this.replay && m.do !== 'replay' && !free.includes(m.do)) {
            refuse('watched', `${m.do}: a session is watched`);
            return;
        }
        if (client.role === 'view' && !free.includes(m.do)) {
            refuse('view_only', 'this link can only view');
            return;
        }
        const stroke = m.stroke ? `${client.number}/${m.stroke}` : '';
        switch (m.do) {
            case 'push':
            case 'slide':
                scene.remember('push', stroke);
                scene.push(m.point, m.push, m.radius);
                done({ grabbed_elements: 100, moved_elements: 1000, force_n: [1, 2, 2] });
                break;
            case 'grab':
                scene.grab(m.point, m.radius);
                done({ grabbed_elements: 100 });
                break;
            case 'drag':
                if (scene.drag(m.offset)) done({ moved_elements: 1000 });
                else refuse('not_holding', 'nothing is held');
                break;
            case 'let_go':
            case 'release':
                scene.letGo();
                done();
                break;
            case 'cut':
                scene.remember('cut', '');
                done({ cut_links: scene.cut(m.line, m.depth) });
                break;
            case 'carve':
                scene.remember('carve', stroke);
                done({ carved_elements: scene.carve(m.from, m.to, m.radius) });
                break;
            case 'relax':
                this.relaxing = m.on;
                done();
                break;
            case 'reset':
                scene.remember('reset', '');
                scene.reset();
                done();
                break;
            case 'materials': {
                const { do: _, id: __, ...values } = m;
                scene.remember('materials', '');
                scene.materials = { ...scene.materials, ...values };
                done();
                break;
            }
            case 'iso':
                scene.remember('iso', `iso${Math.floor(Date.now() / 1000)}`);
                scene.iso = m.iso_hu ?? scene.iso;
                scene.polarity = m.polarity ?? scene.polarity;
                done();
                break;
            case 'undo':
            case 'redo': {
                const { undoSteps, redoSteps } = scene;
                const back = m.do === 'undo';
                const worked = back
                    ? scene.back(undoSteps, redoSteps)
                    : scene.back(redoSteps, undoSteps);
                if (worked) done();
                else refuse('nothing', `nothing to ${m.do}`);
                break;
            }
            case 'checksum': {
                const voxels = scene.checksum();
                const answer = { t: 'checksum', id: m.id, step: scene.step, voxels };
                client.socket.text({ ...answer, volume: voxels, tissue: voxels });
                break;
            }
            case 'overlay':
                client.overlay = m.kind;
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                if (m.kind !== 'none' && scene.step > 1)
                    this.sendOverlay(client, { begin: [0, 0, 0], end: kGrid.size });
                break;
            case 'rest':
                client.rest = m.on;
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                if (m.on && scene.step > 1)
                    this.sendRest(client, { begin: [0, 0, 0], end: kGrid.size });
                break;
            case 'labels':
                client.labels = m.on;
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                this.tellLabels(client);
                break;
            case 'marks':
                client.marks = m.on;
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                client.socket.text({ t: 'marks', marks: [...this.marks.values()] });
                break;
            case 'mark': {
                const { do: _, id: __, ...mark } = m;
                if (m.kind === 'none') this.marks.delete(m.key);
                else this.marks.set(m.key, mark);
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                for (const other of this.clients)
                    if (other !== client && other.marks) other.socket.text({ t: 'mark', ...mark });
                break;
            }
            case 'seen':
                if (m.format === kRestFormat) ++this.restsSeen;
                else if (m.format === kLabelFormat) break;
                else if (m.format) ++this.overlaysSeen;
                break;
            case 'path': {
                const way = tubeWay(m.from, m.to);
                if (typeof way === 'string') refuse('out_of_range', way);
                else {
                    const { step } = scene;
                    client.socket.text({ t: 'path', id: m.id, step, volume: 1, ...way });
                }
                break;
            }
            case 'replay':
                this.replay?.take(m);
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                break;
            case 'camera': {
                const { do: _, ...camera } = m;
                client.camera = camera;
                this.tellCamera(client);
                break;
            }
            case 'follow': {
                const leader = [...this.clients].find((c) => c.number === m.client);
                if (m.client && (!leader || leader === client)) {
                    refuse('out_of_range', `follow: client: found ${m.client}`);
                    break;
                }
                client.leader = m.client;
                client.socket.text({ t: 'done', id: m.id, do: m.do, step: scene.step });
                if (leader?.camera.eye) this.tellCamera(leader, client);
                break;
            }
            case 'tool':
                this.takeTool(client, m);
                break;
            case 'ping':
                client.socket.text({ t: 'pong', id: m.id ?? 0 });
                break;
        }
    }
}

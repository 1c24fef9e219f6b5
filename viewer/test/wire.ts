// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A client without a page: it takes the voxels, counts their bytes, and acknowledges them at once.
// So measurements of a line aren't those of a browser that draws in software.

import { randomBytes } from 'node:crypto';
import { request } from 'node:http';
import type { Duplex } from 'node:stream';
import {
    type BoxFrame,
    type Command,
    decodeFrame,
    type ServerText,
    type SharedState,
} from '../src/net/protocol.ts';

export class Wire {
    state: SharedState | undefined;
    size: readonly number[] = []; ///< of the volume [voxels]
    /// Called for each box of voxels, before it is acknowledged.
    onBox: (box: BoxFrame, bytes: number) => void = () => {};
    private readonly waiting = new Map<number, (answer: ServerText) => void>();
    private lastId = 0;
    private parts: Buffer[] = [];
    private held = 0; ///< bytes of the parts

    private constructor(private readonly stream: Duplex) {
        stream.on('data', (data: Buffer) => this.take(data));
        stream.on('error', () => stream.destroy());
    }

    /// Connects, and waits for the welcome. @param port  of a line to the server
    static async open(link: string, port?: number): Promise<Wire> {
        const { origin, host, hostname, port: own, hash } = new URL(link);
        const token = new URLSearchParams(hash.slice(1)).get('token');
        const stream = await new Promise<Duplex>((resolve, reject) => {
            const asked = request({
                hostname,
                port: port ?? own,
                path: `/ws?token=${token}`,
                headers: {
                    Host: host,
                    Connection: 'Upgrade',
                    Upgrade: 'websocket',
                    Origin: origin,
                    'Sec-WebSocket-Key': randomBytes(16).toString('base64'),
                    'Sec-WebSocket-Version': '13',
                },
            });
            asked.on('upgrade', (_, socket) => resolve(socket));
            asked.on('response', (answer) => reject(new Error(`refused: ${answer.statusCode}`)));
            asked.on('error', reject);
            asked.end();
        });
        const wire = new Wire(stream);
        wire.tell({ do: 'hello', protocol: 2, name: 'wire', lz4: false });
        while (!wire.state) await new Promise((done) => setTimeout(done, 10));
        return wire;
    }

    tell(message: object): void {
        const body = Buffer.from(JSON.stringify(message));
        const mask = randomBytes(4);
        const head = Buffer.alloc(body.length < 126 ? 2 : 4);
        head[0] = 0x81;
        head[1] = 0x80 | Math.min(body.length, 126);
        if (body.length >= 126) head.writeUInt16BE(body.length, 2);
        for (let n = 0; n < body.length; ++n) body[n]! ^= mask[n & 3]!;
        this.stream.write(Buffer.concat([head, mask, body]));
    }

    ask(command: Command): Promise<ServerText> {
        const id = ++this.lastId;
        return new Promise((resolve) => {
            this.waiting.set(id, resolve);
            this.tell({ ...command, id });
        });
    }

    close(): void {
        this.stream.destroy();
    }

    private take(data: Buffer): void {
        this.parts.push(data);
        this.held += data.length;
        for (;;) {
            if (this.held < 2 || this.parts[0]!.length < 10) this.join();
            const head = this.parts[0]!;
            if (head.length < 2) return;
            const short = head[1]! & 127;
            const at = short < 126 ? 2 : short === 126 ? 4 : 10;
            if (head.length < at) return;
            const size =
                short < 126
                    ? short
                    : short === 126
                      ? head.readUInt16BE(2)
                      : Number(head.readBigUInt64BE(2));
            if (this.held < at + size) return;
            this.join();
            const all = this.parts[0]!;
            this.parts = [all.subarray(at + size)];
            this.held = this.parts[0]!.length;
            this.message(all[0]! & 15, all.subarray(at, at + size));
        }
    }
    private join(): void {
        if (this.parts.length !== 1) this.parts = [Buffer.concat(this.parts)];
    }

    private message(code: number, body: Buffer): void {
        if (code === 1) return this.text(JSON.parse(body.toString()) as ServerText);
        if (code === 9) return this.pong();
        if (code !== 2) return;
        const copy = new Uint8Array(body);
        const frame = decodeFrame(copy.buffer);
        if (frame.kind !== 'box' || frame.format !== 1) return;
        this.onBox(frame, body.length);
        if (frame.last) this.tell({ do: 'seen', step: frame.step });
    }
    private text(message: ServerText): void {
        if (message.t === 'state') this.state = message;
        if (message.t === 'welcome') {
            this.size = message.volume.size;
            this.state = message.state;
        }
        const id = (message as { id?: number }).id;
        if (id === undefined) return;
        this.waiting.get(id)?.(message);
        this.waiting.delete(id);
    }
    private pong(): void {
        this.stream.write(Buffer.concat([Buffer.from([0x8a, 0x80]), randomBytes(4)]));
    }
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Server side of a WebSocket, as far as the mock needs it: unfragmented frames, no extensions.

import { createHash } from 'node:crypto';
import type { IncomingMessage } from 'node:http';
import type { Duplex } from 'node:stream';

const kMagic = '258EAFA5-E914-47DA-95CA-C5AB0DC85B11';

export class MockSocket {
    onText: (text: string) => void = () => {};
    onClose: () => void = () => {};
    private held = Buffer.alloc(0);

    constructor(
        request: IncomingMessage,
        private readonly stream: Duplex,
    ) {
        const key = request.headers['sec-websocket-key'] + kMagic;
        const accept = createHash('sha1').update(key).digest('base64');
        stream.write(
            'HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n' +
                `Connection: Upgrade\r\nSec-WebSocket-Accept: ${accept}\r\n\r\n`,
        );
        stream.on('data', (data: Buffer) => this.take(data));
        stream.on('close', () => this.onClose());
        stream.on('error', () => stream.destroy());
    }

    text(message: object): void {
        this.frame(1, Buffer.from(JSON.stringify(message)));
    }
    binary(data: Buffer): void {
        this.frame(2, data);
    }
    /// Ends the connection without a close frame.
    cut(): void {
        this.stream.destroy();
    }

    private frame(code: number, data: Buffer): void {
        if (this.stream.destroyed) return;
        const head = Buffer.alloc(10);
        head[0] = 0x80 | code;
        let length = 2;
        if (data.length < 126) head[1] = data.length;
        else if (data.length < 65536) {
            head[1] = 126;
            head.writeUInt16BE(data.length, 2);
            length = 4;
        } else {
            head[1] = 127;
            head.writeBigUInt64BE(BigInt(data.length), 2);
            length = 10;
        }
        this.stream.write(Buffer.concat([head.subarray(0, length), data]));
    }

    private take(data: Buffer): void {
        this.held = Buffer.concat([this.held, data]);
        while (this.held.length >= 6) {
            let size = this.held[1]! & 127;
            let at = 2;
            if (size === 126) {
                size = this.held.readUInt16BE(2);
                at = 4;
            }
            if (this.held.length < at + 4 + size) return;
            const mask = this.held.subarray(at, at + 4);
            const body = Buffer.from(this.held.subarray(at + 4, at + 4 + size));
            for (let i = 0; i < size; ++i) body[i]! ^= mask[i & 3]!;
            const code = this.held[0]! & 15;
            this.held = this.held.subarray(at + 4 + size);
            if (code === 1) this.onText(body.toString());
            if (code === 8) this.stream.end();
        }
    }
}

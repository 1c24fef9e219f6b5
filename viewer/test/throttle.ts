// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// A slow line: a TCP proxy that passes a limited number of bytes per second to the client. It
// holds little, so that the server feels the line.

import { type AddressInfo, createServer, Socket } from 'node:net';

const kPiece = 16 * 1024; ///< bytes that are passed at once

export interface Line {
    readonly port: number;
    /// Bytes per second from the server to all clients together; Infinity: no limit.
    rate: number;
    /// Port of the server; set it before the first client connects.
    target: number;
    stop(): void;
}

export async function slowLine(rate: number): Promise<Line> {
    const sockets = new Set<Socket>();
    let free = 0; // time at which the line is idle again [ms]
    const server = createServer({ highWaterMark: kPiece }, (client) => {
        const far = new Socket({ highWaterMark: kPiece } as object);
        far.connect(line.target, '127.0.0.1');
        for (const socket of [client, far]) {
            sockets.add(socket);
            socket.setNoDelay(true);
            socket.on('error', () => socket.destroy());
            socket.on('close', () => {
                sockets.delete(socket);
                client.destroy();
                far.destroy();
            });
        }
        client.pipe(far);
        far.on('data', (data: Buffer) => {
            client.write(data);
            const now = performance.now();
            free = Math.max(free, now) + (1000 * data.length) / line.rate;
            const wait = free - now;
            if (wait < 2) return; // timers aren't finer
            far.pause();
            setTimeout(() => far.resume(), wait);
        });
    });
    const line: Line = {
        port: 0,
        rate,
        target: 0,
        stop: () => {
            for (const socket of sockets) socket.destroy();
            server.close();
        },
    };
    await new Promise<void>((done) => server.listen(0, '127.0.0.1', done));
    return Object.assign(line, { port: (server.address() as AddressInfo).port });
}

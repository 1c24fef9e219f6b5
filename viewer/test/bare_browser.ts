// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Browser for measurements: one page, driven by the DevTools protocol over two pipes. Playwright
// receives all WebSocket messages with their bytes, which costs half a core at 30 Hz; here
// functions are run in the page, and nothing else.

import { type ChildProcess, spawn } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Readable, Writable } from 'node:stream';
import { findChromium, kArguments, keepTissue } from './browser.ts';

const kPatience = 3000; // tenths of a second until a page is ready

/// Runs functions in a page, as Playwright's pages do.
export interface Evaluator {
    evaluate<R>(run: () => R | Promise<R>): Promise<R>;
    evaluate<R, A>(run: (argument: A) => R | Promise<R>, argument: A): Promise<R>;
}

interface Reply {
    id?: number;
    error?: { message: string };
    result?: any;
}

export class BareBrowser implements Evaluator {
    private readonly child: ChildProcess;
    private readonly folder = mkdtempSync(join(tmpdir(), 'pliant-browser-'));
    private readonly waiting = new Map<number, (reply: Reply) => void>();
    private session = '';
    private nextId = 1;
    private text = '';

    private constructor() {
        const own = ['--headless', '--remote-debugging-pipe', `--user-data-dir=${this.folder}`];
        this.child = spawn(findChromium(), [...kArguments, ...own, 'about:blank'], {
            stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe'],
        });
        (this.child.stdio[4] as Readable).on('data', (data: Buffer) => this.take(data));
    }

    /// Opens a link and waits until `ready` holds in it.
    static async open(link: string, ready: () => boolean): Promise<BareBrowser> {
        const browser = new BareBrowser();
        const { targetInfos } = await browser.ask('Target.getTargets', {});
        const { targetId } = targetInfos.find((t: { type: string }) => t.type === 'page');
        const attached = await browser.ask('Target.attachToTarget', { targetId, flatten: true });
        browser.session = attached.sessionId;
        await browser.ask('Emulation.setDeviceMetricsOverride', {
            width: 1280,
            height: 720,
            deviceScaleFactor: 1,
            mobile: false,
        });
        const source = `(${keepTissue.toString()})()`;
        await browser.ask('Page.addScriptToEvaluateOnNewDocument', { source });
        await browser.ask('Page.navigate', { url: link });
        for (let n = 0; n < kPatience; ++n) {
            await new Promise((r) => setTimeout(r, 100));
            if (await browser.evaluate(ready).catch(() => false)) return browser;
        }
        await browser.close();
        throw new Error(`the page was not ready within ${kPatience / 10} s`);
    }

    async evaluate<R, A>(run: (argument: A) => R | Promise<R>, argument?: A): Promise<R> {
        const { result, exceptionDetails } = await this.ask('Runtime.evaluate', {
            expression: `(${run.toString()})(${JSON.stringify(argument)})`,
            awaitPromise: true,
            returnByValue: true,
        });
        if (exceptionDetails) throw new Error(result.description ?? exceptionDetails.text);
        return result.value as R;
    }

    async close(): Promise<void> {
        const gone = new Promise((resolve) => this.child.on('exit', resolve));
        this.session = '';
        void this.ask('Browser.close', {}).catch(() => {});
        await gone;
        rmSync(this.folder, { recursive: true, force: true });
    }

    private ask(method: string, params: object): Promise<any> {
        const id = this.nextId++;
        const sessionId = this.session ? { sessionId: this.session } : {};
        const message = JSON.stringify({ id, method, params, ...sessionId });
        (this.child.stdio[3] as Writable).write(`${message}\0`);
        return new Promise((resolve, reject) =>
            this.waiting.set(id, ({ error, result }) =>
                error ? reject(new Error(`${method}: ${error.message}`)) : resolve(result),
            ),
        );
    }

    private take(data: Buffer): void {
        const messages = (this.text + data.toString()).split('\0');
        this.text = messages.pop()!;
        for (const message of messages) {
            const reply = JSON.parse(message) as Reply;
            if (reply.id === undefined) continue;
            this.waiting.get(reply.id)?.(reply);
            this.waiting.delete(reply.id);
        }
    }
}

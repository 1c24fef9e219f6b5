// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Browser of the tests, and their common operations. Debian's headless Chromium, with WebGL in
// software, so that no graphics processor is needed.
//
//   PLIANT_CHROMIUM  another browser
//   PLIANT_SERVER    the program `pliant`: the tests then run against its server, not the mock
//   PLIANT_PAGE      with PLIANT_SERVER: folder of a page to show instead of the program's own

import { type ChildProcess, execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdirSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { type Browser, type BrowserContextOptions, chromium, type Page } from 'playwright-core';
import type { ViewName } from '../src/state/state.ts';
import type { Session } from '../src/tools/session.ts';
import { MockServer } from './mock_server.ts';

export const kFolder = process.env.PLIANT_VIEWER!; // set by run.mjs
export const kPictures = join(kFolder, 'test/out');
mkdirSync(kPictures, { recursive: true });

export interface Served {
    readonly link: string;
    readonly mock: MockServer | undefined;
    /// Stops the server without ending it, or lets it go on.
    freeze(on: boolean): void;
    stop(): Promise<void>;
}

/// Files with a tissue of their own: scenes, and meshes of organs.
const kOwnTissue = /\.(toml|vt[upk]|msh|stl|obj|ply)$/;

/// Arguments with ChainMail as a scan's model unless they name one: results don't depend on the
/// machine's speed then.
function withModel(args: string[]): string[] {
    const isOwn = args.some(
        (arg) => kOwnTissue.test(arg) || ['--replay', '--bodies', '--network'].includes(arg),
    );
    return isOwn || args.includes('--model') ? args : [...args, '--model', 'chainmail'];
}

/// Starts the program's server on a free port, or the mock.
export async function serve(...args: string[]): Promise<Served> {
    const program = process.env.PLIANT_SERVER;
    if (!program) {
        const mock = new MockServer(join(kFolder, 'dist'));
        const freeze = (on: boolean): void => mock.freeze(on);
        return { link: await mock.start(), mock, freeze, stop: async () => mock.stop() };
    }
    const child = spawn(program, ['serve', '--port', '0', '--no-open', ...withModel(args)]);
    const link = await linkOf(child);
    return {
        link,
        mock: undefined,
        freeze: (on) => void child.kill(on ? 'SIGSTOP' : 'SIGCONT'),
        stop: () =>
            new Promise((resolve) => {
                child.on('exit', () => resolve());
                child.kill('SIGTERM');
            }),
    };
}

/// Serves the airway phantom with a number of voxels along each side; the mock has one size only.
export async function serveAirway(size: number): Promise<Served> {
    const program = process.env.PLIANT_SERVER;
    if (!program) return serve();
    const folder = mkdtempSync(join(tmpdir(), 'pliant-airway-'));
    const scan = join(folder, 'airway.nrrd');
    execFileSync(program, ['phantom', 'airway', '--size', String(size), '--out', scan]);
    const served = await serve(scan);
    const stop = async (): Promise<void> => {
        await served.stop();
        rmSync(folder, { recursive: true });
    };
    return { ...served, stop };
}

function linkOf(child: ChildProcess): Promise<string> {
    return new Promise((resolve, reject) => {
        let text = '';
        const take = (data: Buffer): void => {
            text += data.toString();
            const found = /http:\/\/\S+#token=\S+/.exec(text);
            if (found) resolve(found[0]);
        };
        child.stdout!.on('data', take);
        child.stderr!.on('data', take);
        child.on('exit', () => reject(new Error(`the server ended: ${text}`)));
    });
}

export function findChromium(): string {
    const found = [
        process.env.PLIANT_CHROMIUM ?? '',
        '/usr/bin/chromium-headless-shell',
        '/usr/bin/chromium',
    ].find((path) => path && existsSync(path));
    if (!found) throw new Error('no Chromium: install chromium-headless-shell');
    return found;
}

export const kArguments = [
    '--no-sandbox',
    '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader',
    // SwiftShader draws WebGL alone: for the page itself it is far slower than the processor, and
    // stalls for seconds where a plot changes with each frame.
    '--disable-gpu-rasterization',
    '--disable-accelerated-2d-canvas',
    // Pages fulfilled from a folder don't count as local.
    '--disable-features=LocalNetworkAccessChecks',
];

export const launch = (): Promise<Browser> =>
    chromium.launch({ executablePath: findChromium(), args: kArguments });

/// PLIANT_GPU=1: the browser has a graphics processor. In software a page that shows a device in a
/// vessel is often silent for longer than the server waits.
export const hasGpu = process.env.PLIANT_GPU === '1';

/// Keeps the tissue as the server starts it, unless a test has chosen otherwise: checksums and
/// steps of undo are then the server's own. Runs in the page.
export function keepTissue(): void {
    const key = 'pliant.tissue';
    const wish = '{"limits": "box", "springsBack": false}';
    if (!localStorage.getItem(key)) localStorage.setItem(key, wish);
}

/// Reports what the content security policy refuses as an error of the page. Runs in the page.
export function reportRefused(): void {
    document.addEventListener('securitypolicyviolation', (event) =>
        console.error(`policy: ${event.effectiveDirective} refused ${event.blockedURI}`),
    );
}

export interface Visit {
    readonly page: Page;
    readonly errors: string[];
}

/// Opens the page and waits for the scan. @param more  further parameters after the #
/// @param settings  of the browser's context
export async function visit(
    browser: Browser,
    link: string,
    more = '&notour',
    settings: BrowserContextOptions = {},
): Promise<Visit> {
    const viewport = { width: 1280, height: 720 };
    const context = await browser.newContext({ viewport, ...settings });
    const folder = process.env.PLIANT_SERVER && process.env.PLIANT_PAGE;
    if (folder)
        await context.route(/\/(app\.js|app\.css|index\.html)?$/, (route) => {
            const name = new URL(route.request().url()).pathname.slice(1) || 'index.html';
            return route.fulfill({ path: join(folder, name) });
        });
    await context.addInitScript(keepTissue);
    await context.addInitScript(reportRefused);
    const page = await context.newPage();
    const errors: string[] = [];
    page.on('pageerror', (error) => errors.push(String(error)));
    page.on('console', (message) => {
        // Chromium's warning about reading back pixels is no error of the page.
        if (message.type() === 'error') errors.push(message.text());
    });
    await page.goto(link + more);
    // Four rays per pixel are slow in software; the style is kept even if it is slow.
    await page.evaluate(() =>
        (window as unknown as { pliant: Session }).pliant.store.set({
            display: { fine: false },
            look: { styleChosen: true },
        }),
    );
    await loaded(page);
    return { page, errors };
}

export const loaded = async (page: Page): Promise<void> => {
    await page.waitForFunction(
        () => {
            const state = session().store.state;
            return state.link.status === 'open' && state.scan.loaded === 1;
            function session(): Session {
                return (window as unknown as { pliant: Session }).pliant;
            }
        },
        undefined,
        { timeout: 60_000 },
    );
    await still(page);
};

/// Waits until all views are drawn completely.
export const still = async (page: Page): Promise<void> => {
    await page.waitForFunction(
        () => (window as unknown as { pliant: Session }).pliant.stage.isStill,
        undefined,
        { timeout: 60_000 },
    );
};

/// Present state of the page.
export const stateOf = (page: Page): Promise<Session['store']['state']> =>
    page.evaluate(() => (window as unknown as { pliant: Session }).pliant.store.state);

export interface Rect {
    x: number;
    y: number;
    width: number;
    height: number;
}

export async function rectOf(page: Page, view: ViewName): Promise<Rect> {
    const box = await page.locator(`.view.${view}`).boundingBox();
    if (!box) throw new Error(`${view} is not shown`);
    return box;
}

/// Page coordinates of a point in a view. u, v: shares of its width and height
export async function spot(
    page: Page,
    view: ViewName,
    u = 0.5,
    v = 0.5,
): Promise<[number, number]> {
    const box = await rectOf(page, view);
    return [Math.round(box.x + u * box.width), Math.round(box.y + v * box.height)];
}

/// Statistics of a view's pixels, without the marks over them; the hash changes with any pixel.
export async function pixels(
    page: Page,
    view: ViewName,
): Promise<{ hash: number; mean: number; lit: number }> {
    await still(page);
    return page.evaluate((name) => {
        const canvas = document.querySelector('canvas')!;
        const ratio = canvas.width / canvas.getBoundingClientRect().width;
        const box = document.querySelector(`.view.${name}`)!.getBoundingClientRect();
        const own = canvas.getBoundingClientRect();
        const copy = document.createElement('canvas');
        copy.width = Math.round(box.width * ratio);
        copy.height = Math.round(box.height * ratio);
        const context = copy.getContext('2d')!;
        context.drawImage(canvas, -(box.left - own.left) * ratio, -(box.top - own.top) * ratio);
        const { data } = context.getImageData(0, 0, copy.width, copy.height);
        let hash = 2166136261;
        let sum = 0;
        let lit = 0;
        for (let i = 0; i < data.length; ++i) {
            hash = Math.imul(hash ^ data[i]!, 16777619);
            if (i % 4 === 3) continue;
            sum += data[i]!;
            if (data[i]! > 40) ++lit;
        }
        return { hash, mean: sum / data.length, lit: lit / data.length };
    }, view);
}

/// Presses a button, moves in steps and releases it.
export async function dragBy(
    page: Page,
    from: [number, number],
    by: [number, number],
    button: 'left' | 'middle' | 'right' = 'left',
): Promise<void> {
    await page.mouse.move(...from);
    await page.mouse.down({ button });
    for (let i = 1; i <= 8; ++i)
        await page.mouse.move(from[0] + (by[0] * i) / 8, from[1] + (by[1] * i) / 8);
    await page.mouse.up({ button });
}

/// Waits for a state of the page. It polls from here, because the page evaluates no code from text.
export async function untilState(
    page: Page,
    holds: (state: Session['store']['state']) => boolean,
    seconds = 60,
): Promise<void> {
    for (const end = Date.now() + 1000 * seconds; !holds(await stateOf(page));) {
        if (Date.now() > end) throw new Error(`not within ${seconds} s: ${holds.toString()}`);
        await page.waitForTimeout(100);
    }
}

/// Waits for a number of undo steps of the server.
export const untilUndo = (page: Page, steps: number): Promise<unknown> =>
    page.waitForFunction(
        (n) =>
            (window as unknown as { pliant: Session }).pliant.store.state.shared?.undo.steps === n,
        steps,
        { timeout: 20_000 },
    );

export const picture = async (page: Page, name: string): Promise<void> => {
    await page.screenshot({ path: join(kPictures, `${name}.png`) });
};

/// Waits for a scan with a name, and its voxels.
export async function untilScan(page: Page, name: string): Promise<void> {
    await page.waitForFunction(
        (wanted) => {
            const { store } = (window as never as { pliant: Session }).pliant;
            return store.state.scan.volume?.name === wanted && store.state.link.transfer === '';
        },
        name,
        { timeout: 60_000 },
    );
    await loaded(page);
}

export const compare = (
    page: Page,
): Promise<{ same: boolean; own: string; tissue: string } | undefined> =>
    page.evaluate(() => (window as unknown as { pliant: Session }).pliant.compare());

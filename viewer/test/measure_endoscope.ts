// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// `./dev results endoscope`: writes a page of documentation with the page's latencies, transfers
// and pictures.
//
//   PLIANT_RESULTS  folder of that page
//   PLIANT_PARTS    parts to measure, of latency, bytes, pictures, features, gallery; absent: all.
//                   Results of the other parts are read from test/out, where each part stores them

import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { cpus, loadavg, tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser } from 'playwright-core';
import type { Evaluator } from './bare_browser.ts';
import { findChromium, kPictures, launch, serve, visit } from './browser.ts';
import { kFeatures, showAll } from './features.ts';
import { galleryText, takeGallery } from './gallery.ts';
import { histogram } from './histogram.ts';
import * as latency from './latency.ts';
import { quantile } from './latency.ts';
import { difference, type Difference, kFar } from './picture_difference.ts';
import { kBalls, kHeart, kHertz, kRun, thorax } from './setups.ts';
import { watched } from './stolen.ts';

const kCount = 600;
const scan = thorax();
const out = process.env.PLIANT_RESULTS;
if (!out) throw new Error('expected PLIANT_RESULTS, the folder of the page');
mkdirSync(out, { recursive: true });
const load = loadavg()[0]!;
let browser: Browser;

interface Numbers {
    latency: latency.LatencyRun & { load: number; stolen: number };
    bytes: latency.BytesRun[];
    pictures: { phantom: Difference; ct: Difference };
    features: string; ///< date
    gallery: string; ///< date
}

/// Result of a part, measured now or stored before.
async function part<K extends keyof Numbers>(
    name: K,
    measure: () => Promise<Numbers[K]>,
): Promise<Numbers[K]> {
    const file = join(kPictures, `results_${name}.json`);
    const wanted = process.env.PLIANT_PARTS?.split(',').includes(name) ?? true;
    if (wanted) writeFileSync(file, JSON.stringify(await measure()));
    return JSON.parse(readFileSync(file, 'utf8')) as Numbers[K];
}

async function inBare<R>(measure: (page: Evaluator) => Promise<R>): Promise<R> {
    const served = await serve(scan);
    const page = await latency.openBare(served.link);
    const result = await measure(page);
    await page.close();
    await served.stop();
    return result;
}

async function measureAllBytes(page: Evaluator): Promise<latency.BytesRun[]> {
    const found: latency.BytesRun[] = [];
    for (const ball of kBalls) found.push(await latency.measureBytes(page, ball));
    return found;
}

async function pictures(): Promise<Numbers['pictures']> {
    browser = await launch();
    const folder = mkdtempSync(join(tmpdir(), 'pliant-results-'));
    const phantom = join(folder, 'airway.nrrd');
    const wish = ['phantom', 'airway', '--size', '128', '--out', phantom];
    execFileSync(process.env.PLIANT_SERVER!, wish);
    const found: Difference[] = [];
    for (const [file, name] of [
        [phantom, 'picture_phantom'],
        [scan, 'picture_ct'],
    ] as const) {
        const served = await serve(file);
        const { page } = await visit(browser, served.link);
        found.push(await difference(page, file, name));
        const box = (await page.locator('.view.endoscope').boundingBox())!;
        await page.screenshot({ path: join(out!, `${name}.jpg`), clip: box, quality: 80 });
        await page.context().close();
        await served.stop();
    }
    rmSync(folder, { recursive: true });
    await browser.close();
    return { phantom: found[0]!, ct: found[1]! };
}

async function features(): Promise<string> {
    browser = await launch();
    const served = await serve(scan);
    const { page, errors } = await visit(browser, served.link);
    await showAll(page, async ({ name }) => {
        await page.screenshot({ path: join(out!, `${name}.jpg`), quality: 40 });
    });
    if (errors.length) throw new Error(errors.join('\n'));
    await browser.close();
    await served.stop();
    return new Date().toISOString();
}

const row = (...cells: (string | number)[]): string => `| ${cells.join(' | ')} |`;
const ms = (values: readonly number[]): string[] =>
    [0.5, 0.9, 0.99, 1].map((q) => quantile(values, q).toFixed(1));
const grouped = (n: number): string => n.toLocaleString('en').replaceAll(',', ' ');
const compared = (name: string, { camera, mean, far }: Difference): string =>
    row(name, camera, mean.toFixed(2), `${(100 * far).toFixed(2)} %`);
const kib = (n: number): string => grouped(Math.round(n / 1024));

const run = await part('latency', async () => ({
    ...(await inBare((page) =>
        watched(() => latency.measureLatency(page, { ...kRun, count: kCount })),
    )),
    load,
}));
const bytes = await part('bytes', () => inBare(measureAllBytes));
const { phantom, ct } = await part('pictures', pictures);
await part('features', features);
await part('gallery', async () => {
    browser = await launch();
    await takeGallery(browser, out!);
    await browser.close();
    return new Date().toISOString();
});
const version = execFileSync(findChromium(), ['--version']).toString().trim();

const { samples, server } = run;
const least = Math.min(...samples.map((s) => s.moved));
const textured = samples.map((s) => s.textured);
writeFileSync(
    join(out, 'latency.svg'),
    histogram(textured, {
        bin: 2,
        end: 60,
        mark: 50,
        markLabel: 'bound: 50 ms',
        label: 'from command to texture [ms]',
        countLabel: 'number of commands',
    }),
);
const shared = readFileSync(join(kPictures, 'picture_ct_cpp.png'));
writeFileSync(join(out, 'picture_ct_cpp.png'), shared);

const text = `# The endoscope in the browser, measured

| what | this run |
|---|---:|
| command | \`./dev results endoscope\` |
| date | ${new Date().toISOString().slice(0, 10)} |
| machine | ${cpus()[0]!.model}, ${cpus().length} cores, no graphics processor |
| browser | ${version}, headless, WebGL in software (SwiftShader) |
| scan | \`thorax_ct_256.nrrd\`, 256 × 256 × 137 voxels |
| load average before the times were taken | ${run.load.toFixed(1)} |
| processor time of other virtual machines during them | ${(100 * run.stolen).toFixed(1)} % |

## From a command to the texture

A ball of ${kHeart.radius} mm in the heart is pushed ${kHeart.mm} mm back and forth, ${kHertz}
times a second, without waiting for answers, by a page that is connected to \`pliant serve\` on the
same machine. The time starts before a command is sent, and ends when the last box of the command's
step is in the texture, after \`gl.finish()\`. It includes both ways through the WebSocket, the wait
for the server's next step (60 Hz), solving, resampling, encoding, decoding, the page's mirror and
the upload. *Software rendering is excluded*: the page draws no views during the measurement,
because without a graphics processor drawing would occupy most of the two cores that server and
browser share. A user sees the result one frame of the display later.

${kCount} pushes were sent at ${run.hertz.toFixed(1)} Hz, after ${kRun.warmUp} that are not counted;
${run.refused} were refused. Each of the others moved at least ${grouped(least)} elements. No tissue
is treated as bone, and elements may move by 50 mm, so that each push is done completely; a push
that bone stops takes up to four times as long.

| [ms] | median | 90 % | 99 % | maximum |
|---|---:|---:|---:|---:|
${row('answer received', ...ms(samples.map((s) => s.answered)))}
${row('voxels in the mirror', ...ms(samples.map((s) => s.mirrored)))}
${row('**voxels in the texture**', ...ms(textured))}
${row('server: solving', ...ms(server.solve))}
${row('server: resampling', ...ms(server.resample))}
${row('server: whole step, without sending', ...ms(server.tick))}

![histogram of the time from command to texture](latency.svg)

## Bytes sent per push

One push from rest, with balls of several sizes at the same position. *Changed* voxels have another
half float afterwards, counted in the page; *hull* is their bounding box. The server sends whole
blocks of 8³ voxels, joined into boxes.

| radius [mm] | moved elements | changed voxels | hull [voxels] | sent [voxels] | boxes | KiB | \
sent : changed |
|---:|---:|---:|---:|---:|---:|---:|---:|
${bytes
    .map((b, n) =>
        row(
            kBalls[n]!.radius,
            grouped(b.moved),
            grouped(b.changed),
            grouped(b.hull),
            grouped(b.sent),
            b.boxes,
            kib(b.bytes),
            (b.sent / b.changed).toFixed(2),
        ),
    )
    .join('\n')}

The run above sent ${kib(run.boxBytes / samples.length)} KiB per push; a complete snapshot
has ${kib(2 * 256 * 256 * 137)} KiB.

## The same picture in the browser and in C++

The endoscope's picture by the shader and by \`pliant render\`, in the style *plain*, with the same
camera. The two share no code. \`viewer/test/test_picture.ts\` requires a mean difference below
0.5 of 255 and at most 0.5 % of the pixels off by more than ${kFar}, for both styles, all linings,
and deformed tissue.

| | camera | mean difference, of 255 | pixels off by more than ${kFar} |
|---|---|---:|---:|
${compared('phantom', phantom)}
${compared('CT', ct)}

| browser | C++ |
|---|---|
| ![the CT in the browser](picture_ct.jpg) | ![the CT in C++](picture_ct_cpp.png) |

## Pictures

[pushed.md](pushed.md) shows a push in both styles, [colours.md](colours.md) compares colours with
published figures.

${galleryText()}

The catheter is a curve through the lumen here; nothing is simulated.

### The page

${kFeatures.map(({ name, caption }) => `**${caption}.**\n\n![${name}](${name}.jpg)\n`).join('\n')}`;
writeFileSync(join(out, 'README.md'), text);
console.log(`median ${ms(textured)[0]} ms, 99 % ${ms(textured)[2]} ms, least moved ${least}`);

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Makes the animation at the top of the README and its still: a flight through the phantom's
// airway, then a push of its wall. Needs ffmpeg on the PATH.
//
//   PLIANT_SERVER=build/release/pliant PLIANT_OUT=docs/images npm run measure opening

import { execFileSync } from 'node:child_process';
import { copyFileSync, mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Session } from '../src/tools/session.ts';
import { launch, rectOf, serve, still, visit } from './browser.ts';

const program = process.env.PLIANT_SERVER;
const out = process.env.PLIANT_OUT;
if (!program || !out)
    throw new Error('expected PLIANT_SERVER, a program, and PLIANT_OUT, a folder');
const kSide = 400; // pixels
const kFlight = 22; // pictures of each part
const kPush = 14;
const kHold = 6;

const folder = mkdtempSync(join(tmpdir(), 'pliant-opening-'));
const scan = join(folder, 'airway.nrrd');
execFileSync(program, ['phantom', 'airway', '--size', '192', '--out', scan]);
const browser = await launch();
const served = await serve(scan);
const { page } = await visit(browser, served.link);
await page.setViewportSize({ width: kSide + 360, height: kSide + 65 });
await page.evaluate(() => {
    const { store } = (window as never as { pliant: Session }).pliant;
    store.set({
        display: { maximised: 'endoscope', fine: true },
        tool: { radius: 4, name: 'push' },
        flight: { wall: 'pass' },
    });
});
await page.waitForTimeout(500);
const box = await rectOf(page, 'endoscope');
const side = Math.min(box.width, box.height);
const clip = {
    x: box.x + 0.5 * (box.width - side),
    y: box.y + 0.5 * (box.height - side),
    width: side,
    height: side,
};
// Without names and captions. The page's policy refuses inline styles, but not this.
await page.evaluate(() =>
    document.styleSheets[0]!.insertRule('.view > * { visibility: hidden !important }'),
);
let count = 0;
async function shoot(): Promise<void> {
    await still(page);
    await page.screenshot({ path: join(folder, `${String(++count).padStart(4, '0')}.png`), clip });
}

for (let n = 0; n <= kFlight; ++n) {
    const s = n / kFlight;
    const camera = {
        eye: [0.3, -2 + 0.5 * s, 62 - 24 * s] as Vec3,
        look: [-0.16 * s * s, -0.08 * s * s, -1] as Vec3,
        up: [0, -1, 0] as Vec3,
    };
    await page.evaluate((next) => {
        (window as never as { pliant: Session }).pliant.store.set({ view: { camera: next } });
    }, camera);
    await shoot();
}
const from = { x: clip.x + 0.24 * side, y: clip.y + 0.5 * side };
const by = { x: 0.26 * side, y: 0.04 * side };
await page.mouse.move(from.x, from.y);
await page.mouse.down();
const at = async (s: number): Promise<void> => {
    await page.mouse.move(from.x + s * by.x, from.y + s * by.y);
    await page.waitForTimeout(250); // the tissue's answer
};
for (let n = 1; n <= kPush; ++n) {
    await at(n / kPush);
    await shoot();
}
for (let n = 0; n < kHold; ++n) await shoot();
const pushed = count;
for (let n = kPush; n >= 0; --n) {
    await at(n / kPush);
    await shoot();
}
await page.mouse.up();
await served.stop();
await browser.close();

const frames = ['-y', '-loglevel', 'error', '-framerate', '12', '-i', join(folder, '%04d.png')];
const webp = ['-c:v', 'libwebp_anim', '-quality', '88', '-loop', '0'];
execFileSync('ffmpeg', [...frames, ...webp, join(out, 'opening.webp')]);
copyFileSync(join(folder, `${String(pushed).padStart(4, '0')}.png`), join(out, 'opening.png'));
rmSync(folder, { recursive: true });
console.log(`${count} pictures of ${Math.round(side)}² pixels`);

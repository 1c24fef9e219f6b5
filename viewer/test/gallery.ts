// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Gallery of looks, instruments and X-rays for the page of results: pictures of one view.

import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import type { Browser, Page } from 'playwright-core';
import type { Camera } from '../src/maths/rays.ts';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Patch } from '../src/state/store.ts';
import type { Session } from '../src/tools/session.ts';
import type { ToolBall, ToolKind } from '../src/views/instruments.ts';
import { serve, still, visit } from './browser.ts';
import { insertCatheter, kAortaLumen } from './inserted_catheter.ts';
import { kAbdomen, kAorta, kThorax } from './setups.ts';

type Held = { pliant: Session };
type Scan = 'thorax' | 'sinus' | 'abdomen' | 'aorta';

interface Shot {
    readonly name: string; ///< of its picture
    readonly caption: string;
    readonly scan: Scan;
    readonly set: Patch;
    readonly tool?: { readonly kind: ToolKind; readonly ahead: Vec3; readonly radius: number };
    readonly catheter?: boolean;
    readonly side?: boolean; ///< X-rays from the side
    readonly near?: number; ///< factor of the distance at which the whole scan is visible
}

const kSize = { width: 830, height: 520 }; // of the window; half of it is the view
const look = { style: 'real', fieldStop: 'round' } as const;
const inside = { view: { outside: false, fluoroscopy: false }, look } as const;
const insideAt = (camera: Camera): Patch => ({ view: { ...inside.view, camera } });
const shadow = { view: { outside: true, fluoroscopy: true } } as const;
const kTurbinate = { eye: [4.5, -42.5, -8], look: [0.297, 0.807, -0.51], up: [0, 0, 1] } as const;
const kInColon = {
    eye: [76, -239.3, 379.3],
    look: [-0.58, -0.145, -0.8],
    up: [0, -1, 0.2],
} as const;
const kInAorta = { eye: [-0.4, -145.6, 587], look: [0.31, 0.28, 0.91], up: [0, -1, 0] } as const;
const kBesideCatheter = { ...kInAorta, eye: [-0.4, -147.8, 584] } as const;

/// Shot of an instrument. @param ahead  position ahead, to the right and up of the lens [mm]
const tool = (kind: ToolKind, text: string, radius: number, ahead: Vec3 = [16, 1, 0]): Shot => ({
    name: `tool_${kind}`,
    caption: text,
    scan: 'thorax',
    set: inside,
    tool: { kind, ahead, radius },
});

export const kGallery: Readonly<Record<string, readonly Shot[]>> = {
    Looks: [
        {
            name: 'look_plain',
            caption: 'An airway, *plain*: shape alone',
            scan: 'thorax',
            set: { ...inside, look: { ...look, style: 'plain' } },
        },
        { name: 'look_airway', caption: 'The same, *real*', scan: 'thorax', set: inside },
        {
            name: 'look_octagon',
            caption: '*Real*, octagonal field',
            scan: 'thorax',
            set: { ...inside, look: { ...look, fieldStop: 'octagon' } },
        },
        {
            name: 'look_full',
            caption: '*Real*, full field',
            scan: 'thorax',
            set: { ...inside, look: { ...look, fieldStop: 'full' } },
        },
        {
            name: 'look_sinus',
            caption: 'A turbinate of the sinus phantom, colours of a sinus',
            scan: 'sinus',
            set: { ...insideAt(kTurbinate), look: { ...look, lining: 'sinus' } },
        },
        {
            name: 'look_colon',
            caption: 'A colon with gas in a CT of 3 mm, colours of a colon',
            scan: 'abdomen',
            set: { ...insideAt(kInColon), look: { ...look, lining: 'colon' } },
        },
        {
            name: 'look_vessel',
            caption: 'The aorta in a CT angiography, colours of a vessel',
            scan: 'aorta',
            set: { ...insideAt(kInAorta), look: { ...look, lining: 'vessel' } },
        },
    ],
    Instruments: [
        tool('ball', 'Ball probe', 3),
        tool('grasper', 'Grasper', 3.5),
        tool('blade', 'Blade', 2.5),
        tool('scoop', 'Scoop', 3.5),
        tool('scope', 'Another endoscope', 2.5, [18, -1, 0]),
        {
            name: 'tool_catheter',
            caption: 'Catheter in the aorta',
            scan: 'aorta',
            set: { ...insideAt(kBesideCatheter), look: { ...look, lining: 'vessel' } },
            catheter: true,
        },
    ],
    Fluoroscopy: [
        {
            name: 'xray_thorax',
            caption: 'A thorax from the front',
            scan: 'thorax',
            set: shadow,
            near: 0.8,
        },
        {
            name: 'xray_front',
            caption: 'A catheter before heart and spine; the scan is cut on all sides',
            scan: 'aorta',
            set: shadow,
            catheter: true,
            near: 0.9,
        },
        {
            name: 'xray_side',
            caption: 'The same from the side',
            scan: 'aorta',
            set: shadow,
            catheter: true,
            near: 0.9,
            side: true,
        },
    ],
};

/// Takes all pictures, with one server for each scan. @param out  their folder
export async function takeGallery(browser: Browser, out: string): Promise<void> {
    const folder = mkdtempSync(join(tmpdir(), 'pliant-gallery-'));
    const sinus = join(folder, 'sinus.nrrd');
    const wish = ['phantom', 'sinus', '--size', '160', '--out', sinus];
    execFileSync(process.env.PLIANT_SERVER!, wish);
    const shots = Object.values(kGallery).flat();
    const files = { thorax: kThorax, sinus, abdomen: kAbdomen, aorta: kAorta };
    for (const [scan, file] of Object.entries(files)) {
        const served = await serve(file);
        const { page, errors } = await visit(browser, served.link);
        await page.setViewportSize(kSize);
        if (scan === 'aorta')
            await page.evaluate(async () => {
                const { pliant } = window as never as Held;
                await pliant.ask({ do: 'iso', iso_hu: 280, polarity: 'falling' });
                await pliant.compare();
            });
        for (const shot of shots.filter((one) => one.scan === scan))
            await take(page, shot, join(out, `${shot.name}.jpg`));
        await page.context().close();
        await served.stop();
        if (errors.length) throw new Error(errors.join('\n'));
    }
    rmSync(folder, { recursive: true });
}

async function take(page: Page, shot: Shot, path: string): Promise<void> {
    await insertCatheter(page, shot.catheter ? kAortaLumen : []);
    await page.evaluate(({ set, side, near }) => {
        const { store, stage, volume } = (window as never as Held).pliant;
        (stage as never as { quality: number }).quality = 0; // full resolution, even if it is slow
        const { grid } = volume!;
        const size = Math.max(...grid.size.map((n, a) => n * grid.spacing[a]!));
        const orbit = {
            ...store.state.view.orbit,
            direction: (side ? [0.98, 0.199, 0] : [0, 1, 0]) as never,
            distance: 1.9 * size * (near ?? 1),
        };
        store.set({ display: { fine: true, maximised: 'endoscope' }, view: { orbit } });
        store.set(set);
        store.set({ sections: { cursor: store.state.view.camera.eye } }); // hides the crosshair
    }, shot);
    await page.evaluate((tool) => {
        const { store, stage } = (window as never as Held).pliant;
        const { eye, look, up } = store.state.view.camera;
        const right = [0, 1, 2].map(
            (a) => look[(a + 1) % 3]! * up[(a + 2) % 3]! - look[(a + 2) % 3]! * up[(a + 1) % 3]!,
        );
        const at = (ahead: Vec3): Vec3 =>
            [0, 1, 2].map(
                (a) => eye[a]! + ahead[0] * look[a]! + ahead[1] * right[a]! + ahead[2] * up[a]!,
            ) as unknown as Vec3;
        const own = tool && tool.kind !== 'scope';
        const towards = { direction: look.map((x, a) => -0.95 * x - 0.3 * right[a]!) };
        const balls = tool
            ? [{ ...tool, centre: at(tool.ahead), own, ...(own ? {} : towards) }]
            : [];
        stage.setTools(balls as unknown as ToolBall[]);
    }, shot.tool);
    await page.waitForTimeout(300);
    await still(page);
    const clip = (await page.locator('.view.endoscope').boundingBox())!;
    await page.screenshot({ path, clip, quality: 80 });
}

/// Markdown table with two pictures in a row.
export function galleryText(): string {
    const table = (shots: readonly Shot[]): string => {
        const rows: string[] = [];
        for (let n = 0; n < shots.length; n += 2) {
            const pair = shots.slice(n, n + 2);
            const pictures = pair.map(({ name, caption }) => `![${caption}](${name}.jpg)`);
            rows.push(`| ${pictures.join(' | ')} |${n === 0 ? '\n|---|---|' : ''}`);
            rows.push(`| ${pair.map(({ caption }) => caption).join(' | ')} |`);
        }
        return rows.join('\n');
    };
    return Object.entries(kGallery)
        .map(([title, shots]) => `### ${title}\n\n${table(shots)}`)
        .join('\n\n');
}

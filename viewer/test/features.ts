// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Features of the page, each shown once on one scan, with a picture.

import type { Page } from 'playwright-core';
import type { Vec3 } from '../src/maths/vec.ts';
import type { Session } from '../src/tools/session.ts';
import { loaded, stateOf, still } from './browser.ts';

export interface Feature {
    readonly name: string; ///< of its picture
    readonly caption: string;
    show(page: Page): Promise<void>;
}

type Command = Parameters<Session['connection']['ask']>[0];
type Wish = Parameters<Session['store']['set']>[0];

const ask = (page: Page, command: Command): Promise<unknown> =>
    page.evaluate(async (c) => {
        const { pliant } = window as never as { pliant: Session };
        await pliant.ask(c);
        await pliant.compare(); // its answer comes after all boxes
    }, command);
const set = (page: Page, wish: Wish): Promise<void> =>
    page.evaluate((w) => (window as never as { pliant: Session }).pliant.store.set(w), wish);
const key = (page: Page, name: string): Promise<void> => page.keyboard.press(name);

/// Point ahead of the endoscope at a distance [mm].
async function ahead(page: Page, mm: number): Promise<Vec3> {
    const { camera } = (await stateOf(page)).view;
    return [0, 1, 2].map((a) => camera.eye[a]! + mm * camera.look[a]!) as unknown as Vec3;
}

/// Finds the wall ahead of the endoscope, and sets the crosshair on it.
async function wallAhead(page: Page): Promise<Vec3> {
    const mm = await page.evaluate(() => {
        const { volume, store } = (window as never as { pliant: Session }).pliant;
        const { shared } = store.state;
        const { camera } = store.state.view;
        const { grid } = volume!;
        for (let way = 1; way < 200; way += 0.5) {
            const v = camera.eye.map((x, a) => x + way * camera.look[a]! - grid.origin[a]!);
            const ijk = grid.direction.map(
                (axis, a) => axis.reduce((sum, x, b) => sum + x * v[b]!, 0) / grid.spacing[a]!,
            );
            if (volume!.sample(ijk as never) > shared!.iso_hu) return way;
        }
        return 20;
    });
    const place = await ahead(page, mm);
    await set(page, { sections: { cursor: place } });
    return place;
}

/// Push of the wall on the right of the endoscope's picture into the lumen. Cartilage above 300 HU
/// would stop the push after 3 mm.
const kWall = { point: [-1.5, 142, -438], push: [-9, 0, 0], radius: 6 } as const;
const kBeforeWall: Vec3 = [-7, 142, -438]; // in the lumen at rest, in the wall once it is pushed
const kSoft = { bone_threshold_hu: 2000, offset: 0.4 };
const kHard = { bone_threshold_hu: 300, offset: 0.2 };

const kWhole = { shift: [0, 0], zoom: 1 } as const;
const wholeSections = { axial: kWhole, coronal: kWhole, sagittal: kWhole };

/// Centres the sections on a point.
async function lookCloser(page: Page, place: Vec3, zoom: number): Promise<void> {
    const from = await page.evaluate((p) => {
        const { grid } = (window as never as { pliant: Session }).pliant.volume!;
        return p.map((x, a) => x - grid.origin[a]! - 0.5 * (grid.size[a]! - 1) * grid.spacing[a]!);
    }, place);
    const [x, y, z] = from as unknown as Vec3;
    await set(page, {
        sections: {
            cursor: place,
            frames: {
                axial: { shift: [x, -y], zoom },
                coronal: { shift: [x, z], zoom },
                sagittal: { shift: [y, z], zoom },
            },
        },
    });
}

const panel = async (page: Page, title: RegExp): Promise<void> => {
    const summary = page.locator('summary', { hasText: title });
    const details = page.locator('details', { has: summary });
    if ((await details.getAttribute('open')) === null) await summary.click();
    await summary.scrollIntoViewIfNeeded();
};

export const kFeatures: readonly Feature[] = [
    {
        name: 'views',
        caption: 'Four views of one scan: endoscope, and sections through the wall on the right',
        show: (page) => lookCloser(page, kBeforeWall, 4),
    },
    {
        name: 'pushed',
        caption:
            'The wall on the right is pushed 9 mm into the lumen, cartilage included: all four ' +
            'views show the deformed scan',
        show: async (page) => {
            await ask(page, { do: 'materials', ...kSoft });
            await ask(page, { do: 'push', ...kWall });
        },
    },
    {
        name: 'displacement',
        caption: 'Displacement in colours, with a legend',
        show: async (page) => {
            await set(page, { overlay: { kind: 'displacement' } });
            await page.waitForFunction(
                () => (window as never as { pliant: Session }).pliant.store.state.scan.extreme > 0,
            );
        },
    },
    {
        name: 'volume_change',
        caption: 'Volume change in colours: blue is compressed, red stretched',
        show: async (page) => {
            await set(page, { overlay: { kind: 'jacobian' } });
            await page.waitForFunction(() => {
                const { stage, store } = (window as never as { pliant: Session }).pliant;
                return stage.overlay?.kind === 'jacobian' && store.state.scan.extreme > 0;
            });
        },
    },
    {
        name: 'carved',
        caption: 'Tissue carved out, the overlay switched off',
        show: async (page) => {
            await set(page, { overlay: { kind: 'none' } });
            await ask(page, { do: 'reset' });
            await ask(page, { do: 'materials', ...kHard });
            await set(page, { sections: { frames: wholeSections } });
            const from = await wallAhead(page);
            const { camera } = (await stateOf(page)).view;
            const to = from.map((x, a) => x + 10 * camera.look[a]!) as unknown as Vec3;
            await ask(page, { do: 'carve', from, to, radius: 6 });
        },
    },
    {
        name: 'threshold',
        caption: 'Undone, and another threshold: −250 HU',
        show: async (page) => {
            await ask(page, { do: 'undo' });
            await ask(page, { do: 'iso', iso_hu: -250 });
        },
    },
    {
        name: 'outside',
        caption: 'The lumen from outside, cut open at the tip, with the endoscope in it',
        show: async (page) => {
            await ask(page, { do: 'iso', iso_hu: -500 });
            await key(page, 'o');
        },
    },
    {
        name: 'maximised',
        caption: 'One view alone, with the window for lungs',
        show: async (page) => {
            await key(page, 'o');
            await set(page, {
                display: { maximised: 'coronal', contour: true },
                sections: { window: 1500, level: -600 },
            });
        },
    },
    {
        name: 'light',
        caption: 'The light theme, and the panel of the tissue',
        show: async (page) => {
            await set(page, { display: { maximised: null, theme: 'light', contour: false } });
            await panel(page, /^Tissue$/);
        },
    },
    {
        name: 'movie',
        caption: 'Keyframes of a movie',
        show: async (page) => {
            await set(page, { display: { theme: 'dark' } });
            await key(page, 'k');
            const eye = await ahead(page, 8);
            const { camera } = (await stateOf(page)).view;
            await set(page, { view: { camera: { ...camera, eye } } });
            await key(page, 'k');
            await panel(page, /^Movie/);
        },
    },
    {
        name: 'times',
        caption: 'Times, on demand',
        show: (page) => key(page, 't'),
    },
    {
        name: 'help',
        caption: 'All keys and gestures',
        show: (page) => key(page, '?'),
    },
];

/// Shows all features. @param take  takes the picture
export async function showAll(
    page: Page,
    take: (feature: Feature) => Promise<void>,
): Promise<void> {
    await loaded(page);
    for (const feature of kFeatures) {
        await feature.show(page);
        await still(page);
        await take(feature);
    }
    await key(page, 'Escape');
}

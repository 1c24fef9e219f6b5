// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Units, limits and decimals of scans that are no CT of a body: MR, micro-CT, ultrasound, data of
// 0…1.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import { autoWindow } from '../src/maths/auto_window.ts';
import { valueOf, valueText } from '../src/maths/marks.ts';
import { decimalsOf, fixed, nearestStep, roundTo, stepUpTo } from '../src/maths/steps.ts';
import { VolumeData } from '../src/maths/volume.ts';
import { halfOfFloat } from '../src/maths/half.ts';
import { kKinds, rangeOf } from '../src/state/overlay_kinds.ts';
import { initialState } from '../src/state/state.ts';
import {
    areaText,
    type Kind,
    lengthFor,
    lengthLimits,
    lengthText,
    paceText,
    roundLength,
    textWithUnit,
    unitOf,
    valueLimits,
    valueScale,
    valueStep,
    widthLimits,
} from '../src/state/units.ts';
import type { Session } from '../src/tools/session.ts';
import { picture, stateOf, untilScan, untilState } from './browser.ts';
import { page, served, useOnePage } from './one_page.ts';

useOnePage({ size: 48 });

const kOther = { kind: '', unit: '', window: 1, level: 0, iso: 0, polarity: 'rising' as const };
const ct: Kind = { range_hu: [-1024, 3071], values: { ...kOther, unit: 'HU' }, length_scale: 1 };
const plain = (low: number, high: number, length_scale = 1): Kind => ({
    range_hu: [low, high],
    values: kOther,
    length_scale,
});
const kThreshold = { unit: 'HU', low: -1000, high: 1000, step: 5 };
const kRadius = { unit: 'mm', low: 0, high: 30, step: 0.5 };

test('a slow pace is told in words', () => {
    const texts = [0, 0.034, 0.05, 0.29, 0.3, 0.39, 1, 12.3].map(paceText);
    assert.deepEqual(texts, [
        '–',
        'slow, 1/29 of real time',
        'slow, 1/20 of real time',
        'slow, 1/3 of real time',
        '0.30 × real time',
        '0.39 × real time',
        '1.0 × real time',
        '12 × real time',
    ]);
});

test('steps are 1, 2 or 5 times a power of ten, and numbers have their decimals', () => {
    for (const [value, nearest, below] of [
        [1, 1, 1],
        [1.4, 1, 1],
        [1.5, 2, 1],
        [3.1, 2, 2],
        [3.2, 5, 2],
        [7, 5, 5],
        [7.1, 10, 5],
        [0.002, 0.002, 0.002],
        [0.0144, 0.02, 0.01],
        [131, 100, 100],
    ] as const) {
        assert.equal(nearestStep(value), nearest, `nearest to ${value}`);
        assert.equal(stepUpTo(value), below, `up to ${value}`);
    }
    for (const [step, decimals] of [
        [200, 0],
        [1, 0],
        [0.5, 1],
        [0.1, 1],
        [0.02, 2],
        [0.001, 3],
        [2e-5, 5],
    ] as const)
        assert.equal(decimalsOf(step), decimals, `decimals of ${step}`);
    assert.equal(roundTo(0.4637, 0.002), 0.464);
    assert.equal(roundTo(-1247, 100), -1200);
    assert.equal(fixed(-0.04, 0.1), '0.0');
    assert.equal(fixed(0.5, 0.002), '0.500');
});

test('values in HU keep the limits of CT; others have those of their range', () => {
    for (const scan of [null, ct, { range_hu: [-1000, 800] } as Kind]) {
        assert.equal(unitOf(scan), 'HU');
        assert.equal(valueLimits(scan, kThreshold), kThreshold);
        assert.equal(widthLimits(scan, kThreshold), kThreshold);
        assert.equal(valueScale(scan), 1);
        assert.equal(valueStep(scan), 1);
    }
    const limits = (scan: Kind): readonly unknown[] => {
        const { unit, low, high, step } = valueLimits(scan, kThreshold);
        return [unit, low, high, step];
    };
    assert.deepEqual(limits(plain(0, 1)), ['', 0, 1, 0.002]);
    assert.deepEqual(limits(plain(0, 255)), ['', 0, 255, 1]);
    assert.deepEqual(limits(plain(0, 9968)), ['', 0, 9980, 20]);
    assert.deepEqual(limits(plain(2774, 56748)), ['', 2700, 56800, 100]);
    assert.deepEqual(limits(plain(-0.31, 0.52)), ['', -0.31, 0.52, 0.002]);
    assert.deepEqual(limits(plain(7, 7)), ['', 7, 7.002, 0.002]);
    const { low, high, step } = widthLimits(plain(0, 1), kThreshold);
    assert.deepEqual([low, high, step], [0.002, 1, 0.002]);
    assert.equal(valueScale(plain(0, 1)), 1 / 4000);
});

test('a value is shown with its unit, and with the decimals of its range', () => {
    assert.equal(textWithUnit(ct, -523.4), '-523 HU');
    assert.equal(textWithUnit(ct, -0.3), '0 HU');
    assert.equal(textWithUnit(plain(0, 1), 0.42618), '0.426');
    assert.equal(textWithUnit(plain(0, 255), 107.7), '108');
    assert.equal(textWithUnit(plain(0, 65504), 24416), '24416');
});

test('the window of values within 0…1 is as exact as their step', () => {
    const size = [20, 20, 20] as const;
    const halves = Uint16Array.from({ length: 8000 }, (_, i) => halfOfFloat((i % 20) / 20));
    const direction = [
        [1, 0, 0],
        [0, 1, 0],
        [0, 0, 1],
    ] as const;
    const grid = { size, spacing: [1, 1, 1], origin: [0, 0, 0], direction } as const;
    const { window, level } = autoWindow(new VolumeData(grid, halves), 0.002);
    assert.equal(window, 0.9); // the lowest value counts as padding
    assert.equal(level, 0.5);
});

test('lengths of a body stay; those of a specimen are round, with more decimals', () => {
    for (const scan of [null, ct, plain(0, 1, 0.96)]) {
        assert.deepEqual(lengthLimits(scan, kRadius), kRadius);
        assert.equal(lengthFor(scan, 4, 0.5), 4);
        assert.equal(lengthText(scan, 12.345), '12.3');
        assert.equal(areaText(scan, 616.04), '616.0');
    }
    const specimen = plain(0, 1, 0.0144); // 72 voxels of 20 µm
    assert.deepEqual(lengthLimits(specimen, kRadius), { ...kRadius, high: 0.6, step: 0.01 });
    assert.equal(roundLength(specimen, 1), 0.02);
    assert.equal(lengthFor(specimen, 4, 0.5), 0.06);
    assert.equal(lengthFor(specimen, 0.01, 0.5), 0.01); // never 0
    assert.equal(lengthText(specimen, 0.9334), '0.933');
    assert.equal(areaText(specimen, 0.0614912), '0.06149');
    const ruler = valueOf('ruler', [
        [0, 0, 0],
        [0.2532, 0, 0],
    ])!;
    assert.equal(valueText(ruler, 0.02), '0.253 mm');
    assert.equal(valueText(ruler), '0.25 mm');
});

test('the colours of displacements begin at lengths of the scan', () => {
    const { overlay, scan } = initialState();
    const shown = { ...overlay, kind: 'displacement' as const };
    const highOf = (volume: Kind): number =>
        rangeOf({ overlay: shown, scan: { ...scan, volume: volume as never } }).high;
    assert.equal(highOf(ct), 0.5);
    assert.equal(highOf(plain(0, 1, 0.0144)), 0.01);
    assert.equal(kKinds.displacement.text(1.234, ct), 'moved 1.23 mm');
    assert.equal(kKinds.displacement.text(0.01234, plain(0, 1, 0.0144)), 'moved 0.0123 mm');
});

// --- in the page

const kSide = 36;

/// A tube in a cylinder; values: outside and in the tube, in the cylinder.
function scan(dark: number, bright: number, spacing: number, type: 'float' | 'ushort'): Buffer {
    const header = [
        'NRRD0004',
        `type: ${type === 'float' ? 'float' : 'unsigned short'}`,
        'dimension: 3',
        'space: left-posterior-superior',
        `sizes: ${kSide} ${kSide} ${kSide}`,
        `space directions: (${spacing},0,0) (0,${spacing},0) (0,0,${spacing})`,
        'space origin: (0,0,0)',
        'endian: little',
        'encoding: raw',
        '',
        '',
    ].join('\n');
    const values = Array.from({ length: kSide ** 3 }, (_, at) => {
        const x = (at % kSide) - 17.5;
        const y = (Math.floor(at / kSide) % kSide) - 17.5;
        const noise = 0.9 + ((at * 7919) % 101) / 500; // 0.9 … 1.1
        const far = Math.hypot(x, y);
        return noise * (far < 16 && far > 5 ? bright : dark);
    });
    const voxels =
        type === 'float' ? Float32Array.from(values) : Uint16Array.from(values, Math.round);
    return Buffer.concat([Buffer.from(header, 'latin1'), Buffer.from(voxels.buffer)]);
}

async function open(name: string, buffer: Buffer): Promise<void> {
    await page.locator('#files').setInputFiles({ name, mimeType: '', buffer });
    await page.locator('dialog.replace button').first().click();
    await untilScan(page, name);
}

/// Slider of a label: limits, step of its number, text for screen readers, and shown unit.
const sliderOf = (label: string): Promise<{ low: number; high: number; step: number } & Texts> =>
    page.evaluate((wanted) => {
        const all = [...document.querySelectorAll('.slider')];
        const slider = all.find((e) => e.querySelector('label')!.textContent === wanted)!;
        const [range, number] = slider.querySelectorAll('input');
        return {
            low: Number(range!.min),
            high: Number(range!.max),
            step: Number(number!.step),
            number: number!.value,
            text: range!.getAttribute('aria-valuetext')!,
            unit: slider.querySelector('.unit')!.textContent!,
        };
    }, label);
interface Texts {
    number: string;
    text: string;
    unit: string;
}

const optionsOf = (label: string): Promise<string[]> =>
    page.getByLabel(label, { exact: true }).locator('option:not([disabled])').allTextContents();

/// Text of the panels that are visible, with the hints.
const panelsText = (): Promise<string> =>
    page.evaluate(() => {
        for (const part of document.querySelectorAll<HTMLDetailsElement>('.panels details'))
            part.open = true;
        const hints = [...document.querySelectorAll<HTMLElement>('.panels [title]')];
        const texts = hints.filter((e) => e.offsetParent).map((e) => e.title);
        return [document.querySelector<HTMLElement>('.panels')!.innerText, ...texts].join('\n');
    });

test('a CT has HU, and the usual limits', async () => {
    const { low, high, step, unit } = await sliderOf('Threshold');
    assert.deepEqual([low, high, step, unit], [-1000, 1000, 5, 'HU']);
    assert.equal((await sliderOf('Threshold')).text, '-500 HU');
    assert.equal((await sliderOf('Air below')).unit, 'HU');
    assert.deepEqual(await optionsOf('Presets of the threshold'), [
        'Airway, bowel, sinus',
        'Skin',
        'Bone',
        'Vessel with contrast',
    ]);
    const { sections, tool } = await stateOf(page);
    assert.deepEqual([sections.window, sections.level], [1500, -200]);
    assert.match(await panelsText(), /\bHU\b/);
    assert.ok(tool.radius > 0);
});

test('an MR has no unit, limits of its range, and its own window and presets', async (t) => {
    if (served.mock) return t.skip('the mock reads no scans');
    await open('mr.nrrd', scan(60, 9000, 4, 'ushort'));
    const { scan: mr, sections, shared, tool } = await stateOf(page);
    const { range_hu, values } = mr.volume!;
    assert.equal(values!.unit, '');
    const threshold = await sliderOf('Threshold');
    assert.deepEqual([threshold.low, threshold.high], [40, 9900]);
    assert.deepEqual([threshold.step, threshold.unit], [20, '']);
    assert.equal(threshold.text, String(Math.round(shared!.iso_hu)));
    assert.equal(threshold.number, threshold.text);
    for (const label of ['Window', 'Level', 'Bone above', 'Air below'])
        assert.deepEqual((await sliderOf(label)).unit, '', label);
    assert.ok(Math.abs(sections.window - values!.window) <= 10, `window ${sections.window}`);
    assert.deepEqual(await optionsOf('Presets of the threshold'), ['Automatic']);
    assert.deepEqual(await optionsOf('Presets of window and level'), ['As at the start', 'All']);
    await page.getByLabel('Presets of window and level', { exact: true }).selectOption('All');
    const all = (await stateOf(page)).sections;
    assert.equal(all.window, range_hu[1] - range_hu[0]);
    assert.doesNotMatch(await panelsText(), /\bHU\b/);
    assert.equal(tool.radius, 8); // two voxels; 144 mm are a body
    assert.match((await page.locator('#pointer').textContent())!, /^crosshair: \d+ · LPS /);
    // A drag of the window and the keys of the threshold have steps of the range.
    await page.locator('.view.axial').focus();
    const { iso_hu } = (await stateOf(page)).shared!;
    await page.keyboard.press('.');
    await page.waitForFunction((before) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        return store.state.shared!.iso_hu !== before;
    }, iso_hu);
    assert.equal((await stateOf(page)).shared!.iso_hu - iso_hu, 60);
    await picture(page, 'values_mr');
});

test('data of 0…1 has steps of 0.002, and a volume that is visible', async (t) => {
    if (served.mock) return t.skip('the mock reads no scans');
    await open('unit.nrrd', scan(0.05, 0.85, 4, 'float'));
    const { low, high, step, text } = await sliderOf('Level');
    assert.ok(low < 0.1 && high > 0.9 && high < 1, `${low}…${high}`);
    assert.equal(step, 0.002);
    assert.match(text, /^0\.\d{1,3}$/);
    await page.getByRole('button', { name: 'Automatic' }).click();
    const { sections } = await stateOf(page);
    assert.ok(sections.window > 0.5 && sections.window < 1, `window ${sections.window}`);
    assert.match((await page.locator('#pointer').textContent())!, /^crosshair: 0\.\d{3} · LPS /);
    await page.locator('.view.endoscope').focus();
    await page.keyboard.press('Shift+O');
    await page.waitForFunction(
        () => (window as never as { pliant: Session }).pliant.store.state.rendering.preset !== '',
    );
    const from = await sliderOf('Visible from');
    assert.ok(Number(from.number) > 0 && Number(from.number) < 1, from.number);
    assert.equal(from.unit, '');
    await page.keyboard.press('Shift+O');
});

test('a scan of 20 µm has lengths of its size', async (t) => {
    if (served.mock) return t.skip('the mock reads no scans');
    await open('micro.nrrd', scan(9000, 52000, 0.02, 'ushort'));
    const number = page.getByLabel('Threshold, number');
    await number.fill('40000');
    await number.press('Enter');
    await untilState(page, ({ shared }) => shared?.iso_hu === 40000, 5);
    const { volume } = (await stateOf(page)).scan;
    assert.equal(volume!.length_scale, 0.0072);
    const size = await sliderOf('Size');
    assert.deepEqual([size.step, size.text], [0.005, '0.04 mm']);
    assert.ok(Math.abs(size.high - Math.sqrt(0.3)) < 1e-6, `${size.high}`);
    assert.deepEqual((await sliderOf('Cut depth')).text, '0.07 mm');
    assert.deepEqual((await sliderOf('Tip')).text, '0.02 mm');
    const caption = page.locator('.view.axial .caption');
    assert.match((await caption.textContent())!, /^z \d\.\d{3} mm · slice \d+ of 36$/);
    assert.match((await page.locator('#pointer').textContent())!, /LPS (\d\.\d{3}[, ]+){3}mm/);
    assert.match((await page.locator('.view.axial text.scale').textContent())!, /^0\.[125] mm$/);
    await page.locator('.view.axial').focus();
    await page.keyboard.press('u');
    assert.equal((await stateOf(page)).sections.slab, 0.07);
    await caption.filter({ hasText: /maximum of 0\.07 mm$/ }).waitFor({ timeout: 5000 });
    await page.evaluate(() => {
        const { marks, store } = (window as never as { pliant: Session }).pliant;
        const [x, y, z] = store.state.sections.cursor;
        store.set({ tool: { name: 'measure' }, marks: { kind: 'ruler' } });
        marks.click([x, y, z]);
        marks.click([x, y, z + 0.1234]);
    });
    assert.match(await page.locator('ul.marks output').first().innerText(), /^0\.123 mm$/);
    await picture(page, 'values_micro');
});

test('tissue of a scan of 20 µm is pushed in steps of its size', async (t) => {
    if (served.mock) return t.skip('the mock reads no scans');
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ tool: { name: 'push' }, pointer: { active: 'axial' } });
    });
    const before = (await stateOf(page)).sections.cursor;
    await page.locator('.view.axial').focus();
    await page.keyboard.press('Alt+ArrowRight');
    await page.waitForFunction((x) => {
        const { store } = (window as never as { pliant: Session }).pliant;
        return store.state.sections.cursor[0] !== x;
    }, before[0]);
    const after = (await stateOf(page)).sections.cursor;
    assert.ok(Math.abs(after[0] - before[0] - 0.01) < 1e-9, `${after[0] - before[0]}`);
});

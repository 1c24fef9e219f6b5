// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Files: dropped or chosen scans replace the present one, saved files are the server's, and errors
// are one line.

import assert from 'node:assert/strict';
import { mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { readFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { basename, join } from 'node:path';
import { test } from 'node:test';
import { gunzipSync, gzipSync } from 'node:zlib';
import { scanOf } from '../src/tools/dropped.ts';
import { labelReason } from '../src/tools/label_guess.ts';
import { type Series, seriesDescription, seriesRow } from '../src/tools/series.ts';
import type { Session } from '../src/tools/session.ts';
import {
    compare,
    picture,
    pixels,
    stateOf,
    untilScan as untilScanOn,
    untilState,
    untilUndo,
    visit,
} from './browser.ts';
import { dicomSlice } from './dicom.ts';
import { browser, page, served, useOnePage } from './one_page.ts';
import { plateStl } from './plate.ts';

useOnePage({ expected: 'status of 400' });

const kSize = [36, 40, 44] as const;

/// A ball of air in tissue.
function nrrd(): Buffer {
    const header = [
        'NRRD0004',
        'type: short',
        'dimension: 3',
        'space: left-posterior-superior',
        `sizes: ${kSize.join(' ')}`,
        'space directions: (1,0,0) (0,1,0) (0,0,1)',
        'space origin: (-18,-20,-22)',
        'endian: little',
        'encoding: raw',
        '',
        '',
    ].join('\n');
    const voxels = Buffer.alloc(2 * kSize[0] * kSize[1] * kSize[2]);
    let at = 0;
    for (let k = 0; k < kSize[2]; ++k)
        for (let j = 0; j < kSize[1]; ++j)
            for (let i = 0; i < kSize[0]; ++i, at += 2) {
                const off = Math.hypot(i - 18, j - 20, k - 22);
                voxels.writeInt16LE(Math.round(-1000 + 1040 * Math.min(1, off / 12)), at);
            }
    return Buffer.concat([Buffer.from(header, 'latin1'), voxels]);
}

const choose = (name: string, buffer: Buffer): Promise<void> =>
    page.locator('#files').setInputFiles({ name, mimeType: '', buffer });

/// Agrees that a scan takes the place of the present one.
const agree = (): Promise<void> => page.locator('dialog.replace button').first().click();

/// Drops files on the page like the browser, but without folders, which can't be created here.
const drop = (files: { name: string; text: string }[]): Promise<void> =>
    page.evaluate((all) => {
        const data = new DataTransfer();
        for (const { name, text } of all) {
            const bytes = Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
            data.items.add(new File([bytes], name));
        }
        const settings = { dataTransfer: data, bubbles: true, cancelable: true };
        document.querySelector('main')!.dispatchEvent(new DragEvent('drop', settings));
    }, files);

const untilScan = (name: string): Promise<void> => untilScanOn(page, name);

const untilSaid = (text: string): Promise<unknown> =>
    page.waitForFunction(
        (wanted) => document.querySelector('.message')!.textContent!.includes(wanted),
        text,
        { timeout: 30_000 },
    );

test('names of files that are dropped together fit into one folder', () => {
    const file = (path: string) => ({ path, file: new File(['x'], path.split('/').pop()!) });
    const scan = scanOf(
        ['CT/.DS_Store', 'CT/a/1.dcm', 'CT/b/1.dcm', 'CT/2.dcm', 'CT/Thumbs.db'].map(file),
    );
    assert.equal(scan.name, 'CT');
    assert.deepEqual(
        scan.files.map(({ path }) => path),
        ['1.dcm', 'CT_b_1.dcm', '2.dcm'],
    );
    assert.throws(() => scanOf([file('CT/.hidden')]), /found no file/);
    assert.throws(() => scanOf(Array.from({ length: 5000 }, (_, n) => file(`${n}`))), /4096/);
});

test('a chosen scan replaces the present one', async () => {
    await page.evaluate(async () => {
        const { pliant } = window as never as { pliant: Session };
        const { cursor } = pliant.store.state.sections;
        await pliant.ask({ do: 'push', point: cursor, push: [2, 0, 0], radius: 6 });
    });
    await untilUndo(page, 1);
    const before = await pixels(page, 'axial');
    await choose('ball.nrrd', nrrd());
    assert.match((await page.locator('dialog.replace').textContent())!, /It replaces /);
    await picture(page, 'replace');
    await agree();
    await untilScan('ball.nrrd');
    const state = await stateOf(page);
    assert.equal(state.scan.volume!.id, 2);
    assert.equal(state.shared!.undo.steps, 0);
    if (!served.mock) assert.deepEqual(state.scan.volume!.size, [...kSize]);
    if (!served.mock) assert.notEqual((await pixels(page, 'axial')).hash, before.hash);
    assert.equal((await compare(page))!.same, true);
    assert.match(await page.title(), /ball\.nrrd/);
    await untilSaid('opened ball.nrrd');
    await picture(page, 'opened');
});

test('tissue of the new scan can be pushed, and its volume saved', async () => {
    await page.evaluate(async () => {
        const { pliant } = window as never as { pliant: Session };
        await pliant.ask({ do: 'push', point: [0, 10, 0], push: [0, 2, 0], radius: 3 });
    });
    await untilUndo(page, 1);
    assert.equal((await compare(page))!.same, true);
    for (const [way, name] of [
        ['keys', 'volume.nrrd'],
        ['menu', 'displacement.nrrd'],
        ['menu', 'transform.nrrd'],
        ['menu', 'session.pls'],
    ] as const) {
        const coming = page.waitForEvent('download');
        if (way === 'keys') await page.keyboard.press('Control+s');
        else await page.locator('#save').selectOption({ label: labelOf(name) });
        const download = await coming;
        assert.equal(download.suggestedFilename(), name);
        const bytes = await readFile((await download.path())!);
        const own = await page.evaluate(async (file) => {
            const { hash } = location;
            const token = new URLSearchParams(hash.slice(1)).get('token');
            const response = await fetch(`save/${file}?token=${token}`);
            return (await response.arrayBuffer()).byteLength;
        }, name);
        assert.equal(bytes.length, own);
        await page.waitForFunction(
            () => !(window as never as { pliant: Session }).pliant.store.state.link.transfer,
        );
        if (served.mock || !name.endsWith('.nrrd')) continue;
        const end = bytes.indexOf('\n\n') + 2;
        const header = bytes.subarray(0, end).toString('latin1');
        assert.match(header, new RegExp(`sizes: (3 )?${kSize.join(' ')}\n`));
        const numbers = name === 'volume.nrrd' ? 2 : 12;
        assert.equal(
            gunzipSync(bytes.subarray(end)).length,
            numbers * kSize[0] * kSize[1] * kSize[2],
        );
    }
    await untilSaid('saved session.pls');
});

test('the state of the tissue is saved, and loaded again if the user agrees', async (t) => {
    if (served.mock) return t.skip('the mock has no tissue');
    const sum = async (): Promise<string> => (await compare(page))!.tissue;
    const push = async (y: number): Promise<void> => {
        await page.evaluate(async (way) => {
            const { pliant } = window as never as { pliant: Session };
            await pliant.ask({ do: 'push', point: [0, 10, 0], push: [0, way, 0], radius: 3 });
        }, y);
    };
    const saved = await sum();
    const coming = page.waitForEvent('download');
    await page.locator('#save').selectOption({ label: 'state of the tissue (.plst)' });
    const download = await coming;
    assert.equal(download.suggestedFilename(), 'state.plst');
    const state = await readFile((await download.path())!);
    await push(1);
    assert.notEqual(await sum(), saved);
    const pushed = await sum();
    const dialog = page.locator('dialog.replace');
    await choose('state.plst', state);
    assert.match((await dialog.textContent())!, /state of the tissue of ball\.nrrd/);
    await picture(page, 'load_state');
    await dialog.getByText('Cancel').click();
    assert.equal(await sum(), pushed);
    await choose('cut.plst', state.subarray(0, state.length - 9));
    await agree();
    await untilSaid('cut.plst: ');
    assert.equal(await sum(), pushed);
    await drop([{ name: 'state.plst', text: state.toString('base64') }]);
    await agree();
    await untilSaid('loaded state.plst');
    assert.equal(await sum(), saved);
    assert.equal((await compare(page))!.same, true);
    assert.equal((await stateOf(page)).shared!.undo.steps, 0);
});

const labelOf = (name: string): string =>
    name.startsWith('session')
        ? 'session (.pls)'
        : name.startsWith('transform')
          ? 'transform for 3D Slicer (.nrrd)'
          : `${name.split('.')[0]} (.nrrd)`;

test('a file that is no scan is refused with one line, and nothing changes', async () => {
    const { volume } = (await stateOf(page)).scan;
    await choose('bad.nrrd', Buffer.from('hello'));
    await agree();
    await untilSaid('bad.nrrd: is no NRRD file');
    await picture(page, 'opened_bad');
    assert.equal((await stateOf(page)).scan.volume!.id, volume!.id);
    await page.evaluate(() => {
        (window as never as { pliant: Session }).pliant.store.set({ link: { openBytes: 10 } });
    });
    await choose('large.nrrd', nrrd());
    await untilSaid('large.nrrd: 1 MiB, expected a scan of up to 1 MiB');
    await page.evaluate(() => {
        (window as never as { pliant: Session }).pliant.store.set({ link: { openBytes: 0 } });
    });
    assert.equal((await compare(page))!.same, true);
});

test('a scan is opened only if the user agrees', async () => {
    const { volume } = (await stateOf(page)).scan;
    await choose('ball.nrrd', nrrd());
    await page.locator('dialog.replace').getByText('Cancel').click();
    await page.locator('dialog.replace').waitFor({ state: 'detached' });
    assert.equal((await stateOf(page)).link.transfer, '');
    assert.equal((await stateOf(page)).scan.volume!.id, volume!.id);
});

test('a scan begins with the usual window, and with tools of its size', async (t) => {
    if (served.mock) return t.skip('the mock reads no scans');
    await page.evaluate(() => {
        const { store } = (window as never as { pliant: Session }).pliant;
        store.set({ sections: { window: 40_000, level: 30_000 } });
    });
    const small = '(.02,0,0) (0,.02,0) (0,0,.02)';
    const text = nrrd().toString('latin1').replace('(1,0,0) (0,1,0) (0,0,1)', small);
    await choose('small.nrrd', Buffer.from(text, 'latin1'));
    await agree();
    await untilScan('small.nrrd');
    const { sections, tool, flight, scan } = await stateOf(page);
    const unit = scan.volume!.values!.unit;
    assert.match(
        (await page.locator('#pointer').textContent())!,
        unit ? /^crosshair: -?\d+ HU · / : /^crosshair: -?\d+ · /,
    );
    assert.ok(sections.window < 5000, `window ${sections.window}`);
    for (const length of [tool.radius / 4, tool.depth / 10, flight.tip / 2.5])
        assert.ok(length > 0.001 && length < 0.1, `factor ${length}`);
    await choose('ball.nrrd', nrrd());
    await agree();
    await untilScan('ball.nrrd');
    assert.ok((await stateOf(page)).tool.radius > 10 * tool.radius);
    // No command was too early for it.
    assert.doesNotMatch((await page.locator('.message').textContent())!, /expected to see it/);
});

/// The ball as labels 0, 1 and 2.
function labels(): Buffer {
    const scan = nrrd();
    for (let at = scan.indexOf('\n\n') + 2; at < scan.length; at += 2)
        scan.writeInt16LE((at >> 1) % 3, at);
    return scan;
}

test('a label map is known by its name or by few whole values', async () => {
    const scan = nrrd();
    const end = scan.indexOf('\n\n') + 2;
    const packed = (all: Buffer): Buffer =>
        Buffer.concat([
            Buffer.from(all.subarray(0, end).toString('latin1').replace('raw', 'gzip'), 'latin1'),
            gzipSync(all.subarray(end)),
        ]);
    const nifti = (all: Buffer): Buffer => {
        const head = Buffer.alloc(352);
        head.writeInt32LE(348, 0);
        head.writeInt16LE(4, 70);
        head.writeFloatLE(352, 108);
        head.write('n+1', 344);
        return gzipSync(Buffer.concat([head, all.subarray(end)]));
    };
    const reason = (name: string, data: Buffer): Promise<string | undefined> =>
        labelReason(name, new Blob([new Uint8Array(data)]));
    for (const name of ['thorax-label.nrrd', 'Segmentation_1.nii.gz', 'lung_seg.mha', 'mask.nrrd'])
        assert.equal(await reason(name, scan), 'by its name', name);
    for (const form of [(all: Buffer) => all, packed, nifti]) {
        assert.equal(await reason('ball', form(labels())), 'it holds 3 whole values');
        assert.equal(await reason('segment of a ball', form(scan)), undefined);
    }
    assert.equal(await reason('unmasked.nrrd', Buffer.from('NRRD0004\n')), undefined);
    await choose('organs.nrrd', labels());
    const dialog = page.locator('dialog.replace');
    await dialog.getByText('looks like a label map (it holds 3 whole values)').waitFor();
    await picture(page, 'label_map');
    await page.keyboard.press('Enter'); // the button in focus
    await dialog.waitFor({ state: 'detached' });
    assert.equal((await stateOf(page)).link.transfer, '');
});

test('a file that hovers over the page is awaited', async () => {
    const landing = page.locator('.landing');
    const hover = (type: string): Promise<void> =>
        page.evaluate((event) => {
            const settings = { dataTransfer: new DataTransfer(), bubbles: true, cancelable: true };
            document.querySelector('main')!.dispatchEvent(new DragEvent(event, settings));
        }, type);
    await hover('dragover');
    assert.ok(await landing.isVisible());
    await picture(page, 'drop_hover');
    await hover('dragleave');
    assert.ok(!(await landing.isVisible()));
});

test('Escape cancels the upload of a scan', async () => {
    const { volume } = (await stateOf(page)).scan;
    const stuck: (() => Promise<void>)[] = [];
    await page.route('**/open?*', (route) => void stuck.push(() => route.abort()));
    await choose('slow.nrrd', nrrd());
    await agree();
    await page.waitForFunction(() =>
        document.querySelector('.notice')!.textContent!.includes('Esc cancels'),
    );
    await page.keyboard.press('Escape');
    await untilSaid('opening was cancelled');
    assert.equal((await stateOf(page)).link.transfer, '');
    assert.equal((await stateOf(page)).scan.volume!.id, volume!.id);
    // Ended first: unroute() would let the request continue, and the server would open the scan.
    await Promise.allSettled(stuck.map((end) => end()));
    await page.unroute('**/open?*');
});

test('files are dropped together; a path that is dropped stays a path', async () => {
    const scan = nrrd();
    const end = scan.indexOf('\n\n') + 1;
    const header = `${scan.subarray(0, end).toString('latin1')}data file: ball.raw\n`;
    await drop([
        { name: 'ball.raw', text: scan.subarray(end + 1).toString('base64') },
        { name: 'ball.nhdr', text: Buffer.from(header, 'latin1').toString('base64') },
    ]);
    await agree();
    await untilScan(served.mock ? 'scan' : 'ball.nhdr');
    if (served.mock) assert.deepEqual(served.mock.parts, ['ball.raw', 'ball.nhdr']);
    assert.equal((await compare(page))!.same, true);
    const { volume } = (await stateOf(page)).scan;
    const path = {
        markups: [
            {
                type: 'Curve',
                coordinateSystem: 'LPS',
                controlPoints: [{ position: [0, 0, -5] }, { position: [0, 0, 5] }],
            },
        ],
    };
    const text = Buffer.from(JSON.stringify(path)).toString('base64');
    await drop([{ name: 'way.mrk.json', text }]);
    await untilSaid('way.mrk.json: a path');
    const state = await stateOf(page);
    assert.equal(state.scan.volume!.id, volume!.id);
    assert.ok(state.way.path);
});

test('the user chooses one of several DICOM series in a folder', async (t) => {
    if (served.mock) return t.skip('the mock reads no DICOM');
    const files = [0, 1, 2, 3, 4].map((z) => {
        const bytes =
            z < 3
                ? dicomSlice('1.2.3', 'arterial', z, 10 * z, '11')
                : dicomSlice('1.2.4', 'venous', z, 10 * z, '2');
        return { name: `IM${z}`, text: bytes.toString('base64') };
    });
    const { volume } = (await stateOf(page)).scan;
    const dialog = page.locator('dialog.series');
    await drop(files);
    await agree();
    await dialog.waitFor();
    await picture(page, 'series');
    const rows = await dialog
        .locator('tr')
        .evaluateAll((all) => all.map((row) => [...row.children].map((cell) => cell.textContent)));
    assert.deepEqual(rows, [
        ['number', 'description', 'modality', 'slices', 'size', 'spacing [mm]'],
        ['2', 'venous', 'CT', '2', '8 × 6 × 2', '1 × 1 × 1'],
        ['11', 'arterial', 'CT', '3', '8 × 6 × 3', '1 × 1 × 1'],
    ]);
    await page.keyboard.press('Escape');
    await untilSaid('no series was chosen');
    assert.equal(await dialog.count(), 0);
    assert.equal((await stateOf(page)).scan.volume!.id, volume!.id);
    // At once again: nothing of the first attempt is left.
    await drop(files);
    await agree();
    await dialog.getByRole('button', { name: 'venous' }).click();
    await untilScan('venous');
    assert.deepEqual((await stateOf(page)).scan.volume!.size, [8, 6, 2]);
    assert.deepEqual((await stateOf(page)).scan.volume!.range_hu, [30, 40]);
});

test('a series without a number, of several volumes or unreadable has a row as well', () => {
    const usual: Series = {
        number: '',
        description: 'cine',
        modality: 'MR',
        slices: 60,
        volumes: 20,
        size: [256, 256, 3],
        spacing_mm: [0.97656, 0.97656, 8],
        uid: '1.2',
    };
    const several = ['', 'cine', 'MR', '60', '256 × 256 × 3 (20 volumes)', '0.9766 × 0.9766 × 8'];
    assert.deepEqual(seriesRow(usual), several);
    const faulty = { ...usual, volumes: 1, size: [0, 0, 0], fault: 'IM3: is cut off' } as const;
    assert.deepEqual(seriesRow(faulty), ['', 'cine', 'MR', '60', "can't be read", '']);
});

test('files of a series have its description as their name, a folder keeps its own', async (t) => {
    if (served.mock) return t.skip('the mock reads no DICOM');
    const slices = [0, 1, 2].map((z) => dicomSlice('1.2.5', 'late phase', z, z));
    await drop(slices.map((bytes, z) => ({ name: `IM${z}`, text: bytes.toString('base64') })));
    await agree();
    await untilScan('late phase');
    const folder = mkdtempSync(join(tmpdir(), 'pliant-series-'));
    slices.forEach((bytes, z) => writeFileSync(join(folder, `IM${z}`), bytes));
    const [choice] = await Promise.all([
        page.waitForEvent('filechooser'),
        page.getByRole('button', { name: 'Folder…' }).click(),
    ]);
    await choice.setFiles(folder);
    await agree();
    await untilScan(basename(folder));
    assert.deepEqual((await stateOf(page)).scan.volume!.size, [8, 6, 3]);
    rmSync(folder, { recursive: true });
});

test('a description is found in explicit and implicit DICOM headers only', async () => {
    const found = (bytes: Buffer): Promise<string> =>
        seriesDescription(new Blob([Uint8Array.from(bytes)]));
    const explicit = dicomSlice('1.2.5', 'late phase ', 0, 0);
    assert.equal(await found(explicit), 'late phase');
    const at = explicit.indexOf(Buffer.from([0x08, 0, 0x3e, 0x10]));
    const implicit = Buffer.from(explicit);
    implicit.writeUInt32LE(explicit.readUInt16LE(at + 6), at + 4);
    assert.equal(await found(implicit), 'late phase');
    const tooLong = Buffer.from(explicit);
    tooLong.writeUInt16LE(60_000, at + 6);
    for (const other of [tooLong, nrrd(), Buffer.alloc(0), explicit.subarray(0, at + 12)])
        assert.equal(await found(other), '');
});

test('the surface of an organ is opened as a body that can be pushed', async (t) => {
    if (served.mock) return t.skip('the mock has no bodies');
    const before = (await stateOf(page)).scan.volume!.id;
    await choose('damaged.stl', Buffer.from('solid liver'));
    await agree();
    await untilSaid('damaged.stl');
    assert.equal((await stateOf(page)).scan.volume!.id, before);
    await choose('plate.stl', plateStl());
    await agree();
    await untilScan('plate.stl');
    await untilState(page, ({ scan }) => scan.loaded === 1, 20);
    const { scan, shared } = await stateOf(page);
    assert.equal(shared!.tissue!.model, 'own');
    assert.equal(scan.volume!.values?.unit ?? 'HU', 'HU');
    const sum = (await compare(page))!;
    await page.evaluate(() =>
        (window as unknown as { pliant: Session }).pliant.connection.ask({
            do: 'push',
            point: [0, -6, 0],
            push: [0, 3, 0],
            radius: 8,
            stroke: 1,
        } as never),
    );
    const pushed = (await compare(page))!;
    assert.ok(pushed.same && pushed.tissue !== sum.tissue, 'the body moves');
    await picture(page, 'organ');
    // A cut across the plate, and a pull beside it.
    const links = await page.evaluate(async () => {
        const { connection } = (window as unknown as { pliant: Session }).pliant;
        const line = [
            [10, -9, -40],
            [10, -9, 40],
        ];
        const cut = await connection.ask({ do: 'cut', line, depth: [0, 11, 0] } as never);
        await connection.ask({
            do: 'push',
            point: [18, -5, 0],
            push: [5, 0, 0],
            radius: 6,
            stroke: 2,
        } as never);
        return cut?.t === 'done' ? (cut.cut_links ?? 0) : 0;
    });
    assert.ok(links > 500, `${links} links are cut`);
    const opened = (await compare(page))!;
    assert.ok(opened.same && opened.tissue !== pushed.tissue, 'the cut opens');
    await picture(page, 'organ_cut');
});

test('the user chooses one of several images in a file', async (t) => {
    if (served.mock) return t.skip('the mock reads no scans');
    const images = [10, 20, 30].map((value) => {
        const voxels = Buffer.alloc(2 * 8 * 8 * 8);
        for (let at = 0; at < voxels.length; at += 2) voxels.writeInt16LE(value, at);
        return voxels;
    });
    const header = [
        'NRRD0004',
        'type: short',
        'dimension: 4',
        'space: left-posterior-superior',
        'sizes: 8 8 8 3',
        'space directions: (1,0,0) (0,1,0) (0,0,1) none',
        'kinds: domain domain domain list',
        'endian: little',
        'encoding: raw',
        '',
        '',
    ].join('\n');
    const bytes = Buffer.concat([Buffer.from(header, 'latin1'), ...images]);
    const { volume } = (await stateOf(page)).scan;
    const dialog = page.locator('dialog.series');
    await choose('time.nrrd', bytes);
    await agree();
    await dialog.getByText('time.nrrd: which of 3 images?').waitFor();
    await picture(page, 'images');
    await page.keyboard.press('Escape');
    await untilSaid('no image was chosen');
    assert.equal((await stateOf(page)).scan.volume!.id, volume!.id);
    await choose('time.nrrd', bytes);
    await agree();
    await dialog.locator('input').fill('2');
    await page.keyboard.press('Enter');
    await untilScan('time.nrrd');
    assert.deepEqual((await stateOf(page)).scan.volume!.range_hu, [30, 30]);
});

test('a client that only views can save, but not open', async () => {
    const { page: other } = await visit(browser, served.link, '&notour&role=view');
    assert.equal(await other.locator('#open').isDisabled(), true);
    const coming = other.waitForEvent('download');
    await other.locator('#save').selectOption({ label: 'volume (.nrrd)' });
    assert.equal((await coming).suggestedFilename(), 'volume.nrrd');
    const before = await stateOf(other);
    await other.locator('#files').setInputFiles({ name: 'x.nrrd', mimeType: '', buffer: nrrd() });
    await other.waitForFunction(() =>
        document.querySelector('.message')!.textContent!.includes('only clients that control'),
    );
    assert.equal((await stateOf(other)).scan.volume!.id, before.scan.volume!.id);
    await other.context().close();
});

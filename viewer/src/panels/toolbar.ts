// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Toolbar: files, tools, undo and redo, layout, help.

import { kWatched } from '../state/company.ts';
import { kTools, kViewing, offersVessel, suits, type ToolName } from '../state/state.ts';
import { type Actions, kUnsuited } from '../tools/actions.ts';
import { type Files, kSaved, type SavedName } from '../tools/files.ts';
import type { Session } from '../tools/session.ts';
import { button, h, menu } from './dom.ts';

const kTexts: Record<ToolName, { text: string; hint: string }> = {
    look: { text: 'Look', hint: 'left drag: look around; click: set the crosshair (1)' },
    window: { text: 'Window', hint: 'left drag in a section: window and level (2)' },
    push: { text: 'Push', hint: 'left drag: push with a sphere (3)' },
    grab: { text: 'Grab', hint: 'left drag: grab tissue and drag it (4)' },
    cut: { text: 'Cut', hint: 'left drag: draw the line of a cut (5)' },
    carve: { text: 'Carve', hint: 'left drag: remove tissue (6)' },
    path: { text: 'Path', hint: 'two clicks: find a path through the lumen between them (7)' },
    catheter: { text: 'Catheter', hint: 'arrow keys: insert, rotate; with Shift: bend (8)' },
    measure: { text: 'Measure', hint: 'clicks: a point, a ruler or an angle (9)' },
};

const kSaveTexts: Record<SavedName, string> = {
    'volume.nrrd': 'volume (.nrrd)',
    'volume.nii.gz': 'volume (.nii.gz)',
    'volume.mha': 'volume (.mha)',
    'volume.vti': 'volume (.vti)',
    'displacement.nrrd': 'displacement (.nrrd)',
    'transform.nrrd': 'transform for 3D Slicer (.nrrd)',
    'state.plst': 'state of the tissue (.plst)',
    'session.pls': 'session (.pls)',
};

export function toolbar(
    session: Session,
    actions: Actions,
    files: Files,
    hooks: { help: () => void; settings: HTMLElement },
): HTMLElement {
    const open = button(
        'Open…',
        () => files.choose(),
        'a scan, the mesh of an organ, a state (.plst) or a path (.mrk.json); or drop files, ' +
            'or a folder of DICOM slices (Ctrl+O)',
    );
    open.id = 'open';
    const folder = button(
        'Folder…',
        () => files.chooseFolder(),
        'opens a folder of DICOM slices, with a choice between its series',
    );
    folder.className = 'folder';
    const save = menu<SavedName | 'picture'>(
        'Save…',
        [
            ...kSaved.map((name) => ({ text: kSaveTexts[name], value: name })),
            { text: 'picture of the views (.png)', value: 'picture' as const },
        ],
        (chosen) => void (chosen === 'picture' ? actions.snapshot() : files.save(chosen)),
    );
    save.id = 'save';
    save.title = 'Ctrl+S saves the volume';
    session.store.watch(
        ({ link }) => [link],
        ({ role, features, transfer }) => {
            open.disabled = folder.disabled =
                role === 'view' || !features.includes('open') || transfer !== '';
            const saves = features.includes('save') && transfer === '';
            for (const [n, file] of kSaved.entries()) {
                const isKnown = file !== 'state.plst' || features.includes('state');
                save.options[n + 1]!.disabled = !saves || !isKnown;
            }
        },
    );
    const { store, history } = session;
    const tools = kTools.map((name) => {
        const b = button(kTexts[name].text, () => actions.choose(name), kTexts[name].hint);
        b.dataset.tool = name;
        return b;
    });
    const undo = button('Undo', () => void history.undo());
    undo.id = 'undo';
    const redo = button('Redo', () => void history.redo());
    redo.id = 'redo';
    const name = h('span', { class: 'scan' });
    store.watch(
        ({ tool, link, shared, replay }) => [tool, link, shared, replay.isOn],
        (tool, link, shared, isWatched) => {
            for (const b of tools) {
                b.hidden = b.dataset.tool === 'catheter' && !offersVessel(shared);
                b.setAttribute('aria-pressed', String(b.dataset.tool === tool.name));
                const name = b.dataset.tool as ToolName;
                const may = link.role !== 'view' || kViewing.includes(name);
                const fits = suits(store.state, name);
                b.disabled = !may || !fits;
                b.title = !may && isWatched ? kWatched : fits ? kTexts[name].hint : kUnsuited;
            }
        },
    );
    // Own steps are no part of the state, so every change is checked.
    const refresh = (): void => {
        const names = history.names();
        undo.disabled = !names.undo;
        redo.disabled = !names.redo;
        undo.title = `undo ${names.undo} (Ctrl+Z)`;
        redo.title = `redo ${names.redo} (Ctrl+Shift+Z)`;
    };
    store.listen(refresh);
    history.onChange = refresh;
    refresh();
    store.watch(
        ({ scan: { volume } }) => [volume],
        (volume) => {
            name.textContent = volume ? volume.name : '';
            document.title = volume ? `${volume.name} – Pliant` : 'Pliant';
        },
    );
    const outside = button(
        'Outside',
        () => actions.toggleOutside(),
        'shows the lumen from outside, cut open at the tip (O)',
    );
    const views = button(
        'Views',
        () => actions.cycleViews(),
        'four views, or one maximised: each in turn (V)',
    );
    store.watch(
        ({ view, display }) => [view.outside, display.maximised],
        (isOutside, maximised) => {
            outside.setAttribute('aria-pressed', String(isOutside));
            views.setAttribute('aria-pressed', String(maximised !== null));
        },
    );
    return h(
        'header',
        {},
        h('h1', {}, 'Pliant'),
        name,
        h('div', { class: 'group' }, open, folder, files.input, files.folder, save),
        h('div', { class: 'tools', role: 'group', 'aria-label': 'Tools' }, ...tools),
        h('div', { class: 'group' }, undo, redo),
        h(
            'div',
            { class: 'group' },
            outside,
            views,
            button('?', hooks.help, 'keys and gestures (?)'),
            hooks.settings,
        ),
    );
}

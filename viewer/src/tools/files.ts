// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Transfers to and from the server: opening scans, and saving. One at a time; errors are shown as
// one line.

import { kWatched } from '../state/company.ts';
import { download } from './download.ts';
import { droppedFiles, kUnnamed, type NamedFile, type ScanFiles, scanOf } from './dropped.ts';
import { isLabelMap, labelReason } from './label_guess.ts';
import type { Scene } from './scene.ts';
import { type Choice, type Choices, readChoices, seriesDescription } from './series.ts';

export const kSaved = [
    'volume.nrrd',
    'volume.nii.gz',
    'volume.mha',
    'volume.vti',
    'displacement.nrrd',
    'transform.nrrd',
    'state.plst',
    'session.pls',
] as const;
export type SavedName = (typeof kSaved)[number];

export interface FileHooks {
    /// Opens a path, marks or keyframes, which stay in the page.
    openPath(file: File): Promise<void>;
    /// Lets the user choose one of several series or images. @returns undefined: none
    chooseScan(name: string, choices: Choices): Promise<Choice | undefined>;
    /// Asks whether a scan or a state of the tissue may take the place of the present one.
    askToReplace(by: Replacement): Promise<boolean>;
}

/// A scan or a state of the tissue that would replace the present one.
export interface Replacement {
    readonly what: 'scan' | 'state';
    readonly name: string;
    readonly present: string; ///< scan
    readonly others: number; ///< other clients of the session
    readonly labels: string | undefined; ///< reason to take it for a label map
}

const kKeepMs = 60_000; // time for the browser to store a download

const mib = (bytes: number): string => `${Math.ceil(bytes / 2 ** 20)} MiB`;

export class Files {
    /// Hidden file input, clicked by choose().
    readonly input: HTMLInputElement;
    /// Hidden input of a folder, clicked by chooseFolder().
    readonly folder: HTMLInputElement;
    /// Upload under way: a scan, or one file of it.
    private request: XMLHttpRequest | undefined;

    /// @param query  query string with the link's token
    constructor(
        private readonly scene: Scene,
        private readonly query: string,
        private readonly hooks: FileHooks,
    ) {
        this.input = this.makeInput('files', 'scan, state, path or marks to open');
        this.folder = this.makeInput('folder', 'folder of DICOM slices to open');
        this.folder.webkitdirectory = true;
    }

    private makeInput(id: string, label: string): HTMLInputElement {
        const input = document.createElement('input');
        input.type = 'file';
        input.id = id;
        input.multiple = true;
        input.hidden = true;
        input.setAttribute('aria-label', label);
        input.addEventListener('change', () => {
            const files = [...(input.files ?? [])];
            input.value = '';
            void this.open(
                files.map((file) => ({ path: file.webkitRelativePath || file.name, file })),
            );
        });
        return input;
    }

    /// Cancels the upload or the reading of a scan.
    cancel(): void {
        this.request?.abort();
    }

    choose(): void {
        this.input.click();
    }

    chooseFolder(): void {
        this.folder.click();
    }

    async drop(data: DataTransfer): Promise<void> {
        try {
            await this.open(await droppedFiles(data));
        } catch (error) {
            this.scene.warn((error as Error).message);
        }
    }

    async open(files: readonly NamedFile[]): Promise<void> {
        const only = files.length === 1 ? files[0]!.file : undefined;
        if (only && /\.(json|csv|ctbl)$/i.test(only.name)) return this.hooks.openPath(only);
        if (only && /\.plst$/i.test(only.name)) return this.loadState(only);
        const labels = this.scene.volume && only && isLabelMap(only.name);
        if (labels) return this.openLabels(only);
        await this.during(async () => {
            const { link, replay } = this.scene.store.state;
            const { role, features, openBytes } = link;
            if (replay.isOn) throw new Error(kWatched);
            if (role === 'view')
                throw new Error('only clients that control the session can open scans');
            if (!features.includes('open')) throw new Error('this server does not open scans');
            const scan = scanOf(files);
            const total = scan.files.reduce((sum, { file }) => sum + file.size, 0);
            if (openBytes && total > openBytes)
                throw new Error(
                    `${scan.name}: ${mib(total)}, expected a scan of up to ${mib(openBytes)}`,
                );
            const described =
                scan.name === kUnnamed ? await seriesDescription(scan.files[0]!.file) : '';
            const name = described || scan.name;
            if (!(await this.mayReplace({ ...scan, name }))) return;
            const opened = await this.send(name, scan.files, total);
            this.scene.say(`opened ${opened}`);
        });
    }

    private async mayReplace({ name, files }: ScanFiles): Promise<boolean> {
        const labels = files.length === 1 ? await labelReason(name, files[0]!.file) : undefined;
        return this.ask('scan', name, labels);
    }

    private ask(what: Replacement['what'], name: string, labels?: string): Promise<boolean> {
        const { scan, shared } = this.scene.store.state;
        const others = (shared?.clients.length ?? 1) - 1;
        const present = scan.volume?.name ?? 'the scan';
        return this.hooks.askToReplace({ what, name, present, others, labels });
    }

    /// Loads a saved state of the tissue, for all clients.
    private async loadState(file: File): Promise<void> {
        await this.during(async () => {
            const { link, replay } = this.scene.store.state;
            const { role, features } = link;
            if (replay.isOn) throw new Error(kWatched);
            if (role === 'view')
                throw new Error('only clients that control the session can load a state');
            if (!features.includes('state')) throw new Error('this server loads no states');
            if (!(await this.ask('state', file.name))) return;
            this.tell(`Loading ${file.name}… (Esc cancels)`);
            await this.post('open/state', { name: file.name }, file);
            this.scene.say(`loaded ${file.name}`);
        });
    }

    /// Opens a label map over the present scan, for all clients.
    async openLabels(file: File): Promise<void> {
        await this.during(async () => {
            const { link, replay } = this.scene.store.state;
            const { role, features } = link;
            if (replay.isOn) throw new Error(kWatched);
            if (role === 'view')
                throw new Error('only clients that control the session can open labels');
            if (!features.includes('labels')) throw new Error('this server shows no labels');
            this.tell(`Sending ${file.name}… (Esc cancels)`);
            await this.post('open/labels', { name: file.name }, file);
        });
    }

    /// Sends a scan. @returns its name: the description of a series that was chosen
    private async send(
        name: string,
        files: readonly NamedFile[],
        total: number,
    ): Promise<string> {
        let sent = 0;
        const tell = (more: number): void => {
            const share = total ? Math.floor((100 * (sent + more)) / total) : 100;
            this.tell(
                share < 100
                    ? `Sending ${name}: ${share} % (Esc cancels)`
                    : `Reading ${name}… (Esc cancels)`,
            );
        };
        tell(0);
        const upload = [...crypto.getRandomValues(new Uint8Array(16))]
            .map((byte) => byte.toString(16).padStart(2, '0'))
            .join('');
        if (files.length === 1) {
            const { path, file } = files[0]!;
            const sending = this.post('open', { upload, name: path }, file, tell);
            return this.settle(name, { upload }, sending);
        }
        for (const { path, file } of files) {
            await this.post('open/part', { upload, name: path }, file, tell);
            sent += file.size;
        }
        this.tell(`Reading ${name}… (Esc cancels)`);
        const done = { upload, name };
        return this.settle(name, done, this.post('open/done', done, new Blob()));
    }

    /// Lets the user choose while an upload holds several scans: a series, then an image of it.
    /// @param done  parameters of the request that opens it
    /// @returns the name of the opened scan
    private async settle(
        name: string,
        done: Record<string, string>,
        first: Promise<string | undefined>,
    ): Promise<string> {
        let [request, chosen] = [done, name];
        for (let asked = await first; asked !== undefined; ) {
            const choices = readChoices(asked);
            this.tell(`${name} holds several ${choices.series ? 'series' : 'images'}`);
            const choice = await this.hooks.chooseScan(name, choices);
            if (!choice) {
                await this.post('open/drop', { upload: done.upload! }, new Blob());
                throw new Error(
                    `${name}: no ${choices.series ? 'series' : 'image'} was chosen`,
                );
            }
            request = { ...request, ...choice };
            const series = choices.series?.find(({ uid }) => uid === request.series);
            if (series?.description) {
                chosen = series.description;
                request = { ...request, name: chosen };
            }
            this.tell(`Reading ${chosen}… (Esc cancels)`);
            asked = await this.post('open/done', request, new Blob());
        }
        return chosen;
    }

    /// Posts a file, with progress, which fetch() lacks. @returns the text of a choice, if any
    private post(
        path: string,
        parameters: Record<string, string>,
        body: Blob,
        tell?: (bytes: number) => void,
    ): Promise<string | undefined> {
        const request = new XMLHttpRequest();
        const more = new URLSearchParams(parameters).toString();
        return new Promise((resolve, reject) => {
            if (tell) request.upload.onprogress = (event) => tell(event.loaded);
            request.onload = () =>
                request.status === 200 || request.status === 300
                    ? resolve(request.status === 300 ? request.responseText : undefined)
                    : reject(new Error(request.responseText.trim() || `${request.status}`));
            request.onerror = () =>
                reject(new Error('the file was not sent: the connection is lost'));
            request.onabort = () => reject(new Error('opening was cancelled'));
            request.onloadend = () => {
                this.request = undefined;
            };
            this.request = request;
            request.open('POST', `${path}${this.query}&${more}`);
            request.send(body);
        });
    }

    async save(name: SavedName): Promise<void> {
        await this.during(async () => {
            if (!this.scene.store.state.link.features.includes('save'))
                throw new Error('this server does not save files');
            this.tell(`Saving ${name}…`);
            const response = await fetch(`save/${name}${this.query}`).catch(() => {
                throw new Error(
                    `${name} was not saved: the server does not answer. Save again once the page ` +
                        'is connected',
                );
            });
            if (!response.ok) throw new Error((await response.text()).trim());
            const url = URL.createObjectURL(await response.blob());
            download(url, name);
            setTimeout(() => URL.revokeObjectURL(url), kKeepMs);
            this.scene.say(`saved ${name}`);
        });
    }

    private tell(transfer: string): void {
        this.scene.store.set({ link: { transfer } });
    }

    private async during(work: () => Promise<void>): Promise<void> {
        if (this.scene.store.state.link.transfer) {
            this.scene.warn('another transfer is under way');
            return;
        }
        try {
            await work();
        } catch (error) {
            this.scene.warn((error as Error).message);
        } finally {
            this.tell('');
        }
    }
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bundles the page into dist/: index.html, app.js, app.css and the licences of the packages in
// app.js.
//
//   node build.mjs          small
//   node build.mjs --debug  readable, with a source map

import { build } from 'esbuild';
import { copyFile, mkdir, readFile, rm, stat, writeFile } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';

const here = dirname(fileURLToPath(import.meta.url));
const out = join(here, 'dist');
const debug = process.argv.includes('--debug');

await rm(out, { recursive: true, force: true });
await mkdir(out, { recursive: true });
await build({
    absWorkingDir: here,
    entryPoints: { app: 'src/main.ts' },
    outdir: out,
    bundle: true,
    format: 'esm',
    target: 'es2022',
    loader: { '.glsl': 'text' },
    minify: !debug,
    sourcemap: debug ? 'inline' : false,
    legalComments: 'none', // licenses.txt has them in full
    logLevel: 'warning',
});
await copyFile(join(here, 'src/index.html'), join(out, 'index.html'));
const licences = [];
for (const [name, folder] of [
    ['three.js', 'three'],
    ['uqr', 'uqr'],
]) {
    const text = await readFile(join(here, 'node_modules', folder, 'LICENSE'), 'utf8');
    licences.push(`This page contains ${name}:\n\n${text}`);
}
await writeFile(join(out, 'licenses.txt'), licences.join('\n\n'));

for (const name of ['index.html', 'app.css', 'app.js', 'licenses.txt']) {
    const { size } = await stat(join(out, name));
    const packed = gzipSync(await readFile(join(out, name))).length;
    console.log(`dist/${name.padEnd(14)} ${String(size).padStart(7)} bytes, gzip ${packed}`);
}

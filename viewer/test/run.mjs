// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Bundles the tests and runs them with Node's test runner.
//
//   node test/run.mjs [NAME…]         all tests, or test_NAME.ts; with a browser they need dist/
//   node test/run.mjs --short         those without a browser, and those of the page's main job
//   node test/run.mjs --measure NAME  measure_NAME.ts, which prints numbers and can't fail

import { build } from 'esbuild';
import { readdir, readFile, rm } from 'node:fs/promises';
import { dirname, join } from 'node:path';
import { run } from 'node:test';
import { spec } from 'node:test/reporters';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const measure = process.argv.includes('--measure');
const kind = measure ? 'measure' : 'test';
const out = join(here, 'out', `js-${kind}`);
const wanted = process.argv
    .slice(2)
    .filter((name) => !name.startsWith('--'))
    .map((name) => `${kind}_${name}.ts`);
const all = (await readdir(here))
    .filter((name) => name.startsWith(`${kind}_`))
    .filter((name) => !wanted.length || wanted.includes(name));
const short = ['test_page.ts', 'test_tissue.ts'];
const opensBrowser = async (name) =>
    /'\.\/(browser|one_page)\.ts'/.test(await readFile(join(here, name), 'utf8'));
const files = [];
for (const name of all)
    if (!process.argv.includes('--short') || short.includes(name) || !(await opensBrowser(name)))
        files.push(name);

await rm(out, { recursive: true, force: true });
await build({
    absWorkingDir: here,
    entryPoints: files,
    outdir: out,
    outExtension: { '.js': '.mjs' },
    bundle: true,
    format: 'esm',
    platform: 'node',
    packages: 'external',
    loader: { '.glsl': 'text' },
    logLevel: 'warning',
});
process.env.PLIANT_VIEWER = dirname(here);
if (measure) for (const f of files) await import(join(out, f.replace(/ts$/, 'mjs')));
else
    run({
        files: files.map((f) => join(out, f.replace(/ts$/, 'mjs'))),
        concurrency: 1, // software rendering needs the whole machine
        timeout: 600_000,
    })
        .on('test:fail', () => {
            process.exitCode = 1;
        })
        .compose(new spec())
        .pipe(process.stdout);

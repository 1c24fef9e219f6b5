// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// The rest field in the page: requested while the style needs it, patched by boxes, equal in the
// mirror and on the graphics processor, and consistent with the overlay.

import assert from 'node:assert/strict';
import { test } from 'node:test';
import type { ConsoleMessage, Page } from 'playwright-core';
import { floatOfHalf, halfOfFloat } from '../src/maths/half.ts';
import type { Vec3 } from '../src/maths/vec.ts';
import restShader from '../src/shaders/rest.glsl';
import type { Session } from '../src/tools/session.ts';
import { kRestStep, RestField } from '../src/views/rest_field.ts';
import { loaded, pixels, visit } from './browser.ts';
import { randomGrid } from './fields.ts';
import { browser, page, served, useOnePage } from './one_page.ts';
import { between, whole } from './random.ts';

useOnePage({ size: 64 });

test('the field holds random patches, and is linear between nodes', () => {
    for (let round = 0; round < 10; ++round) {
        const grid = randomGrid(2, 40);
        const field = new RestField(grid);
        const counts = field.counts;
        counts.forEach((n, a) => {
            assert.ok(kRestStep * (n - 1) >= grid.size[a]! - 1);
            assert.ok(kRestStep * (n - 2) < grid.size[a]! - 1);
        });
        const truth = new Map<string, number[]>();
        for (let n = 0; n < 10; ++n) {
            const begin = counts.map((s) => whole(0, s - 1));
            const end = counts.map((s, a) => whole(begin[a]! + 1, s));
            const values: number[] = [];
            for (let k = begin[2]!; k < end[2]!; ++k)
                for (let j = begin[1]!; j < end[1]!; ++j)
                    for (let i = begin[0]!; i < end[0]!; ++i) {
                        const node = [0, 1, 2, 3].map(() => halfOfFloat(between(-9, 9)));
                        values.push(...node);
                        truth.set(
                            `${i} ${j} ${k}`,
                            node.map((half) => floatOfHalf[half]!),
                        );
                    }
            const box = { begin: begin as unknown as Vec3, end: end as unknown as Vec3 };
            field.patch(box, Uint16Array.from(values));
        }
        const nodeAt = (at: number[]): number[] => truth.get(at.join(' ')) ?? [0, 0, 0, 0];
        for (let n = 0; n < 50; ++n) {
            const node = counts.map((s) => whole(0, s - 1));
            const voxel = node.map((x) => kRestStep * x) as unknown as Vec3;
            const { offset, raw } = field.at(voxel);
            assert.deepEqual([...offset, raw], nodeAt(node));
            if (node[0]! + 1 === counts[0]) continue;
            const t = between(0, 1);
            const mixed = field.at([voxel[0] + kRestStep * t, voxel[1], voxel[2]]);
            const next = nodeAt([node[0]! + 1, node[1]!, node[2]!]);
            const own = nodeAt(node);
            [...mixed.offset, mixed.raw].forEach((x, c) =>
                assert.ok(Math.abs(x - ((1 - t) * own[c]! + t * next[c]!)) < 1e-4),
            );
        }
        assert.deepEqual(field.at([-7, -7, -7]), field.at([0, 0, 0]));
        const beyond = counts as unknown as Vec3;
        assert.throws(
            () => field.patch({ begin: [0, 0, 0], end: [beyond[0] + 1, 1, 1] }, new Uint16Array(4)),
            /rest: box/,
        );
    }
});

const style = (visited: Page, wanted: 'real' | 'plain'): Promise<void> =>
    visited.evaluate(async (s) => {
        const session = (window as never as { pliant: Session }).pliant;
        session.store.set({ look: { style: s } });
        await session.compare(); // its answer comes after all boxes
    }, wanted);

async function act(visited: Page, command: object): Promise<void> {
    await visited.evaluate(async (c) => {
        const session = (window as never as { pliant: Session }).pliant;
        await session.ask(c as never);
        await session.compare();
    }, command);
}

const middle = (visited: Page): Promise<Vec3> =>
    visited.evaluate(() => {
        const {
            scan: { volume },
            view: { camera },
        } = (window as never as { pliant: Session }).pliant.store.state;
        return volume!.landmarks[0]?.point_mm ?? camera.eye;
    });

/// Nodes of the mirror, and the largest difference of the texture to it.
const fieldOf = (visited: Page): Promise<{ halves: number[]; apart: number } | null> =>
    visited.evaluate(async () => {
        const { stage } = (window as never as { pliant: Session }).pliant;
        const { rest, renderer } = stage;
        if (!rest) return null;
        stage.invalidate();
        const drawn = stage.framesDrawn;
        // One frame is enough if the last one took so long that the next is still.
        while (stage.framesDrawn === drawn || !stage.isStill)
            await new Promise((done) => requestAnimationFrame(done));
        const gl = renderer.getContext() as WebGL2RenderingContext;
        gl.getExtension('EXT_color_buffer_float');
        rest.upload(renderer);
        const { __webglTexture } = renderer.properties.get(rest.texture) as {
            __webglTexture?: WebGLTexture;
        };
        // A shader that doesn't use the field has no texture yet.
        if (!__webglTexture) renderer.initTexture(rest.texture);
        const handle = (renderer.properties.get(rest.texture) as { __webglTexture: WebGLTexture })
            .__webglTexture;
        const [nx, ny, nz] = rest.counts;
        const frame = gl.createFramebuffer();
        gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
        const layer = new Float32Array(4 * nx * ny);
        const valueOf = (half: number): number => {
            const exponent = (half >> 10) & 31;
            const size = exponent
                ? (1 + (half & 1023) / 1024) * 2 ** (exponent - 15)
                : (half & 1023) * 2 ** -24;
            return half & 0x8000 ? -size : size;
        };
        let apart = 0;
        for (let k = 0; k < nz; ++k) {
            gl.framebufferTextureLayer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, handle, 0, k);
            gl.readPixels(0, 0, nx, ny, gl.RGBA, gl.FLOAT, layer);
            layer.forEach((x, n) => {
                const held = valueOf(rest.halves[4 * nx * ny * k + n]!);
                apart = Math.max(apart, Math.abs(x - held));
            });
        }
        gl.deleteFramebuffer(frame);
        renderer.resetState();
        renderer.setScissorTest(true);
        return { halves: [...rest.halves], apart };
    });

/// Checks that each node's offset is as long as the overlay's displacement of its voxel.
async function compareWithOverlay(visited: Page): Promise<{ moved: number; raw: number }> {
    return visited.evaluate(async () => {
        const session = (window as never as { pliant: Session }).pliant;
        session.store.set({ overlay: { kind: 'displacement' } });
        await session.compare();
        const { rest, overlay } = session.stage;
        const [nx, ny, nz] = rest!.counts;
        const { size } = session.store.state.scan.volume!;
        let moved = 0;
        let raw = 0;
        for (let k = 0; k < nz; ++k)
            for (let j = 0; j < ny; ++j)
                for (let i = 0; i < nx; ++i) {
                    const voxel = [i, j, k].map((n, a) => Math.min(4 * n, size[a]! - 1));
                    const sample = rest!.at([4 * i, 4 * j, 4 * k]);
                    const far = Math.hypot(...sample.offset);
                    const told = overlay!.valueAt(voxel as never)!;
                    if (Math.abs(far - told) > 2e-3 * Math.max(told, 1))
                        throw new Error(`node ${i} ${j} ${k}: ${far} mm, overlay ${told} mm`);
                    if (far > 0.1) ++moved;
                    if (sample.raw > 0) ++raw;
                }
        session.store.set({ overlay: { kind: 'none' } });
        return { moved, raw };
    });
}

/// Tests whether the field has had raw tissue, which the shader then knows.
const knowsRaw = (visited: Page): Promise<boolean | undefined> =>
    visited.evaluate(() => (window as never as { pliant: Session }).pliant.stage.rest?.hasRaw);

test('it comes with the style, follows deformations and agrees with the overlay', async () => {
    await style(page, 'plain');
    assert.equal(await fieldOf(page), null);
    const point = await middle(page);
    await act(page, { do: 'push', point, push: [0, 0, 4], radius: 8 });
    await style(page, 'real');
    const first = (await fieldOf(page))!;
    assert.equal(first.apart, 0);
    const pushed = await compareWithOverlay(page);
    assert.ok(pushed.moved > 20 && pushed.raw === 0, JSON.stringify(pushed));
    assert.equal(await knowsRaw(page), false);
    // Patches of an existing texture.
    await act(page, { do: 'push', point, push: [3, 0, 0], radius: 8 });
    await act(page, { do: 'carve', from: point, to: point, radius: 10 });
    const second = (await fieldOf(page))!;
    assert.equal(second.apart, 0);
    assert.notDeepEqual(second.halves, first.halves);
    assert.ok((await compareWithOverlay(page)).raw > 5);
    assert.equal(await knowsRaw(page), true);
    for (let n = 0; n < 3; ++n) await act(page, { do: 'undo' });
    const third = (await fieldOf(page))!;
    assert.equal(third.apart, 0);
    assert.ok(third.halves.every((half) => half === 0));
    await act(page, { do: 'redo' });
    assert.deepEqual((await fieldOf(page))!.halves, first.halves);
    if (served.mock) assert.ok(served.mock.restsSeen > 0);
});

test('shaders sample the field like the page, between nodes and beyond them', async () => {
    const points: Vec3[] = Array.from({ length: 60 }, () => [
        between(-4, 70),
        between(-4, 70),
        between(-4, 70),
    ]);
    const point = await middle(page);
    const [read, held] = await page.evaluate(
        async ({ source, at, near }) => {
            const { stage, volume } = (window as never as { pliant: Session }).pliant;
            const { rest, renderer } = stage;
            const { origin, spacing } = volume!.grid;
            // Most of the points are in moved tissue.
            const spots = at.map((p, n) =>
                n % 4
                    ? p.map((x, a) => (near[a]! - origin[a]!) / spacing[a]! + (x - 33) / 4)
                    : [...p],
            ) as [number, number, number][];
            const gl = renderer.getContext() as WebGL2RenderingContext;
            renderer.initTexture(rest!.texture);
            const { __webglTexture } = renderer.properties.get(rest!.texture) as {
                __webglTexture: WebGLTexture;
            };
            const program = gl.createProgram();
            const add = (type: number, text: string): void => {
                const shader = gl.createShader(type)!;
                gl.shaderSource(shader, `#version 300 es\nprecision highp float;\n${text}`);
                gl.compileShader(shader);
                gl.attachShader(program, shader);
            };
            add(
                gl.VERTEX_SHADER,
                'void main() { gl_Position = vec4(0, 0, 0, 1); gl_PointSize = 1.0; }',
            );
            add(
                gl.FRAGMENT_SHADER,
                `precision highp sampler3D;\n${source}\nuniform vec3 p; out vec4 value;
                void main() { value = restAt(p); }`,
            );
            gl.linkProgram(program);
            gl.useProgram(program);
            gl.getExtension('EXT_color_buffer_float');
            const target = gl.createTexture();
            gl.activeTexture(gl.TEXTURE0);
            gl.bindTexture(gl.TEXTURE_2D, target);
            gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, 1, 1);
            gl.bindTexture(gl.TEXTURE_3D, __webglTexture);
            const frame = gl.createFramebuffer();
            gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
            gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target, 0);
            gl.bindVertexArray(null);
            gl.disable(gl.SCISSOR_TEST);
            gl.disable(gl.DEPTH_TEST);
            gl.disable(gl.BLEND);
            gl.viewport(0, 0, 1, 1);
            const place = (name: string): WebGLUniformLocation | null =>
                gl.getUniformLocation(program, name);
            gl.uniform1i(place('restField'), 0);
            gl.uniform1i(place('restOn'), 1);
            gl.uniform3fv(place('restCount'), rest!.counts);
            const values = spots.map((p) => {
                gl.uniform3fv(place('p'), p);
                gl.drawArrays(gl.POINTS, 0, 1);
                const value = new Float32Array(4);
                gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, value);
                return [...value];
            });
            gl.deleteFramebuffer(frame);
            gl.deleteTexture(target);
            gl.deleteProgram(program);
            renderer.resetState();
            renderer.setScissorTest(true);
            const own = spots.map((p) => {
                const { offset, raw } = rest!.at(p);
                return [...offset, raw];
            });
            return [values, own] as const;
        },
        { source: restShader, at: points, near: point },
    );
    let moved = 0;
    held.forEach((own, n) => {
        // Weights of a texture unit may have eight bits only.
        const size = Math.max(...own.map(Math.abs));
        own.forEach((x, c) => assert.ok(Math.abs(x - read[n]![c]!) < 0.02, `${own} ${read[n]}`));
        if (size > 0.3) ++moved;
    });
    assert.ok(moved > 10, `${moved} points`);
});

test('a later client that only views has the same field', async () => {
    const own = (await fieldOf(page))!;
    const second = await visit(browser, served.link, '&notour&role=view');
    await style(second.page, 'real');
    assert.deepEqual((await fieldOf(second.page))!.halves, own.halves);
    assert.deepEqual(second.errors, []);
    await second.page.context().close();
});

test('it survives a lost context and a lost connection, and ends with the style', async () => {
    const own = (await fieldOf(page))!;
    const drawn = await pixels(page, 'endoscope');
    const complaints: string[] = [];
    const listen = (message: ConsoleMessage): void => {
        if (message.text().includes('INVALID')) complaints.push(message.text());
    };
    page.on('console', listen);
    await page.evaluate(async () => {
        const { stage } = (window as never as { pliant: Session }).pliant;
        const gl = stage.renderer.getContext() as WebGL2RenderingContext;
        const lose = gl.getExtension('WEBGL_lose_context')!;
        const back = new Promise((done) =>
            gl.canvas.addEventListener('webglcontextrestored', done, { once: true }),
        );
        lose.loseContext();
        await new Promise((done) => setTimeout(done, 100));
        lose.restoreContext();
        await back;
    });
    const restored = (await fieldOf(page))!;
    assert.equal(restored.apart, 0);
    assert.deepEqual(restored.halves, own.halves);
    assert.deepEqual(await pixels(page, 'endoscope'), drawn);
    page.off('console', listen);
    assert.deepEqual(complaints, [], 'objects of the lost context were used');
    if (served.mock) {
        served.mock.breakLines();
        await page.waitForFunction(
            () =>
                (window as never as { pliant: Session }).pliant.store.state.link.status !== 'open',
        );
        await loaded(page);
        await style(page, 'real');
        assert.deepEqual((await fieldOf(page))!.halves, own.halves);
    }
    await style(page, 'plain');
    assert.equal(await fieldOf(page), null);
});

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Fingers on the page, as real touch events of the DevTools protocol.

import type { CDPSession, Page } from 'playwright-core';

export type Spot = readonly [number, number];

export class Touch {
    private constructor(private readonly devtools: CDPSession) {}

    static async on(page: Page): Promise<Touch> {
        return new Touch(await page.context().newCDPSession(page));
    }

    async press(...spots: Spot[]): Promise<void> {
        await this.send('touchStart', spots);
    }
    async move(...spots: Spot[]): Promise<void> {
        await this.send('touchMove', spots);
    }
    async lift(): Promise<void> {
        await this.send('touchEnd', []);
    }

    async tap(spot: Spot): Promise<void> {
        await this.press(spot);
        await this.lift();
    }

    /// Moves fingers from their spots to others in steps, and lifts them.
    async drag(from: readonly Spot[], to: readonly Spot[], steps = 10): Promise<void> {
        await this.press(...from);
        for (let n = 1; n <= steps; ++n)
            await this.move(
                ...from.map(
                    ([x, y], i): Spot => [
                        x + ((to[i]![0] - x) * n) / steps,
                        y + ((to[i]![1] - y) * n) / steps,
                    ],
                ),
            );
        await this.lift();
    }

    private async send(type: 'touchStart' | 'touchMove' | 'touchEnd', spots: readonly Spot[]) {
        await this.devtools.send('Input.dispatchTouchEvent', {
            type,
            touchPoints: spots.map(([x, y], id) => ({ x, y, id })),
        });
    }
}

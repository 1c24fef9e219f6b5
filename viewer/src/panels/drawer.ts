// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Panels as a drawer, where the window has no room for them beside the views.

import { button } from './dom.ts';

export class Drawer {
    /// Shown in small windows only.
    readonly toggle = button('Settings', () => this.open(!this.isOpen), 'shows the panels');

    constructor(private readonly panels: HTMLElement) {
        this.toggle.id = 'settings';
        panels.id ||= 'panels';
        this.toggle.setAttribute('aria-controls', panels.id);
        this.open(false);
    }

    get isOpen(): boolean {
        return this.panels.classList.contains('open');
    }

    open(is: boolean): void {
        this.panels.classList.toggle('open', is);
        this.toggle.setAttribute('aria-expanded', String(is));
        this.toggle.setAttribute('aria-pressed', String(is));
    }
}

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Starts the page: reads the link's token, connects, puts the parts together and draws.

import './style.css';
import { h } from './panels/dom.ts';
import { helpDialog } from './panels/help.ts';
import { Legend } from './panels/legend.ts';
import { Overlay } from './panels/overlay.ts';
import { panels } from './panels/panels.ts';
import { chooseSeries } from './panels/series_dialog.ts';
import { StatusBar } from './panels/status_bar.ts';
import { toolbar } from './panels/toolbar.ts';
import { Tour } from './panels/tour.ts';
import { keepView } from './state/kept_view.ts';
import { initialState, kViews, Store } from './state/store.ts';
import { Actions } from './tools/actions.ts';
import { CatheterHand } from './tools/catheter_hand.ts';
import { Files } from './tools/files.ts';
import { Keymap } from './tools/keymap.ts';
import { Pointer } from './tools/pointer.ts';
import { Session } from './tools/session.ts';
import { Stage } from './views/stage.ts';

const kTourKey = 'pliant.tour';
const kThemeKey = 'pliant.theme';

function start(): void {
    const link = new URLSearchParams(location.hash.slice(1));
    const token = link.get('token') ?? '';
    const role = link.get('role') === 'view' ? 'view' : 'control';
    const url = new URL(`ws?token=${encodeURIComponent(token)}`, location.href);
    url.protocol = url.protocol.replace('http', 'ws');
    url.hash = '';
    const store = new Store(initialState());
    const name = link.get('name') ?? '';
    const session = new Session(store, url.href, { role, name }, sessionStorage);
    const actions = new Actions(session);
    const overlay = new Overlay(session);
    const held = new Set<string>(); // keys
    const hand = new CatheterHand(session, held, () => navigator.getGamepads());
    session.drive = (seconds, now) => hand.tick(seconds, now);
    const canvas = h('canvas', { 'aria-hidden': 'true' });
    const settings = panels(session, actions, hand);
    const files = new Files(session, `?token=${encodeURIComponent(token)}`, {
        openPath: (file) => actions.openFile(file),
        chooseSeries,
    });
    const status = new StatusBar(session);
    const legend = new Legend(session);
    const tour = new Tour(session, () => localStorage.setItem(kTourKey, 'seen'));
    const help = helpDialog(() => tour.start());
    const notice = h('div', { class: 'notice', role: 'alert', hidden: true });
    const showHelp = (): void => {
        if (!help.open) help.showModal();
    };

    document.body.append(
        toolbar(session, actions, files, { help: showHelp }),
        h(
            'main',
            {},
            h(
                'div',
                { class: 'views' },
                canvas,
                overlay.element,
                legend.element,
                notice,
                tour.element,
            ),
            settings,
        ),
        status.element,
        help,
    );

    let contextLost = false;
    const tell = (): void => {
        const { state } = store;
        const text = contextLost
            ? 'The graphics context is lost. It comes back by itself; if not, reload the page.'
            : state.link === 'ended'
              ? `${state.linkText}. Reload the page to connect again.`
              : state.link === 'lost'
                ? `${state.linkText}. Connecting again…`
                : !state.volume
                  ? 'Connecting…'
                  : state.transfer
                    ? state.transfer
                    : state.loaded < 1
                      ? `Loading ${state.volume.name}: ${Math.round(100 * state.loaded)} %`
                      : '';
        notice.hidden = !text;
        notice.textContent = text;
    };
    try {
        session.stage = new Stage(
            canvas,
            store,
            (view) => overlay.views[view].getBoundingClientRect(),
            (lost) => {
                contextLost = lost;
                tell();
            },
        );
    } catch (error) {
        notice.hidden = false;
        notice.textContent = `This page needs WebGL 2: ${(error as Error).message}`;
        return;
    }
    session.stage.vesselOf = () => session.vessel;
    session.stage.onTooSlow = () => {
        if (store.state.style === 'plain' || store.state.styleChosen) return;
        store.set({ style: 'plain' });
        session.say('the plain look: the real one takes too long to draw here');
    };
    store.watch(['link', 'linkText', 'volume', 'loaded', 'transfer'], tell);
    store.watch(['theme'], ({ theme }) => {
        document.documentElement.dataset.theme = theme;
        if (theme !== 'system') localStorage.setItem(kThemeKey, theme);
        else localStorage.removeItem(kThemeKey);
    });
    const theme = localStorage.getItem(kThemeKey);
    if (theme === 'light' || theme === 'dark') store.set({ theme });

    const keymap = new Keymap(session, actions, held, {
        help: showHelp,
        cancel: () => {
            pointer.cancel();
            actions.way.cancel();
            files.cancel();
            session.stopMovie();
            tour.stop();
        },
        nextView: () => {
            const shown = kViews.filter((view) => !overlay.views[view].hidden);
            const at = shown.indexOf(store.state.active);
            overlay.views[shown[(at + 1) % shown.length]!].focus();
        },
        open: () => {
            if (store.state.role === 'control') files.choose();
        },
        save: () => void files.save('volume.nrrd'),
        stop: () => hand.stop(),
    });
    const pointer = new Pointer(session, actions, overlay.views, keymap.held);
    window.addEventListener('pagehide', () => keepView(store, sessionStorage));
    // Files may be dropped anywhere.
    document.addEventListener('dragover', (e) => e.preventDefault());
    document.addEventListener('drop', (e) => {
        e.preventDefault();
        if (e.dataTransfer) void files.drop(e.dataTransfer);
    });
    session.onWelcome = () => {
        if (
            !localStorage.getItem(kTourKey) &&
            !link.has('notour') &&
            store.state.role === 'control'
        )
            tour.start();
        session.onWelcome = () => {};
    };
    session.connection.open();

    let last = performance.now();
    const frame = (now: number): void => {
        session.tick((now - last) / 1000, now);
        last = now;
        overlay.refresh();
        legend.refresh();
        status.refresh(now);
        requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
    // For tests, and for the curious.
    (window as unknown as { pliant: Session }).pliant = session;
}

start();

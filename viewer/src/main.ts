// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Starts the page: reads the link's token, creates all parts, connects, and draws.

import './style.css';
import './hand.css';
import './windows.css';
import './marks.css';
import './company.css';
import { Connection } from './net/connection.ts';
import { h } from './panels/dom.ts';
import { Drawer } from './panels/drawer.ts';
import { helpDialog } from './panels/help.ts';
import { Legend } from './panels/legend.ts';
import { followLine } from './panels/follow_line.ts';
import { Overlay } from './panels/overlay.ts';
import { keptName } from './panels/panel_session.ts';
import { panels } from './panels/panels.ts';
import { askToReplace } from './panels/replace_dialog.ts';
import { chooseScan } from './panels/series_dialog.ts';
import { paintMarks } from './panels/snapshot.ts';
import { MessageLine, StatusBar } from './panels/status_bar.ts';
import { stick } from './panels/stick.ts';
import { Timeline } from './panels/timeline.ts';
import { toolbar } from './panels/toolbar.ts';
import { Tour } from './panels/tour.ts';
import { keepView } from './state/kept_view.ts';
import { initialState, kViews, type State } from './state/state.ts';
import { Store } from './state/store.ts';
import { Actions } from './tools/actions.ts';
import { Files } from './tools/files.ts';
import { Keymap } from './tools/keymap.ts';
import { Pointer } from './tools/pointer.ts';
import { Session } from './tools/session.ts';
import { Stage } from './views/stage.ts';

const kTourKey = 'pliant.tour';
const kThemeKey = 'pliant.theme';

const capital = (text: string): string => text.charAt(0).toUpperCase() + text.slice(1);

/// Text over the pictures: connection and transfers; empty: none.
function noticeOf({ link, scan }: State, contextLost: boolean): string {
    if (contextLost)
        return 'The graphics context is lost. It comes back by itself; if not, reload the page.';
    if (link.status === 'refused')
        return `${capital(link.text)}. Open the link that pliant serve printed last.`;
    if (link.silent)
        return (
            'The server does not answer: it is busy, or it hangs. ' +
            'What you do waits until it answers.'
        );
    if (link.status === 'ended') return `${capital(link.text)}. Reload the page to connect again.`;
    if (link.status === 'lost') return `${capital(link.text)}. Connecting again…`;
    if (!scan.volume) return 'Connecting…';
    if (link.transfer) return link.transfer;
    if (scan.loaded < 1) return `Loading ${scan.volume.name}: ${Math.round(100 * scan.loaded)} %`;
    return '';
}

function keepTheme(store: Store): void {
    store.watch(
        ({ display: { theme } }) => [theme],
        (theme) => {
            document.documentElement.dataset.theme = theme;
            if (theme !== 'system') localStorage.setItem(kThemeKey, theme);
            else localStorage.removeItem(kThemeKey);
        },
    );
    const theme = localStorage.getItem(kThemeKey);
    if (theme === 'light' || theme === 'dark') store.set({ display: { theme } });
}

function start(): void {
    const link = new URLSearchParams(location.hash.slice(1));
    const token = link.get('token') ?? '';
    const role = link.get('role') === 'view' ? 'view' : 'control';
    const url = new URL(`ws?token=${encodeURIComponent(token)}`, location.href);
    url.protocol = url.protocol.replace('http', 'ws');
    url.hash = '';
    const name = keptName() || (link.get('name') ?? '');

    const store = new Store(initialState());
    const message = new MessageLine();
    const notice = h('div', { class: 'notice', role: 'alert', hidden: true });
    let contextLost = false;
    const tell = (): void => {
        const text = noticeOf(store.state, contextLost);
        notice.hidden = !text;
        if (notice.textContent !== text) notice.textContent = text;
    };
    const canvas = h('canvas', { 'aria-hidden': 'true' });
    const views = h('div', { class: 'views' }, canvas, notice);
    const main = h('main', {}, views);
    document.body.append(main);
    const makeStage = (): Stage =>
        new Stage(canvas, store, {
            rectOf: (view) => overlay.views[view].getBoundingClientRect(),
            onContext: (lost) => {
                contextLost = lost;
                tell();
            },
            onTooSlow: () => {
                const { style, styleChosen } = store.state.look;
                if (store.state.view.outside) return; // drawn in neither style
                if (style === 'plain' || styleChosen) return;
                store.set({ look: { style: 'plain' } });
                message.say('switched to the plain look: the real one is too slow here');
            },
        });
    let stage: Stage;
    try {
        stage = makeStage();
    } catch (error) {
        notice.hidden = false;
        notice.textContent = `This page needs WebGL 2: ${(error as Error).message}`;
        return;
    }

    const held = new Set<string>(); // codes of keys
    let greeted = false;
    const session = new Session({
        store,
        stage,
        connection: new Connection(url.href, { role, name }, sessionStorage),
        memory: sessionStorage,
        lasting: localStorage,
        held,
        say: (text, isWarning) => message.say(text, isWarning),
        onWelcome: () => {
            const seen = greeted || localStorage.getItem(kTourKey) || link.has('notour');
            greeted = true;
            if (!seen && store.state.link.role === 'control') tour.start();
        },
    });
    const actions = new Actions(session);
    const files = new Files(session, `?token=${encodeURIComponent(token)}`, {
        openPath: (file) => actions.openFile(file),
        chooseScan,
        askToReplace,
    });
    session.labelMap.send = (file) => files.openLabels(file);
    const overlay = new Overlay(session, (view) => actions.toggleMaximised(view));
    const legend = new Legend(session);
    const status = new StatusBar(session, message);
    const tour = new Tour(session, () => localStorage.setItem(kTourKey, 'seen'));
    const help = helpDialog(() => tour.start());
    const showHelp = (): void => {
        if (!help.open) help.showModal();
    };
    const landing = h(
        'div',
        { class: 'landing', 'aria-hidden': 'true' },
        'Drop a scan or a path here',
    );
    views.replaceChildren(
        canvas,
        overlay.element,
        legend.element,
        notice,
        tour.element,
        landing,
    );
    const settings = panels(session, actions);
    const drawer = new Drawer(settings);
    main.append(new Timeline(session).element, settings);
    main.before(toolbar(session, actions, files, { help: showHelp, settings: drawer.toggle }));
    overlay.views.endoscope.append(stick(session), followLine(session));
    document.body.append(status.element, help);
    actions.paintMarks = (context, ratio) =>
        paintMarks(
            kViews.map((view) => overlay.views[view]),
            canvas.getBoundingClientRect(),
            context,
            ratio,
        );
    store.watch(({ link: line, scan }) => [line, scan], tell);
    keepTheme(store);

    new Keymap(session, actions, held, {
        help: showHelp,
        cancel: () => {
            pointer.cancel();
            session.path.cancel();
            session.marks.cancel();
            files.cancel();
            session.movie.stop();
            tour.stop();
            if (drawer.isOpen) drawer.open(false);
            else actions.maximise(null);
        },
        nextView: () => {
            const shown = kViews.filter((view) => !overlay.views[view].hidden);
            const at = shown.indexOf(store.state.pointer.active);
            overlay.views[shown[(at + 1) % shown.length]!].focus();
        },
        open: () => {
            if (store.state.link.role === 'control') files.choose();
        },
        save: () => void files.save('volume.nrrd'),
        stop: () => session.catheter.stop(),
    });
    const pointer = new Pointer(session, actions, overlay.views, held);
    window.addEventListener('pagehide', () => keepView(store, sessionStorage));
    // Files may be dropped anywhere.
    const hover = (on: boolean): void => void document.body.classList.toggle('dropping', on);
    document.addEventListener('dragover', (e) => {
        e.preventDefault();
        hover(true);
    });
    document.addEventListener('dragleave', (e) => hover(e.relatedTarget !== null));
    document.addEventListener('drop', (e) => {
        e.preventDefault();
        hover(false);
        if (e.dataTransfer) void files.drop(e.dataTransfer);
    });
    session.open();

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
    // For tests, and for the browser's console.
    (window as unknown as { pliant: Session }).pliant = session;
}

start();

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Other clients of the scene, and a recorded session that is watched together.

import type { ReplayMark } from '../net/company.ts';
import type { SharedState } from '../net/protocol.ts';

export interface Company {
    readonly leader: number; ///< client whose camera is followed; 0: none
    readonly names: boolean; ///< shown at the tools of others
}

/// A recorded session.
export interface Replay {
    readonly isOn: boolean;
    readonly controls: boolean; ///< this client may set the time
    readonly at: number; ///< [ms]
    readonly length: number; ///< [ms]
    readonly speed: number;
    readonly playing: boolean;
    readonly seeking: boolean; ///< the scene is not that of the time yet
    readonly failure: string; ///< empty: none
    readonly marks: readonly ReplayMark[]; ///< in the order of time
}

export const initialCompany: Company = { leader: 0, names: true };

export const initialReplay: Replay = {
    isOn: false,
    controls: false,
    at: 0,
    length: 0,
    speed: 1,
    playing: false,
    seeking: false,
    failure: '',
    marks: [],
};

/// Reason why tools are disabled.
export const kWatched = 'a recorded session is watched, and can’t be changed';

/// Name of a client; the clients of a recorded session have none.
export const nameOfClient = (shared: SharedState | null, client: number): string =>
    shared?.clients.find((c) => c.client === client)?.name || `visitor ${client}`;

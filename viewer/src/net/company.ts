// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Messages about cameras that are followed, and about a recorded session that is watched
// (docs/developers/protocol.md).

import type { Vec3 } from '../maths/vec.ts';

/// The own camera, told to the server. Without fields: there is none.
export interface OwnCamera {
    do: 'camera';
    eye?: Vec3;
    look?: Vec3;
    up?: Vec3;
}

/// Camera of the client that is followed. Without eye: it has none any more.
export interface CameraNews {
    t: 'camera';
    client: number;
    eye?: Vec3;
    look?: Vec3;
    up?: Vec3;
}

/// Time of a session that is watched.
export interface ReplayNews {
    t: 'replay';
    at_ms: number;
    length_ms: number;
    speed: number;
    playing: boolean;
    seeking: boolean; ///< on the way to at_ms
    failure?: string; ///< of a record; ends the session
}

/// A command in the session, or the first of a stroke.
export interface ReplayMark {
    at_ms: number;
    client: number;
    do: string;
}

export type CompanyNews = CameraNews | ReplayNews | { t: 'replay_marks'; marks: ReplayMark[] };

export type CompanyCommand =
    | { do: 'follow'; client: number }
    | { do: 'replay'; playing?: boolean; speed?: number; at_ms?: number };

// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

declare module '*.glsl' {
    const text: string;
    export default text;
}

declare module '*.css';

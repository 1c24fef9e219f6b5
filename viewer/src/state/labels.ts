// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Labels beside the scan: names, colours, and how each is shown. Choices belong to a label's value
// in the file, so that they outlive a reload.

import { distinctColour } from '../maths/colour_map.ts';
import type { Vec3 } from '../maths/vec.ts';
import type { LabelsNews } from '../net/protocol.ts';

export const kMaxLabels = 2047;

export interface Label {
    readonly number: number; ///< in the list, from 1: the value of the label field
    readonly value: number; ///< in the file
    readonly name: string; ///< in the file; empty: none
    readonly colour: Vec3; ///< sRGB, 0…1
    readonly voxels: number;
    readonly centre: Vec3; ///< at rest [mm, LPS]
    readonly body: number; ///< that carries it, from 1; 0: none
    readonly isShown: boolean; ///< unless chosen otherwise
}

export interface LabelLook {
    readonly shown: boolean;
    readonly risk: boolean; ///< touching it warns
    readonly target: boolean; ///< seen behind walls
}

export interface Labels {
    readonly file: string; ///< name; empty: there is no label map
    readonly list: readonly Label[];
    readonly looks: Readonly<Record<number, LabelLook>>; ///< chosen ones, by value
    readonly names: Readonly<Record<number, string>>; ///< of a table, by value
    readonly opacity: number;
    readonly outline: boolean; ///< in the sections
    readonly coloured: boolean; ///< whether the scene's own map of bodies is drawn
    readonly contact: boolean; ///< of bodies, in two shades that move with the tissue
    readonly version: number; ///< grows with each change of the label field
    readonly touched: readonly string[]; ///< names of structures at risk that a tool touches
}

export interface State {
    readonly labels: Labels;
}

const kBodies = 'bodies'; // name of that map

export const isOfBodies = ({ file }: Labels): boolean => file === kBodies;

export const lookOf = (labels: Labels, { value, isShown }: Label): LabelLook =>
    labels.looks[value] ?? {
        shown: isShown && (labels.coloured || !isOfBodies(labels)),
        risk: false,
        target: false,
    };

/// Tests whether some labels are of different bodies, which may touch each other.
export const haveBodies = ({ list }: Labels): boolean =>
    new Set(list.map(({ body }) => body).filter((body) => body > 0)).size > 1;

export const nameOf = ({ names }: Labels, { value, name }: Label): string =>
    names[value] || name || `label ${value}`;

export const initialLabels: Labels = {
    file: '',
    list: [],
    looks: {},
    names: {},
    opacity: 0.4,
    outline: true,
    coloured: false,
    contact: false,
    version: 0,
    touched: [],
};

/// Labels of the server's list; those without a colour get distinct ones by their value.
export const labelsOf = ({ labels }: LabelsNews): Label[] =>
    labels.map(({ value, name, colour, voxels, centre_mm, body = 0, shown = true }, n) => ({
        number: n + 1,
        value,
        name,
        colour: colour ?? distinctColour(value),
        voxels,
        centre: centre_mm,
        body,
        isShown: shown,
    }));

/// Reads names from a table: lines of 3D Slicer's colour tables (.ctbl: value name red green blue
/// alpha, blanks in names are underscores), or of .csv (value,name). Other lines are skipped.
/// @throws an Error if there is none
export function readNames(text: string, file: string): Record<number, string> {
    const names: Record<number, string> = {};
    for (const line of text.replace(/^\uFEFF/, '').split(/\r?\n/)) {
        const cells = line.includes(',')
            ? line.split(',').map((cell) => cell.trim().replace(/^"(.*)"$/, '$1'))
            : line.trim().split(/\s+/);
        const value = Number(cells[0]);
        if (!cells[0] || !Number.isInteger(value) || !cells[1]) continue;
        names[value] = cells[1].replaceAll('_', ' ').slice(0, 80);
    }
    if (!Object.keys(names).length)
        throw new Error(`${file}: expected lines of a label's value and its name, found none`);
    return names;
}

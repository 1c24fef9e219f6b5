// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Settings that messages carry. Made from the library's tables by `./dev settings`; a
// test compares.

export interface SettingRow {
    unit: string;
    low?: number;
    high?: number;
    text: string;
}

export interface Materials {
    law: 'draeger';
    range: number[];
    range_percent: number[];
    offset: number;
    factor: number[];
    bone_threshold_hu: number; ///< [HU]
    smallest_bone_mm3: number; ///< [mm³]
    max_movement_mm: number; ///< [mm]
    yield: number;
    limits: 'box' | 'rounded';
    air_enabled: boolean;
    air_threshold_hu: number; ///< [HU]
    air_compress: number;
    air_stretch: number;
    air_shear: number;
}

export const materialRows: Record<keyof Materials, SettingRow> = {
    law: {
        unit: '',
        text: 'how limits follow from the voxel value',
    },
    range: {
        unit: '',
        text: 'values of the softest and of the hardest element',
    },
    range_percent: {
        unit: '',
        low: 0,
        high: 100,
        text: 'instead of range: percentiles of the scan\'s values',
    },
    offset: {
        unit: '',
        low: 0,
        high: 1,
        text: 'slack of the softest link, as a fraction of its length; 0: rigid',
    },
    factor: {
        unit: '',
        low: 0,
        high: 100,
        text: 'factor of all limits; one number, or three for i, j, k',
    },
    bone_threshold_hu: {
        unit: 'HU',
        text: 'bone, elements with a larger value, doesn\'t move',
    },
    smallest_bone_mm3: {
        unit: 'mm³',
        low: 0,
        text: 'smaller pieces above the threshold are stiff and movable; 0: all is bone',
    },
    max_movement_mm: {
        unit: 'mm',
        low: 0,
        high: 500,
        text: 'largest distance from the rest position, for the softest element',
    },
    yield: {
        unit: '',
        low: 0,
        high: 1,
        text: 'strain beyond this fraction of the limits stays; 0: none stays',
    },
    limits: {
        unit: '',
        text: 'how the limits of the links around an element combine; rounded: round contours',
    },
    air_enabled: {
        unit: '',
        text: 'air is a material of its own',
    },
    air_threshold_hu: {
        unit: 'HU',
        text: 'values below it are air; a sphere does not grab them',
    },
    air_compress: {
        unit: '',
        low: 0,
        high: 1,
        text: 'fraction of its length that a link in air can lose',
    },
    air_stretch: {
        unit: '',
        low: 0,
        high: 500,
        text: 'fraction of its length that a link in air can gain',
    },
    air_shear: {
        unit: '',
        low: 0,
        high: 500,
        text: 'sideways slack of a link in air, as a fraction of its length',
    },
};

export interface SpringSettings {
    cell_mm: number; ///< [mm]
    young_modulus_pa: number; ///< [Pa]
    poisson_ratio: number;
    air_threshold_hu: number; ///< [HU]
    fixed_hu: number; ///< [HU]
    fixed_share: number;
    depth: number; ///< [layers]
    damping_s: number; ///< [s]
}

export const springRows: Record<keyof SpringSettings, SettingRow> = {
    cell_mm: {
        unit: 'mm',
        low: 0,
        high: 1000,
        text: 'edge of a control cell, rounded to whole voxels',
    },
    young_modulus_pa: {
        unit: 'Pa',
        low: 1,
        high: 1e+09,
        text: 'Young\'s modulus of tissue; air has a hundredth of it',
    },
    poisson_ratio: {
        unit: '',
        low: 0.25,
        high: 0.499,
        text: 'Poisson\'s ratio of tissue; air has 0.25, that of links',
    },
    air_threshold_hu: {
        unit: 'HU',
        text: 'smaller values are air',
    },
    fixed_hu: {
        unit: 'HU',
        text: 'nodes with a larger mean value around them don\'t move',
    },
    fixed_share: {
        unit: '',
        low: 0,
        high: 1,
        text: 'nor do those of cells with a larger share of such voxels',
    },
    depth: {
        unit: 'layers',
        low: 0,
        high: 1e+06,
        text: 'layers of nodes that forces reach beyond a tool',
    },
    damping_s: {
        unit: 's',
        low: 1e-04,
        high: 10000,
        text: 'time in which free motion dies away to 1/e',
    },
};

export interface ElasticSettings {
    moduli_kpa: [number, number][]; ///< [value, kPa]
    poisson_ratio: number;
    held_above_hu: number; ///< [HU]
    held_sides: string[];
    friction: number;
    return_s: number; ///< [s]
    window_cells: number; ///< [cells]
}

export const elasticRows: Record<keyof ElasticSettings, SettingRow> = {
    moduli_kpa: {
        unit: 'value, kPa',
        text: 'Young\'s modulus by voxel value, 0: void; without it, moduli that suit the scan',
    },
    poisson_ratio: {
        unit: '',
        low: 0,
        high: 0.495,
        text: 'Poisson\'s ratio of tissue; voids have 0',
    },
    held_above_hu: {
        unit: 'HU',
        text: 'larger values are bone, which never moves',
    },
    held_sides: {
        unit: '',
        text: 'sides of the scan, along its axes, that never move; without it, all that cut tissue',
    },
    friction: {
        unit: '',
        low: 0,
        high: 5,
        text: 'coefficient of friction of a sphere that slides',
    },
    return_s: {
        unit: 's',
        low: 0.001,
        high: 1000,
        text: 'time in which released tissue returns to 1/e',
    },
    window_cells: {
        unit: 'cells',
        low: 8,
        high: 512,
        text: 'edge of the finer lattices around a tool; even',
    },
};

export interface Drive {
    insert_mm_s: number; ///< [mm/s]
    rotate_deg_s: number; ///< [degrees/s]
    bend_first_deg: number; ///< [degrees]
    bend_second_deg: number; ///< [degrees]
}

export const driveRows: Record<keyof Drive, SettingRow> = {
    insert_mm_s: {
        unit: 'mm/s',
        low: -100,
        high: 100,
        text: 'speed of the insertion',
    },
    rotate_deg_s: {
        unit: 'degrees/s',
        low: -720,
        high: 720,
        text: 'speed of the rotation',
    },
    bend_first_deg: {
        unit: 'degrees',
        low: -180,
        high: 180,
        text: 'bend of the tip about its first axis',
    },
    bend_second_deg: {
        unit: 'degrees',
        low: -180,
        high: 180,
        text: 'bend of the tip about its second axis',
    },
};

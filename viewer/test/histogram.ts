// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Histogram as SVG for a page of results.

export interface HistogramSettings {
    readonly bin: number;
    readonly end: number; ///< values beyond it go into a separate last bar
    readonly mark: number; ///< a dashed line, for a bound
    readonly markLabel: string;
    readonly label: string; ///< of the values, with their unit
    readonly countLabel: string;
}

export function histogram(values: readonly number[], settings: HistogramSettings): string {
    const { bin, end, mark, markLabel, label, countLabel } = settings;
    const counts = new Array<number>(Math.ceil(end / bin) + 1).fill(0);
    for (const value of values) ++counts[Math.min(Math.floor(value / bin), counts.length - 1)]!;
    const [width, height, left, top, bottom] = [720, 300, 50, 16, 46];
    const most = Math.max(...counts, 1);
    const perUnit = (width - left - 16) / (bin * counts.length);
    const x = (value: number): number => left + perUnit * value;
    const y = (count: number): number => top + (height - top - bottom) * (1 - count / most);
    const at = (number: number): string => number.toFixed(1);
    const middle = 0.5 * (top + height - bottom);
    const text = (tx: number, ty: number, content: string, anchor = 'middle'): string =>
        `<text x="${at(tx)}" y="${at(ty)}" text-anchor="${anchor}">${content}</text>`;
    const bars = counts.map((count, n) => {
        const [from, to] = [x(bin * n), x(bin * (n + 1))];
        const colour = n === counts.length - 1 ? '#b33' : '#37a';
        return (
            `<rect x="${at(from + 0.5)}" y="${at(y(count))}" width="${at(to - from - 1)}" ` +
            `height="${at(y(0) - y(count))}" fill="${colour}"/>`
        );
    });
    const ticks: string[] = [];
    for (let value = 0; value <= end; value += 10)
        ticks.push(text(x(value), y(0) + 16, `${value}`));
    ticks.push(text(x(end + 0.5 * bin), y(0) + 16, '≥', 'start'));
    return [
        `<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 ${width} ${height}" ` +
            'font-family="sans-serif" font-size="12">',
        `<rect width="${width}" height="${height}" fill="#fff"/>`,
        ...bars,
        `<path d="M${at(x(mark))} ${top}V${at(y(0))}" stroke="#b33" stroke-dasharray="4 3"/>`,
        `<path d="M${left} ${at(y(0))}H${width - 16}" stroke="#333"/>`,
        ...ticks,
        text(left - 6, y(most) + 5, `${most}`, 'end'),
        text(left - 6, y(0) + 4, '0', 'end'),
        text(x(mark) - 6, top + 10, markLabel, 'end'),
        `<text x="14" y="${at(middle)}" text-anchor="middle" ` +
            `transform="rotate(-90 14 ${at(middle)})">${countLabel}</text>`,
        text(0.5 * (left + width), height - 8, `${label}; ${values.length} commands`),
        '</svg>',
        '',
    ].join('\n');
}

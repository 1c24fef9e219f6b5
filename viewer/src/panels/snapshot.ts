// SPDX-FileCopyrightText: 2026 The Pliant authors
// SPDX-License-Identifier: Apache-2.0

// Draws the marks over the pictures into a saved picture: lines, names, letters, captions.

const kStyles = [
    'fill',
    'fill-opacity',
    'font-family',
    'font-size',
    'font-weight',
    'opacity',
    'paint-order',
    'stroke',
    'stroke-dasharray',
    'stroke-linecap',
    'stroke-linejoin',
    'stroke-opacity',
    'stroke-width',
];

/// Copies a drawing with all its styles, which a file of its own does not inherit.
function standalone(drawing: SVGElement, width: number, height: number): string {
    const copy = drawing.cloneNode(true) as SVGElement;
    copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
    copy.setAttribute('width', String(width));
    copy.setAttribute('height', String(height));
    const from = [...drawing.querySelectorAll('*')];
    for (const [n, part] of [...copy.querySelectorAll('*')].entries()) {
        const style = getComputedStyle(from[n]!);
        for (const name of kStyles) part.setAttribute(name, style.getPropertyValue(name));
    }
    return new XMLSerializer().serializeToString(copy);
}

function pictureOf(svg: string): Promise<HTMLImageElement | undefined> {
    const image = new Image();
    const url = URL.createObjectURL(new Blob([svg], { type: 'image/svg+xml' }));
    return new Promise((resolve) => {
        image.onload = () => resolve(image);
        image.onerror = () => resolve(undefined);
        image.src = url;
    }).then((loaded) => {
        URL.revokeObjectURL(url);
        return loaded as HTMLImageElement | undefined;
    });
}

/// Draws the marks of all shown views. @param ratio  pixels of the picture per CSS pixel
export async function paintMarks(
    views: readonly HTMLElement[],
    origin: DOMRect,
    context: CanvasRenderingContext2D,
    ratio: number,
): Promise<void> {
    for (const view of views) {
        const box = view.getBoundingClientRect();
        if (!box.width) continue;
        const [x, y] = [box.left - origin.left, box.top - origin.top];
        const drawing = view.querySelector<SVGElement>(':scope > svg');
        const lines = drawing && (await pictureOf(standalone(drawing, box.width, box.height)));
        context.setTransform(ratio, 0, 0, ratio, 0, 0);
        if (lines) context.drawImage(lines, x, y, box.width, box.height);
        for (const text of view.querySelectorAll<HTMLElement>('.name, .caption, .letter')) {
            const spot = text.getBoundingClientRect();
            const style = getComputedStyle(text);
            context.font = `${style.fontWeight} ${style.fontSize} ${style.fontFamily}`;
            context.textBaseline = 'middle';
            context.strokeStyle = '#000';
            context.lineWidth = 3;
            context.fillStyle = style.color;
            const left = spot.left - origin.left + parseFloat(style.paddingLeft);
            const middle = spot.top - origin.top + spot.height / 2;
            context.strokeText(text.textContent ?? '', left, middle);
            context.fillText(text.textContent ?? '', left, middle);
        }
    }
}

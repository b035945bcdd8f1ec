// Displayed pictures of a page against PNGs of the program.

/** Mean difference of two PNGs in 255ths; `light` is the mean level of the reference. Runs in a page. */
export async function differenceOf({ ours, reference }) {
    const pixels = [];
    for (const source of [`data:image/png;base64,${ours}`, reference]) {
        const bitmap = await createImageBitmap(await (await fetch(source)).blob(), { colorSpaceConversion: 'none' });
        const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
        context.drawImage(bitmap, 0, 0);
        pixels.push(context.getImageData(0, 0, bitmap.width, bitmap.height).data);
    }
    const [a, b] = pixels;
    if (a.length !== b.length) throw new Error(`${a.length / 4} and ${b.length / 4} pixels`);
    let sum = 0;
    for (let i = 0; i < a.length; ++i) sum += i % 4 === 3 ? 0 : Math.abs(a[i] - b[i]);
    return { mean: sum / (0.75 * a.length), light: b.reduce((all, x) => all + x, 0) / b.length };
}

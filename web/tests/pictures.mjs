// Pictures that tests bake with.
import { writeFileSync } from 'node:fs';

/** A Radiance picture of 64 x 32 texels: a colour for each quarter of a turn, darker below, and a sun. */
export function writeSky(path) {
    const texel = (x, y) => {
        if (x >= 40 && x < 42 && y >= 8 && y < 10) return [255, 240, 200, 128 + 6];
        const color = [[200, 90, 80], [80, 180, 90], [90, 110, 210], [190, 170, 60]][x >> 4];
        return [...color, y < 16 ? 128 : 126];
    };
    const bytes = Array.from({ length: 64 * 32 }, (_, i) => texel(i % 64, Math.floor(i / 64))).flat();
    writeFileSync(path, Buffer.concat([Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 32 +X 64\n'), Buffer.from(bytes)]));
}

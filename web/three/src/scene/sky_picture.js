// The sky's picture: as a texture with mip levels, and as a probe meets it.
import { ClampToEdgeWrapping, DataTexture, LinearFilter, LinearMipmapLinearFilter, NoColorSpace, RepeatWrapping } from 'three';

import { packRgb9e5, unpackRgb9e5 } from '../file/images.js';
import { shBasis } from '../generated/shading.js';
import { FORMATS } from './textures.js';

/** Half as wide and high; each texel is the mean of four by solid angle. */
function halved({ width, height, data }) {
    const w = Math.max(width >> 1, 1);
    const h = Math.max(height >> 1, 1);
    const share = (y) => Math.cos((y / height) * Math.PI) - Math.cos(((y + 1) / height) * Math.PI);
    const result = new Float32Array(3 * w * h);
    for (let y = 0; y < h; ++y) {
        const rows = height > 1 ? [2 * y, 2 * y + 1] : [0];
        const total = rows.reduce((sum, row) => sum + share(row), 0);
        for (let x = 0; x < w; ++x) {
            const columns = width > 1 ? [2 * x, 2 * x + 1] : [0];
            for (const row of rows)
                for (const column of columns)
                    for (let c = 0; c < 3; ++c)
                        result[3 * (y * w + x) + c] += (data[3 * (row * width + column) + c] * share(row)) / total / columns.length;
        }
    }
    return { width: w, height: h, data: result };
}

/** @param {import('../file/read.js').Pixels} pixels RGB9E5 */
const floats = ({ width, height, data }) => ({ width, height, data: Float32Array.from({ length: 3 * data.length }, (_, i) => unpackRgb9e5(data[Math.floor(i / 3)], i % 3)) });

/** @param {import('../file/read.js').Pixels} pixels RGB9E5 */
export function skyTexture(pixels) {
    const mipmaps = [pixels];
    for (let level = floats(pixels); level.width > 1 || level.height > 1; ) {
        level = halved(level);
        const texels = Uint32Array.from({ length: level.width * level.height }, (_, i) => packRgb9e5(level.data[3 * i], level.data[3 * i + 1], level.data[3 * i + 2]));
        mipmaps.push({ width: level.width, height: level.height, data: texels });
    }
    const texture = new DataTexture(pixels.data, pixels.width, pixels.height, FORMATS.rgb9e5.format, FORMATS.rgb9e5.type);
    Object.assign(texture, { mipmaps, minFilter: LinearMipmapLinearFilter, magFilter: LinearFilter, wrapS: RepeatWrapping, wrapT: ClampToEdgeWrapping, colorSpace: NoColorSpace, generateMipmaps: false, needsUpdate: true });
    return texture;
}

/** Cosine and sine of the rotation, width in texels, cd/m2 of a texel of 1: as GpuFrame::skyPicture. */
export function skyTurn({ pixels, rotation, unitNits }) {
    return [Math.cos(rotation), Math.sin(rotation), pixels.width, unitNits];
}

/** Nine RGB coefficients: a sum over the texels. Directions are those of skyPictureDirection() in shading/sky.h. */
export function skyCoefficients({ pixels, rotation, unitNits }) {
    const { width, height, data } = floats(pixels);
    const radiance = new Float64Array(27);
    for (let y = 0; y < height; ++y) {
        const down = ((y + 0.5) / height) * Math.PI;
        const steradians = ((2 * Math.PI) / width) * (Math.cos((y / height) * Math.PI) - Math.cos(((y + 1) / height) * Math.PI));
        for (let x = 0; x < width; ++x) {
            const around = ((2 * (x + 0.5)) / width - 1) * Math.PI - rotation;
            const d = { x: Math.sin(down) * Math.cos(around), y: Math.cos(down), z: Math.sin(down) * Math.sin(around) };
            for (let i = 0; i < 9; ++i) {
                const weight = shBasis(i, d) * steradians * unitNits;
                for (let c = 0; c < 3; ++c) radiance[3 * i + c] += data[3 * (y * width + x) + c] * weight;
            }
        }
    }
    return radiance;
}

// Light of a proxy volume whose weights change: its texels keep their probes and shares, and are mixed anew a few a frame.
import { DataUtils } from 'three';

/** Texels that a frame mixes anew: about 5 ms of one core of a server, a third of a frame of 60 a second. */
export const TEXELS_A_FRAME = 4096;

const LARGEST_HALF = 65504;

/** Slabs of a volume's radiance. */
export const SLABS_OF_LIGHT = [0, 1, 2, 4, 5, 6, 7];

/** Numbers of a sample's radiance in a texel of each of these slabs: the first four coefficients of red, green and blue, the next four, the last of all. */
export const LIGHT_OF_SLABS = [0, 3, 6, 9, 1, 4, 7, 10, 2, 5, 8, 11, 12, 15, 18, 21, 13, 16, 19, 22, 14, 17, 20, 23, 24, 25, 26, -1];

export class VolumeLight {
    /** @param {number} texels of the volume */
    constructor(texels) {
        this.texels = texels;
        this.probes = new Int32Array(4 * texels);
        this.weights = new Float32Array(4 * texels);
        this.isRunning = false;
        this.next = 0;
        /** Half floats of seven slabs, one after another, and their factor: what the volume has when all are done. */
        this.halves = null;
        this.factor = 1;
        this.sample = null;
    }

    /** @param {number} i texel @param {import('../probes/search.js').Place} place its probes and shares, which add up to 1 */
    keep(i, { probes, weights, count }) {
        for (let k = 0; k < 4; ++k) {
            this.probes[4 * i + k] = probes[k < count ? k : 0];
            this.weights[4 * i + k] = k < count ? weights[k] : 0;
        }
    }

    begin(field) {
        this.isRunning = true;
        this.next = 0;
        this.halves ??= new Uint16Array(28 * this.texels);
        this.sample ??= field.newSample();
        const bound = field.bound();
        this.factor = bound > 0 ? 2 ** (Math.ceil(Math.log2(bound)) - 14) : 1; // a quarter of a half float's: weights may grow meanwhile
    }

    /** @param {import('../probes/field.js').ProbeField} field @param {number} most texels @returns {number} how many were done */
    go(field, most) {
        const end = Math.min(this.next + most, this.texels);
        for (let i = this.next; i < end; ++i) {
            const { radiance } = field.mix(this.probes, this.weights, 4 * i, 4, this.sample);
            for (let n = 0; n < 27; ++n) {
                const x = radiance[LIGHT_OF_SLABS[n]] / this.factor;
                this.halves[4 * ((n >> 2) * this.texels + i) + (n & 3)] = DataUtils.toHalfFloat(Math.min(Math.max(x, -LARGEST_HALF), LARGEST_HALF));
            }
        }
        const done = end - this.next;
        this.next = end;
        this.isRunning = end < this.texels;
        return done;
    }
}

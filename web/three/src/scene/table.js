// What shaders read of each object, as texels of one float texture: an object's row holds
//   0  scale and offset of its lightmap coordinates
//   1  flags (1 lightmapped), lightmap page, row of its proxy volume (-1 none)
//   2  baked attenuation by channel of the first mask layer, from the probes
//   3…11  radiance coefficients from the probes
//   12…14 as 2, of further mask layers
// and a proxy volume's row
//   0…3  columns of the matrix from the world to the volume texture
//   4, 5  first and last texel's centre; 4.w factor on the stored radiance
import { DataTexture, FloatType, NearestFilter, RGBAFormat } from 'three';

import { COLUMNS, ROWS } from '../webgl/table_text.js';

export class ObjectTable {
    constructor() {
        this.count = 0;
        /** First rows that are free, by how many there are. @type {Map<number, number[]>} */
        this.free = new Map();
        this.blocks = 0;
        /** @type {DataTexture | null} */
        this.texture = null;
    }

    /** Rows one after another. @param {number} count @returns {number} the first */
    allocate(count) {
        const reused = this.free.get(count)?.pop();
        if (reused !== undefined) return reused;
        const first = this.count;
        this.count += count;
        const blocks = Math.ceil(this.count / ROWS);
        if (blocks > this.blocks) this.grow(blocks);
        return first;
    }

    /** @param {number} first @param {number} count as allocated */
    release(first, count) {
        if (!this.free.has(count)) this.free.set(count, []);
        this.free.get(count).push(first);
    }

    grow(blocks) {
        const width = blocks * COLUMNS;
        const data = new Float32Array(width * ROWS * 4);
        const old = this.texture;
        const oldWidth = this.blocks * COLUMNS * 4;
        for (let y = 0; old && y < ROWS; ++y) data.set(old.image.data.subarray(y * oldWidth, (y + 1) * oldWidth), y * width * 4);
        this.texture = new DataTexture(data, width, ROWS, RGBAFormat, FloatType);
        this.texture.minFilter = this.texture.magFilter = NearestFilter;
        this.texture.needsUpdate = true;
        this.blocks = blocks;
        old?.dispose();
    }

    /** Where a texel's numbers begin. */
    at(row, column) {
        return 4 * ((row % ROWS) * this.blocks * COLUMNS + Math.floor(row / ROWS) * COLUMNS + column);
    }

    /** @param {number} row @param {number} column @param {ArrayLike<number>} values four */
    set(row, column, values) {
        this.texture.image.data.set(values, this.at(row, column));
        this.texture.needsUpdate = true;
    }

    /** @param {number} row @param {import('../probes/field.js').ProbeSample} sample */
    setSample(row, sample) {
        const { data } = this.texture.image;
        const at = this.at(row, 2);
        data.set(sample.occlusion.subarray(0, 4), at);
        if (sample.occlusion.length > 4) data.set(sample.occlusion.subarray(4), this.at(row, 12));
        for (let i = 0; i < 27; ++i) data[at + 4 + 4 * Math.floor(i / 3) + (i % 3)] = sample.radiance[i];
        this.texture.needsUpdate = true;
    }

    dispose() {
        this.texture?.dispose();
    }
}

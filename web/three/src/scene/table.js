// What shaders read of each object, as texels of one float texture: an object's row holds
//   0  scale and offset of its lightmap coordinates
//   1  flags (1 lightmapped), lightmap page, row of its proxy volume (-1 none)
//   2  baked attenuation by channel, from the probes
//   3…11  radiance coefficients from the probes
// and a proxy volume's row
//   0…3  columns of the matrix from the world to the volume texture
//   4, 5  first and last texel's centre; 4.w factor on the stored radiance
import { DataTexture, FloatType, NearestFilter, RGBAFormat } from 'three';

import { COLUMNS, ROWS } from '../webgl/shader_text.js';

export class ObjectTable {
    constructor() {
        this.count = 0;
        this.blocks = 0;
        /** @type {DataTexture | null} */
        this.texture = null;
    }

    /** Rows one after another. @param {number} count @returns {number} the first */
    allocate(count) {
        const first = this.count;
        this.count += count;
        const blocks = Math.ceil(this.count / ROWS);
        if (blocks > this.blocks) this.grow(blocks);
        return first;
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

    /** @param {number} row @param {number} column @param {ArrayLike<number>} values four */
    set(row, column, values) {
        const width = this.blocks * COLUMNS;
        const at = 4 * ((row % ROWS) * width + Math.floor(row / ROWS) * COLUMNS + column);
        this.texture.image.data.set(values, at);
        this.texture.needsUpdate = true;
    }

    /** @param {number} row @param {import('../probes/field.js').ProbeSample} sample */
    setSample(row, sample) {
        this.set(row, 2, sample.occlusion);
        for (let i = 0; i < 9; ++i) this.set(row, 3 + i, [...sample.radiance.subarray(3 * i, 3 * i + 3), 0]);
    }

    dispose() {
        this.texture?.dispose();
    }
}

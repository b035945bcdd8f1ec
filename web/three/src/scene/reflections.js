// Reflection probes: their picture as a texture, and a row of the object table for each:
//   0…3  columns of the matrix from the world to the cube [-1, 1]^3 of its box
//   4    position; w fade in metres
//   5    half size of the box in metres
import { ClampToEdgeWrapping, DataTexture, LinearFilter, Matrix4, NoColorSpace, Vector3 } from 'three';

import { TEXELS_A_FRAME } from '../groups/composer.js';
import { Pieces } from '../groups/pieces.js';
import { composeReflections, composingReflections, reflectionSources } from '../groups/reflections.js';
import { FORMATS } from './textures.js';

export class Reflections {
    /** @param {import('../file/read.js').BakedData} data @param {import('./table.js').ObjectTable} table */
    constructor(data, table) {
        const { size, probes } = data.reflections;
        /** Whether the picture follows weights of light groups. */
        this.follows = data.groups.some(({ reflections }) => reflections);
        const { picture, unitNits } = this.follows ? composeReflections(data) : data.reflections;
        this.sources = this.follows ? reflectionSources(data) : [];
        this.pieces = null;
        /** cd/m2 of a texel of 1. */
        this.unitNits = unitNits;
        this.texture = new DataTexture(picture.data, picture.width, picture.height, FORMATS.rgb9e5.format, FORMATS.rgb9e5.type);
        Object.assign(this.texture, { minFilter: LinearFilter, magFilter: LinearFilter, wrapS: ClampToEdgeWrapping, wrapT: ClampToEdgeWrapping, colorSpace: NoColorSpace, generateMipmaps: false, needsUpdate: true });
        /** Probes, width of a tile, first row in the table. */
        this.numbers = [probes.length, size, table.allocate(probes.length)];
        probes.forEach(({ position, box, fade }, i) => {
            const row = this.numbers[2] + i;
            const worldFromBox = new Matrix4().fromArray(box);
            const { elements } = worldFromBox.clone().invert();
            for (let c = 0; c < 4; ++c) table.set(row, c, elements.slice(4 * c, 4 * c + 4));
            table.set(row, 4, [...position, fade]);
            const half = [0, 1, 2].map((axis) => new Vector3().setFromMatrixColumn(worldFromBox, axis).length());
            table.set(row, 5, [...half, 0]);
        });
    }

    /** @param {import('../groups/weights.js').LightGroups} groups @returns {boolean} whether the picture has all weights */
    compose(groups) {
        if (!this.follows) return true;
        this.pieces ??= new Pieces(() => composingReflections(this.sources, groups.weights(), TEXELS_A_FRAME));
        const sum = this.pieces.next(groups.version);
        if (sum) {
            this.unitNits = sum.unitNits;
            this.texture.image.data.set(sum.texels);
            this.texture.needsUpdate = true;
        }
        return this.pieces.has(groups.version);
    }

    dispose() {
        this.texture.dispose();
    }
}

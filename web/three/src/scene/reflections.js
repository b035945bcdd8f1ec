// Reflection probes: their picture as a texture, and a row of the object table for each:
//   0…3  columns of the matrix from the world to the cube [-1, 1]^3 of its box
//   4    position; w fade in metres
//   5    half size of the box in metres
import { ClampToEdgeWrapping, DataTexture, LinearFilter, Matrix4, NoColorSpace, Vector3 } from 'three';

import { FORMATS } from './textures.js';

export class Reflections {
    /** @param {import('../file/read.js').ReflectionData} data @param {import('./table.js').ObjectTable} table */
    constructor({ picture, unitNits, size, probes }, table) {
        this.texture = new DataTexture(picture.data, picture.width, picture.height, FORMATS.rgb9e5.format, FORMATS.rgb9e5.type);
        Object.assign(this.texture, { minFilter: LinearFilter, magFilter: LinearFilter, wrapS: ClampToEdgeWrapping, wrapT: ClampToEdgeWrapping, colorSpace: NoColorSpace, generateMipmaps: false, needsUpdate: true });
        /** Probes, width of a tile, cd/m2 of a texel of 1, first row: hlReflections of the shaders. */
        this.numbers = [probes.length, size, unitNits, table.allocate(probes.length)];
        probes.forEach(({ position, box, fade }, i) => {
            const row = this.numbers[3] + i;
            const worldFromBox = new Matrix4().fromArray(box);
            const { elements } = worldFromBox.clone().invert();
            for (let c = 0; c < 4; ++c) table.set(row, c, elements.slice(4 * c, 4 * c + 4));
            table.set(row, 4, [...position, fade]);
            const half = [0, 1, 2].map((axis) => new Vector3().setFromMatrixColumn(worldFromBox, axis).length());
            table.set(row, 5, [...half, 0]);
        });
    }

    dispose() {
        this.texture.dispose();
    }
}

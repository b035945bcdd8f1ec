// Pictures of the program, as pages read them.
import * as THREE from 'three';
import { EXRLoader } from 'three/addons/loaders/EXRLoader.js';

export const encode = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
export const clamp = (x) => Math.min(Math.max(x, 0), 1);

/** As the file has it: rows from the bottom, and its channels. */
export async function readExr(url) {
    const loader = new EXRLoader();
    loader.setDataType(THREE.FloatType);
    const exr = loader.parse(await (await fetch(url)).arrayBuffer());
    return { ...exr, channels: exr.data.length / (exr.width * exr.height) };
}

/** Three channels, rows from the top. */
export async function readReference(url) {
    const { width, height, channels, data } = await readExr(url);
    const rows = new Float32Array(width * height * 3);
    for (let y = 0; y < height; ++y)
        for (let x = 0; x < width; ++x)
            for (let c = 0; c < 3; ++c) rows[3 * (y * width + x) + c] = data[channels * ((height - 1 - y) * width + x) + c];
    return { width, height, rows };
}

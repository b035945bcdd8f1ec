// three.js's tone mappers, run on the graphics device, and displayed pictures of the program.
import * as THREE from 'three';

import { clamp, encode, readReference } from './pictures.js';
import { drawQuad } from './quad.js';

/** Names of --tone-mapping: functions of three.js's shader chunk. */
const FUNCTIONS = { neutral: 'NeutralToneMapping', aces: 'ACESFilmicToneMapping', agx: 'AgXToneMapping', none: 'LinearToneMapping' };

/**
 * @param {any} renderer @param {(renderer: any, target: any, width: number, height: number) => any} read
 * @param {{width: number, height: number, rows: Float32Array}} picture radiance, rows from the top
 * @returns {Promise<Float32Array>} RGBA, display-referred and linear, rows from the top
 */
async function toneMapped(renderer, read, { width, height, rows }, name, exposure) {
    const data = new Float32Array(4 * width * height);
    for (let i = 0; i < width * height; ++i) data.set(rows.subarray(3 * i, 3 * i + 3), 4 * i);
    const texture = new THREE.DataTexture(data, width, height, THREE.RGBAFormat, THREE.FloatType);
    texture.needsUpdate = true;
    const material = new THREE.RawShaderMaterial({
        glslVersion: THREE.GLSL3,
        uniforms: { radiance: { value: texture }, toneMappingExposure: { value: exposure } },
        vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
        fragmentShader: `
precision highp float;
${THREE.ShaderChunk.tonemapping_pars_fragment}
uniform highp sampler2D radiance;
out vec4 color;
void main() { color = vec4(${FUNCTIONS[name]}(texelFetch(radiance, ivec2(gl_FragCoord.xy), 0).rgb), 1.0); }`,
    });
    const pixels = await drawQuad(renderer, read, material, width, height); // gl_FragCoord counts rows as the readback does
    for (const used of [texture, material]) used.dispose();
    return pixels;
}

/** How far a displayed picture of the program is from the radiance, tone mapped by three.js, in 255ths. */
export async function differenceFrom(renderer, read, { radiance, picture, name, exposure }) {
    const exr = await readReference(radiance);
    const { width, height } = exr;
    const expected = await toneMapped(renderer, read, exr, name, exposure);
    const canvas = new OffscreenCanvas(width, height).getContext('2d');
    canvas.drawImage(await createImageBitmap(await (await fetch(picture)).blob(), { colorSpaceConversion: 'none' }), 0, 0);
    const shown = canvas.getImageData(0, 0, width, height).data;
    let [most, sum, level] = [0, 0, 0];
    for (let i = 0; i < shown.length; ++i) {
        if (i % 4 === 3) continue;
        const difference = Math.abs(shown[i] - Math.round(255 * encode(clamp(expected[i]))));
        most = Math.max(most, difference);
        sum += difference;
        level += shown[i];
    }
    const channels = 3 * width * height;
    return { most, mean: sum / channels, level: level / channels };
}

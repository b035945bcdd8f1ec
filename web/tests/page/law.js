// The formulas of the shading headers, run on the graphics device: GLSL for WebGLRenderer, TSL for WebGPURenderer.
import * as THREE from 'three';

import { drawQuad } from './quad.js';

const WIDTH = 64;

/** Arguments of all cases as texels, one row for each case. */
function argumentTexture(cases) {
    const floats = cases.map((values) => values.flat().map(Number));
    const texels = Math.ceil(Math.max(...floats.map((list) => list.length)) / 4);
    const data = new Float32Array(4 * texels * cases.length);
    floats.forEach((list, row) => data.set(list, 4 * texels * row));
    const texture = new THREE.DataTexture(data, texels, cases.length, THREE.RGBAFormat, THREE.FloatType);
    texture.needsUpdate = true;
    return texture;
}

/** For each parameter its type and where its numbers begin. */
function placed(types) {
    let at = 0;
    return types.map((type) => {
        const components = type.startsWith('vec') ? Number(type[3]) : 1;
        at += components;
        return { type, components, first: at - components };
    });
}

async function glslMaterial(name, types, result, texture) {
    const { default: shading } = await import('../../three/src/generated/shading.glsl.js');
    const value = (k) => `argument(${k})`;
    const given = placed(types).map(({ type, components, first }) => {
        if (type === 'bool') return `${value(first)} > 0.5`;
        if (type === 'int') return `int(${value(first)} + 0.5)`;
        return `${type}(${Array.from({ length: components }, (_, i) => value(first + i))})`;
    });
    const out = result === 'vec3' ? 'vec4(result, 0.0)' : 'vec4(result, 0.0, 0.0, 0.0)';
    return new THREE.RawShaderMaterial({
        glslVersion: THREE.GLSL3,
        uniforms: { cases: { value: texture } },
        vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
        fragmentShader: `
precision highp float;
precision highp int;
${shading}
uniform highp sampler2D cases;
out vec4 color;
float argument(int k)
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    int row = min(pixel.y * ${WIDTH} + pixel.x, textureSize(cases, 0).y - 1);
    return texelFetch(cases, ivec2(k / 4, row), 0)[k % 4];
}
void main()
{
    ${result} result = hl${name}(${given});
    color = ${out};
}`,
    });
}

async function tslMaterial(name, types, result, texture) {
    const hl = await import('../../three/src/generated/shading.tsl.js');
    const { float, int, ivec2, screenCoordinate, textureLoad, vec2, vec3, vec4 } = await import('three/tsl');
    const pixel = ivec2(screenCoordinate.xy);
    const row = pixel.y.mul(WIDTH).add(pixel.x).min(int(texture.image.height - 1)).toVar();
    const value = (k) => textureLoad(texture, ivec2(int(Math.floor(k / 4)), row))['xyzw'[k % 4]];
    const given = placed(types).map(({ type, components, first }) => {
        if (type === 'bool') return value(first).greaterThan(0.5);
        if (type === 'int') return int(value(first).add(0.5));
        if (type === 'float') return value(first);
        return { vec2, vec3 }[type](...Array.from({ length: components }, (_, i) => value(first + i)));
    });
    const returned = hl[`hl${name}`](...given);
    const material = new THREE.NodeMaterial();
    material.fragmentNode = result === 'vec3' ? vec4(returned, 0) : vec4(float(returned), 0, 0, 0);
    return material;
}

/**
 * What a function returns for each case: {name without prefix and with a capital, types of its parameters, type of its result}.
 * @param {any} renderer @param {(renderer: any, target: any, width: number, height: number) => any} read rows from the top or the bottom
 */
export async function evaluate(renderer, read, { name, types, result, cases }, rowsFromTop) {
    const texture = argumentTexture(cases);
    const material = renderer.isWebGLRenderer ? await glslMaterial(name, types, result, texture) : await tslMaterial(name, types, result, texture);
    const height = Math.ceil(cases.length / WIDTH);
    const pixels = await drawQuad(renderer, read, material, WIDTH, height);
    const components = result === 'vec3' ? 3 : 1;
    // gl_FragCoord counts rows from the bottom as WebGL's readback does; screenCoordinate from the top as WebGPU's.
    return cases.map((_, i) => {
        const y = Math.floor(i / WIDTH);
        const at = 4 * ((rowsFromTop ? height - 1 - y : y) * WIDTH + (i % WIDTH));
        return [...pixels.slice(at, at + components)];
    });
}

// three.js's tone mappers, run on the graphics device.
import * as THREE from 'three';

/** Names of --tone-mapping: functions of three.js's shader chunk. */
const FUNCTIONS = { neutral: 'NeutralToneMapping', aces: 'ACESFilmicToneMapping', agx: 'AgXToneMapping', none: 'LinearToneMapping' };

/**
 * @param {any} renderer @param {(renderer: any, target: any, width: number, height: number) => any} read
 * @param {{width: number, height: number, rows: Float32Array}} picture radiance, rows from the top
 * @returns {Promise<Float32Array>} RGBA, display-referred and linear, rows from the top
 */
export async function toneMapped(renderer, read, { width, height, rows }, name, exposure) {
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
        depthTest: false,
        depthWrite: false,
    });
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType });
    const scene = new THREE.Scene();
    scene.add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material));
    scene.children[0].frustumCulled = false;
    renderer.setRenderTarget(target);
    renderer.render(scene, new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1));
    const pixels = await read(renderer, target, width, height); // gl_FragCoord counts rows as the readback does
    renderer.setRenderTarget(null);
    for (const used of [target, texture, material]) used.dispose();
    return pixels;
}

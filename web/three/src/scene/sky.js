// The sky where nothing else is drawn.
import { BackSide, BoxGeometry, Mesh, Object3D, ShaderMaterial } from 'three';

import shading from '../generated/shading.glsl.js';
import { skyText } from '../webgl/surface_text.js';

/** @param {any} uniforms of the bake: hlView, and those of skyText */
export function makeSky(uniforms) {
    const material = new ShaderMaterial({
        name: 'halflight sky',
        defines: uniforms.hlSkyPicture ? { HL_SKY_PICTURE: '' } : {},
        uniforms: Object.fromEntries(Object.entries(uniforms).filter(([name]) => name === 'hlView' || /^hlSky(Picture|Turn|FromWorld|Factor)?$/.test(name))),
        vertexShader: `
varying vec3 vDirection;
void main()
{
    vDirection = position;
    vec4 clip = projectionMatrix * vec4(mat3(viewMatrix) * position, 1.0);
    if (projectionMatrix[2][3] == 0.0) vDirection = -vec3(viewMatrix[0][2], viewMatrix[1][2], viewMatrix[2][2]);
    gl_Position = projectionMatrix[2][3] == 0.0 ? vec4(position.xy * 2.0, 0.0, 1.0) : clip;
}`,
        fragmentShader: `
${shading}${skyText}
uniform int hlView;
uniform mat3 hlSkyFromWorld;
varying vec3 vDirection;
void main()
{
    vec3 radiance = hlSkyTowards(normalize(hlSkyFromWorld * vDirection), 0.0);
    gl_FragColor = vec4(hlView == 0 ? radiance : vec3(0.0), 1.0);
    #include <tonemapping_fragment>
    #include <colorspace_fragment>
}`,
        side: BackSide,
        depthTest: false,
        depthWrite: false,
    });
    const mesh = new Mesh(new BoxGeometry(2, 2, 2), material);
    mesh.name = 'halflight sky';
    mesh.renderOrder = -1e9;
    mesh.frustumCulled = false;
    mesh.castShadow = mesh.receiveShadow = false;
    mesh.raycast = () => {};
    mesh.clone = () => new Object3D(); // of a scene: each file draws its own
    return mesh;
}

// The gradient sky where nothing else is drawn.
import { BackSide, BoxGeometry, Mesh, ShaderMaterial } from 'three';

import shading from '../generated/shading.glsl.js';

/** @param {{value: any}} sky zenith, horizon, ground @param {{value: number}} view */
export function makeSky(sky, view) {
    const material = new ShaderMaterial({
        name: 'halflight sky',
        uniforms: { hlSky: sky, hlView: view },
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
${shading}
uniform vec3 hlSky[3];
uniform int hlView;
varying vec3 vDirection;
void main()
{
    vec3 radiance = hlSkyRadiance(hlSky[0], hlSky[1], hlSky[2], normalize(vDirection));
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
    return mesh;
}

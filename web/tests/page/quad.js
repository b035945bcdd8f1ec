// A material's colours as floats, drawn over a whole picture.
import * as THREE from 'three';

/** @param {(renderer: any, target: any, width: number, height: number) => any} read rows from the top or the bottom, RGBA */
export async function drawQuad(renderer, read, material, width, height) {
    material.depthTest = material.depthWrite = false;
    const target = new (THREE.WebGLRenderTarget ?? THREE.RenderTarget)(width, height, { type: THREE.FloatType, minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter });
    const scene = new THREE.Scene();
    scene.add(new THREE.Mesh(new THREE.PlaneGeometry(2, 2), material));
    scene.children[0].frustumCulled = false;
    renderer.setRenderTarget(target);
    renderer.render(scene, new THREE.OrthographicCamera(-1, 1, 1, -1, -1, 1));
    const pixels = await read(renderer, target, width, height);
    renderer.setRenderTarget(null);
    target.dispose();
    return pixels;
}

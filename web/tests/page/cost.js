// What a frame costs.
import * as THREE from 'three';

/** Milliseconds of a frame, the median of several, with the plug-in or of three.js alone with the same lights and shadows. */
export async function frameCost({ loaded, load, makeRenderer, viewOf }, { file, width, height, camera, mode, frames }) {
    await load({ file });
    const renderer = await makeRenderer(width, height);
    const view = viewOf(camera, width / height);
    const target = new (THREE.WebGLRenderTarget ?? THREE.RenderTarget)(width, height, { type: THREE.HalfFloatType });
    const { scene, halflight } = loaded;
    if (mode === 'three.js') {
        // The plug-in's shadow cameras and map sizes, every object a caster; then its patches are taken back.
        halflight.mode = 'realtime';
        halflight.update(renderer, view);
        const shadows = halflight.lights.map(({ light }) => [light, light.castShadow, light.shadow.clone()]);
        const meshes = [];
        scene.traverse((o) => o.isMesh && o !== halflight.sky && meshes.push([o, o.castShadow, o.receiveShadow]));
        halflight.dispose();
        for (const [light, cast, shadow] of shadows) {
            light.castShadow = cast;
            light.shadow.copy(shadow);
        }
        for (const [mesh, cast, receive] of meshes) Object.assign(mesh, { castShadow: cast, receiveShadow: receive });
        loaded.halflight = null;
    } else {
        halflight.mode = mode;
    }
    const times = [];
    const pixel = new Uint16Array(4);
    for (let i = 0; i < frames + 2; ++i) {
        const start = performance.now();
        if (mode !== 'three.js') halflight.update(renderer, view);
        const updated = performance.now();
        renderer.setRenderTarget(target);
        renderer.render(scene, view);
        renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel); // waits for the frame
        times.push([performance.now() - start, updated - start]);
    }
    renderer.setRenderTarget(null);
    target.dispose();
    const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];
    const later = times.slice(2); // the first compile and upload
    return { frame: median(later.map((t) => t[0])), update: median(later.map((t) => t[1])), calls: renderer.info.render.calls, triangles: renderer.info.render.triangles };
}

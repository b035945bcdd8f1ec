// Milliseconds of frames with and without a change of a light group's weight, in turns.
import * as THREE from 'three';
import { HalflightPlugin } from '@halflight/three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

async function load(file) {
    const loader = new GLTFLoader();
    loader.setMeshoptDecoder(MeshoptDecoder);
    loader.register((parser) => new HalflightPlugin(parser));
    const gltf = await loader.loadAsync(file);
    const scene = new THREE.Scene();
    scene.add(gltf.scene);
    return { scene, halflight: gltf.userData.halflight };
}

function cameraOf({ fov, eye, target }, aspect) {
    const camera = new THREE.PerspectiveCamera(fov, aspect, 0.05, 200);
    camera.position.fromArray(eye);
    camera.lookAt(new THREE.Vector3().fromArray(target));
    return camera;
}

/** Frames in blocks: one without a change, one with, and those after it until all light has followed. */
window.measure = async ({ file, width, height, camera: view, changes, all }) => {
    const { scene, halflight } = await load(file);
    const renderer = new THREE.WebGLRenderer({ antialias: false });
    renderer.shadowMap.enabled = true;
    renderer.setSize(width, height);
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.HalfFloatType });
    const camera = cameraOf(view, width / height);
    const pixel = new Uint16Array(4);
    const frame = () => {
        const start = performance.now();
        halflight.update(renderer, camera);
        const updated = performance.now();
        renderer.setRenderTarget(target);
        renderer.render(scene, camera);
        renderer.readRenderTargetPixels(target, 0, 0, 1, 1, pixel); // waits for the frame
        renderer.setRenderTarget(null);
        return { milliseconds: performance.now() - start, update: updated - start };
    };
    const groups = halflight.lightGroups;
    const change = (i) => {
        for (const [k, { name }] of groups.entries()) if (all || k === i % groups.length) halflight.setLightGroup(name, 0.5 + (i % 7) / 7);
    };
    change(0);
    for (let i = 0; i < 4; ++i) frame(); // shaders are compiled
    const [plain, changed, following] = [[], [], []];
    for (let i = 1; i <= changes; ++i) {
        plain.push(frame());
        change(i);
        changed.push(frame());
        while (halflight.isFollowing) following.push(frame());
    }
    const page = halflight.data.lightmaps[0];
    const of = (list) => ({ frames: list.length, median: median(list.map((f) => f.milliseconds)), most: Math.max(...list.map((f) => f.milliseconds)), update: median(list.map((f) => f.update)) });
    return { groups: groups.length, pages: `${halflight.data.lightmaps.length} of ${page.width} x ${page.height}`, plain: of(plain), changed: of(changed), following: following.length > 0 ? of(following) : null };
};
window.ready = true;

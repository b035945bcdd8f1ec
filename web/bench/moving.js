// Milliseconds of update() with moving objects, by this plug-in and by that of another folder, frame by frame in turns.
import * as THREE from 'three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const median = (list) => list.sort((a, b) => a - b)[list.length >> 1];

/** A copy of the file with objects of the application, and how to move them. */
async function makeWorld(folder, file, objects) {
    const { HalflightPlugin } = await import(`${folder}/src/index.js`);
    const loader = new GLTFLoader();
    loader.setMeshoptDecoder(MeshoptDecoder);
    loader.register((parser) => new HalflightPlugin(parser));
    const gltf = await loader.loadAsync(file);
    const scene = new THREE.Scene();
    scene.add(gltf.scene);
    const halflight = gltf.userData.halflight;
    const box = halflight.bounds;
    const material = new THREE.MeshStandardMaterial();
    const meshes = Array.from({ length: objects }, (_, i) => {
        const mesh = new THREE.Mesh(new THREE.SphereGeometry(0.1, 8, 4), material);
        scene.add(mesh);
        halflight.add(mesh);
        mesh.userData.phase = i * 2.399963;
        return mesh;
    });
    /** Each goes about a tenth of the scene's box around its own place. */
    const move = (frame, moving) => {
        for (const [i, mesh] of meshes.slice(0, moving).entries()) {
            const share = (k) => (((i + 1) * k) % 1) * 0.9 + 0.05 * (1 + Math.sin(frame * 0.1 + mesh.userData.phase * k));
            mesh.position.set(share(0.7548776662), share(0.5698402909), share(0.4656)).multiply(box.getSize(new THREE.Vector3())).add(box.min);
        }
    };
    return { halflight, move };
}

window.measure = async ({ file, objects, frames, folders }) => {
    const renderer = new THREE.WebGLRenderer();
    renderer.shadowMap.enabled = true;
    const camera = new THREE.PerspectiveCamera(50, 1.5, 0.1, 100);
    const worlds = [];
    for (const folder of folders) worlds.push({ ...(await makeWorld(folder, file, objects)), all: [], few: [] });
    for (let i = 0; i < frames + 20; ++i)
        for (const { halflight, move, all, few } of worlds)
            for (const [moving, times] of [[objects, all], [objects / 10, few]]) {
                move(i + moving, moving);
                const start = performance.now();
                halflight.update(renderer, camera);
                times.push(performance.now() - start);
            }
    return worlds.map(({ all, few }) => ({ all: median(all.slice(20)), few: median(few.slice(20)) })); // the first are compiled
};
window.ready = true;

// Exported files in three.js as it is, against pictures of the program.
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

import { clamp, encode, readExr } from './pictures.js';

const OTHER = 1000; // red of objects that are no surfaces of the export

let renderer = null;

function draw(scene, view, width, height) {
    const target = new THREE.WebGLRenderTarget(width, height, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
    renderer.setRenderTarget(target);
    renderer.clear();
    renderer.render(scene, view);
    const pixels = new Float32Array(width * height * 4);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    renderer.setRenderTarget(null);
    target.dispose();
    return pixels; // rows from the bottom
}

function png(width, height, colorAt) {
    const canvas = document.createElement('canvas');
    Object.assign(canvas, { width, height });
    const context = canvas.getContext('2d');
    const image = context.createImageData(width, height);
    for (let y = 0; y < height; ++y)
        for (let x = 0; x < width; ++x)
            for (let c = 0; c < 4; ++c)
                image.data[4 * (y * width + x) + c] = c === 3 ? 255 : Math.round(255 * colorAt(x, height - 1 - y, c));
    context.putImageData(image, 0, 0);
    return canvas.toDataURL('image/png').split(',')[1];
}

/** Mean and 99th percentile of the difference in 255ths on exported surfaces, sRGB-encoded after the export's exposure. */
async function compare({ file, reference, camera, exposure, width, height, pictures }) {
    if (!renderer) {
        renderer = new THREE.WebGLRenderer({ antialias: false, alpha: true });
        renderer.setPixelRatio(1);
        renderer.setClearColor(0x000000, 0);
    }
    renderer.setSize(width, height);
    const gltf = await new GLTFLoader().loadAsync(file);
    const scene = new THREE.Scene();
    scene.add(gltf.scene);
    const view = new THREE.PerspectiveCamera(camera.fov, width / height, 0.05, 200);
    view.position.fromArray(camera.eye);
    view.lookAt(new THREE.Vector3().fromArray(camera.target));
    const pixels = draw(scene, view, width, height);
    const marker = new THREE.MeshBasicMaterial({ color: new THREE.Color(OTHER, 0, 0) });
    const types = new Set();
    scene.traverse((object) => {
        if (!object.isMesh) return;
        if (object.material.name.startsWith('surfaces')) types.add(object.material.type);
        else object.material = marker;
    });
    const marked = draw(scene, view, width, height);
    const exr = await readExr(reference);
    const factor = 2 ** -exposure;
    const at = (x, y, c) => exr.data[exr.channels * (y * width + x) + c] * factor; // the loader's rows begin below
    const isSurface = (x, y) => marked[4 * (y * width + x)] < OTHER / 2 && pixels[4 * (y * width + x) + 3] > 0;
    const differences = [];
    for (let y = 0; y < height; ++y)
        for (let x = 0; x < width; ++x)
            for (let c = 0; isSurface(x, y) && c < 3; ++c)
                differences.push(255 * Math.abs(encode(clamp(pixels[4 * (y * width + x) + c])) - encode(clamp(at(x, y, c)))));
    differences.sort((a, b) => a - b);
    const result = {
        mean: differences.reduce((sum, d) => sum + d, 0) / differences.length,
        p99: differences[Math.floor(differences.length * 0.99)],
        share: differences.length / (3 * width * height),
        types: [...types],
    };
    if (pictures) {
        result.three = png(width, height, (x, y, c) => encode(clamp(pixels[4 * (y * width + x) + c])));
        result.program = png(width, height, (x, y, c) => encode(clamp(at(x, y, c))));
    }
    return result;
}

window.halflightTest = { compare };
window.ready = true;

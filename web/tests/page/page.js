// Functions that the tests call in the browser: draw a file, compare with a picture of the program.
import * as THREE from 'three';
import { HalflightPlugin } from '@halflight/three';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';
import { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

import { shIrradianceWeight } from '../../three/src/generated/shading.js';
import { frameCost } from './cost.js';
import { evaluate } from './law.js';
import { clamp, encode, readReference } from './pictures.js';
import { follow, put } from './places.js';
import { differenceFrom } from './tone.js';

const loaded = {};

async function load({ file, options }) {
    loaded.halflight?.dispose();
    loaded.group = null;
    const loader = new GLTFLoader();
    loader.setMeshoptDecoder(MeshoptDecoder);
    loader.setDRACOLoader(new DRACOLoader().setDecoderPath('/three/examples/jsm/libs/draco/gltf/'));
    let plugin;
    if (options?.shareAssociations) loader.register(shareAssociations);
    loader.register((parser) => (plugin = new HalflightPlugin(parser, options)));
    const gltf = await loader.loadAsync(file);
    loaded.gltf = gltf;
    loaded.halflight = plugin.scene;
    loaded.scene = new THREE.Scene();
    loaded.scene.add(gltf.scene);
    gltf.scene.traverse((object) => {
        for (const material of object.isMesh ? [object.material].flat() : [])
            for (const value of Object.values(material)) if (value?.isTexture) value.anisotropy = 8; // as the program
    });
    return { modes: plugin.scene?.modes, objects: plugin.scene?.objects.length, cellsOfFile: plugin.scene?.field.cellsOfFile, bytes: plugin.scene?.data.bytes };
}

/** As three-stdlib's loader: the clones of a mesh have one association. */
const shareAssociations = (parser) => ({
    name: 'shared associations',
    afterRoot() {
        const shared = new Map();
        for (const [object, association] of parser.associations) {
            if (association.meshes === undefined) continue;
            if (!shared.has(association.meshes)) shared.set(association.meshes, association);
            parser.associations.set(object, shared.get(association.meshes));
        }
        return null;
    },
});

const kind = new URLSearchParams(location.search).get('renderer') ?? 'webgl';

async function makeRenderer(width, height) {
    if (loaded.renderer) return loaded.renderer;
    const renderer = kind === 'webgl' ? new THREE.WebGLRenderer({ antialias: false }) : new THREE.WebGPURenderer({ antialias: false, forceWebGL: kind === 'webgl2-nodes' });
    await renderer.init?.();
    if (kind === 'webgpu' && !renderer.backend.isWebGPUBackend) throw new Error('the browser has no WebGPU');
    renderer.setPixelRatio(1);
    renderer.shadowMap.enabled = true;
    renderer.shadowMap.type = THREE.PCFShadowMap;
    renderer.setSize(width, height);
    loaded.renderer = renderer;
    return renderer;
}

/** @param {any} camera name of one of the file's, or where one stands and looks */
function viewOf(camera, aspect) {
    if (typeof camera === 'string') {
        const own = loaded.gltf.cameras.find((c) => [c.name, c.parent?.name].includes(camera));
        if (!own) throw new Error(`the file has no camera "${camera}"`);
        loaded.scene.updateMatrixWorld();
        const view = own.clone(false);
        own.matrixWorld.decompose(view.position, view.quaternion, view.scale);
        view.aspect = aspect;
        view.updateProjectionMatrix();
        view.updateMatrixWorld();
        return view;
    }
    const view = new THREE.PerspectiveCamera(camera.fov, aspect, 0.05, 200);
    view.position.fromArray(camera.eye);
    view.lookAt(new THREE.Vector3().fromArray(camera.target));
    view.updateMatrixWorld();
    return view;
}

/** Linear radiance, rows from the top. */
async function draw({ width, height, camera, settings = {} }) {
    const renderer = await makeRenderer(width, height);
    const { scene, halflight } = loaded;
    const view = viewOf(camera, width / height);
    follow(loaded, view);
    Object.assign(halflight, settings);
    const target = new (THREE.WebGLRenderTarget ?? THREE.RenderTarget)(width, height, { type: THREE.FloatType, colorSpace: THREE.LinearSRGBColorSpace });
    halflight.update(renderer, view);
    renderer.setRenderTarget(target);
    const start = performance.now();
    renderer.render(scene, view);
    const calls = renderer.info.render.drawCalls ?? renderer.info.render.calls; // of this frame, of all
    const pixels = await read(renderer, target, width, height);
    const milliseconds = performance.now() - start;
    renderer.setRenderTarget(null);
    target.dispose();
    const rows = new Float32Array(width * height * 3);
    for (let y = 0; y < height; ++y)
        for (let x = 0; x < width; ++x)
            for (let c = 0; c < 3; ++c) rows[3 * (y * width + x) + c] = pixels[4 * ((kind === 'webgpu' ? y : height - 1 - y) * width + (loaded.isMirrored ? width - 1 - x : x)) + c];
    loaded.picture = { width, height, rows };
    return { milliseconds, calls, warnings: [...halflight.warnings] };
}

async function read(renderer, target, width, height) {
    if (kind !== 'webgl') return renderer.readRenderTargetPixelsAsync(target, 0, 0, width, height);
    const pixels = new Float32Array(width * height * 4);
    renderer.readRenderTargetPixels(target, 0, 0, width, height, pixels);
    return pixels;
}

/** The factor that puts the log-average luminance at middle grey. */
function exposureOf(picture) {
    let sum = 0;
    for (let i = 0; i < picture.rows.length; i += 3)
        sum += Math.log(1e-4 + 0.2126 * picture.rows[i] + 0.7152 * picture.rows[i + 1] + 0.0722 * picture.rows[i + 2]);
    return 0.18 / Math.exp(sum / (picture.rows.length / 3));
}

/** Mean difference in 255ths at one exposure, of linear and of sRGB-encoded values; and pictures to look at. */
async function compare({ reference, pictures = false, other = null }) {
    const a = loaded.picture;
    const b = other ? loaded[other] : await readReference(reference);
    if (a.width !== b.width || a.height !== b.height) throw new Error('the pictures differ in size');
    const exposure = exposureOf(b);
    let linear = 0;
    let encoded = 0;
    const differences = new Float32Array(a.rows.length);
    for (let i = 0; i < a.rows.length; ++i) {
        const p = clamp(a.rows[i] * exposure);
        const q = clamp(b.rows[i] * exposure);
        linear += Math.abs(p - q);
        differences[i] = Math.abs(encode(p) - encode(q));
        encoded += differences[i];
    }
    const n = a.rows.length / 255;
    const sorted = Float32Array.from(differences).sort();
    const result = { linear: linear / n, encoded: encoded / n, median: 255 * sorted[sorted.length >> 1], p99: 255 * sorted[Math.floor(sorted.length * 0.99)], ...luminanceOf(a, b) };
    if (pictures) {
        result.ours = png(a, (x) => encode(clamp(x * exposure)));
        result.reference = png(b, (x) => encode(clamp(x * exposure)));
        result.difference = png({ ...a, rows: differences }, (x) => clamp(x * 8));
    }
    return result;
}

/** How far luminances are apart: docs/conformance.md. `even`: of pixels whose surroundings have one value, the share within 1 %. */
function luminanceOf(a, b) {
    const [x, y] = [a, b].map(({ rows }) => Float32Array.from({ length: rows.length / 3 }, (_, i) => 0.2126 * rows[3 * i] + 0.7152 * rows[3 * i + 1] + 0.0722 * rows[3 * i + 2]));
    const mean = y.reduce((sum, l) => sum + l, 0) / y.length;
    let sum = 0;
    let near = 0;
    const even = { all: 0, near: 0 };
    for (let i = 0; i < y.length; ++i) {
        const off = Math.abs(x[i] - y[i]);
        sum += off;
        near += off <= 0.05 * y[i] + 0.05 * mean ? 1 : 0;
        const around = [-1, 0, 1].flatMap((row) => [-1, 0, 1].map((column) => y[i + row * b.width + column]));
        if (!around.every((l) => Math.abs(l - y[i]) <= 0.02 * y[i])) continue;
        even.all += 1;
        even.near += off <= 0.01 * y[i] ? 1 : 0;
    }
    return { meanRelative: sum / y.length / mean, share: near / y.length, evenPixels: even.all, even: even.near / even.all };
}

function png({ width, height, rows }, display) {
    const canvas = document.createElement('canvas');
    Object.assign(canvas, { width, height });
    const context = canvas.getContext('2d');
    const image = context.createImageData(width, height);
    for (let i = 0; i < width * height; ++i) {
        for (let c = 0; c < 3; ++c) image.data[4 * i + c] = Math.round(255 * display(rows[3 * i + c]));
        image.data[4 * i + 3] = 255;
    }
    context.putImageData(image, 0, 0);
    return canvas.toDataURL('image/png').split(',')[1];
}

const bytesToText = (bytes) => {
    let text = '';
    for (let i = 0; i < bytes.length; i += 8192) text += String.fromCharCode(...bytes.subarray(i, i + 8192));
    return btoa(text);
};

/** The last picture, for another page to compare with. */
async function picture() {
    return bytesToText(new Uint8Array(loaded.picture.rows.buffer));
}

/** Agreement with another page's picture, sRGB-encoded at one exposure; `inside`: where that picture has no edge. */
async function agreement({ other }) {
    const rows = new Float32Array(Uint8Array.from(atob(other), (c) => c.charCodeAt(0)).buffer);
    const { width, height } = loaded.picture;
    const exposure = exposureOf({ rows });
    const [ours, theirs] = [loaded.picture.rows, rows].map((list) => list.map((x) => 255 * encode(clamp(x * exposure))));
    let sum = 0;
    const count = { within: 0, inside: 0, insidePixels: 0 };
    for (let y = 0; y < height; ++y)
        for (let x = 0; x < width; ++x) {
            const at = 3 * (y * width + x);
            const d = [0, 1, 2].map((c) => Math.abs(ours[at + c] - theirs[at + c]));
            sum += d[0] + d[1] + d[2];
            const near = Math.max(...d) <= 1;
            if (near) count.within += 1;
            if (x === 0 || y === 0 || x === width - 1 || y === height - 1) continue;
            const around = [-1, 0, 1].flatMap((v) => [-1, 0, 1].map((u) => at + 3 * (v * width + u)));
            if (!around.every((i) => [0, 1, 2].every((c) => Math.abs(theirs[i + c] - theirs[at + c]) <= 6))) continue;
            count.insidePixels += 1;
            if (near) count.inside += 1;
        }
    return { mean: sum / rows.length, within: count.within / (width * height), inside: count.inside / count.insidePixels, insidePixels: count.insidePixels };
}

/** Linear values where the picture shows points of the world, and the points of those pixels' centres at that height. */
async function atPoints({ points, camera }) {
    const { width, height, rows } = loaded.picture;
    const view = viewOf(camera, width / height);
    return points.map((p) => {
        const ndc = new THREE.Vector3().fromArray(p).project(view);
        const x = Math.floor((ndc.x * 0.5 + 0.5) * width);
        const y = Math.floor((0.5 - ndc.y * 0.5) * height);
        const ray = new THREE.Vector3(((x + 0.5) / width) * 2 - 1, 1 - ((y + 0.5) / height) * 2, 0.5).unproject(view).sub(view.position);
        const at = view.position.clone().addScaledVector(ray, (p[1] - view.position.y) / ray.y);
        return { value: [...rows.subarray(3 * (y * width + x), 3 * (y * width + x) + 3)], at: at.toArray() };
    });
}

/** Puts objects of the application in the place of the file's dynamic ones. */
async function replaceDynamic() {
    const dynamic = loaded.halflight.objects.filter((object) => !object.isStatic);
    for (const { meshes } of dynamic)
        for (const mesh of meshes) {
            const own = new THREE.Mesh(mesh.geometry.clone(), new THREE.MeshStandardMaterial({ color: mesh.material.color, roughness: mesh.material.roughness, metalness: mesh.material.metalness }));
            mesh.matrixWorld.decompose(own.position, own.quaternion, own.scale);
            own.castShadow = own.receiveShadow = true;
            mesh.visible = false;
            loaded.scene.add(own);
            loaded.halflight.add(own);
        }
    return dynamic.length;
}

const lightNames = async () => loaded.halflight.lights.map((l) => l.name);
const intensityOf = async ({ index }) => loaded.halflight.lights[index].light.intensity;

async function changeLight({ index, intensity, strength }) {
    const state = loaded.halflight.lights[index];
    state.light.intensity *= intensity;
    state.shadowStrength = strength;
}

async function moveLight({ index, by }) {
    loaded.halflight.lights[index].light.position.add(new THREE.Vector3(...by));
}

/** What the plug-in may change, as text. */
function stateOf(scene) {
    const result = [];
    scene.traverse((o) => {
        const entry = [o.name, o.type, o.castShadow, o.receiveShadow, o.layers.mask, o.visible];
        if (o.isMesh) entry.push(Object.keys(o.geometry.attributes).join(), o.material.shadowSide, ...['onBeforeCompile', 'customProgramCacheKey', 'setupLightingModel', 'setupOutput', 'contextNode', 'halflight'].filter((name) => Object.hasOwn(o.material, name)));
        if (o.isLight) entry.push(o.intensity, o.distance, Object.keys(o.shadow?.getFrustum() ?? {}).join(), JSON.stringify(o.shadow?.toJSON(), (key, value) => (key === 'up' ? 0 : value))); // three.js turns point lights' cameras
        result.push(entry.join(' '));
    });
    return result;
}

async function disposeTest({ file, width, height, camera }) {
    await load({ file });
    const { scene, halflight } = loaded;
    const plain = { update() {}, warnings: [] };
    const own = new THREE.DirectionalLight(0xffffff, 0.1); // the application's, with three.js's shadow map
    own.castShadow = true;
    scene.add(own);
    const before = stateOf(scene);
    const drawWith = async (object) => {
        loaded.halflight = object;
        await draw({ width, height, camera });
        return loaded.picture.rows;
    };
    const first = await drawWith(plain);
    const withPlugin = await drawWith(halflight);
    const ownSize = own.shadow.map.width;
    halflight.dispose();
    const after = stateOf(scene);
    scene.traverse((o) => Object.hasOwn(o, 'onBeforeRender') && after.push(`${o.name} has onBeforeRender`));
    const last = await drawWith(plain);
    const mean = (a, b) => a.reduce((sum, x, i) => sum + Math.abs(x - b[i]), 0) / a.length;
    loaded.halflight = null;
    return {
        changed: after.flatMap((line, i) => (line === before[i] ? [] : [`${before[i]} -> ${line}`])),
        largest: last.reduce((m, x, i) => Math.max(m, Math.abs(x - first[i])), 0),
        withPlugin: mean(withPlugin, first),
        ownSize,
    };
}

async function sentences() {
    let sentence = '';
    try {
        loaded.halflight.mode = 'subtractive';
    } catch (error) {
        sentence = error.message;
    }
    const json = { asset: { version: '2.0' }, scenes: [{}], scene: 0 };
    const loader = new GLTFLoader();
    loader.register((parser) => new HalflightPlugin(parser));
    const plain = await loader.parseAsync(JSON.stringify(json), '');
    return [sentence, plain.userData.halflight];
}

/** Radiance that three.js gives white quads in a LightProbeGrid made of the file's probes, and what the probes say. */
async function probeGrid({ file, module, resolution }) {
    await load({ file });
    const renderer = await makeRenderer(64, 64);
    const Grid = (await import(`three/addons/lighting/${module}.js`))[module];
    const grid = loaded.halflight.toLightProbeGrid(Grid, { resolution });
    const scene = new THREE.Scene();
    const quad = new THREE.Mesh(new THREE.PlaneGeometry(0.02, 0.02), new THREE.MeshLambertMaterial());
    scene.add(grid, quad);
    const target = new (THREE.WebGLRenderTarget ?? THREE.RenderTarget)(4, 4, { type: THREE.FloatType });
    const camera = new THREE.OrthographicCamera(-0.005, 0.005, 0.005, -0.005, 0.001, 1);
    const n = grid.resolution.toArray();
    const spacing = grid.getProbePosition(1, 1, 1, new THREE.Vector3()).sub(grid.getProbePosition(0, 0, 0, new THREE.Vector3()));
    const result = [];
    const normals = [[0, 1, 0], [0, -1, 0], [1, 0, 0], [0, 0.6, -0.8]];
    for (let i = 0; i < 12; ++i) {
        const normal = new THREE.Vector3(...normals[i % 4]);
        const index = n.map((count, axis) => (5 * i + 3 * axis) % count);
        const probe = grid.getProbePosition(...index, new THREE.Vector3());
        quad.position.copy(probe).sub(normal.clone().multiply(spacing).multiplyScalar(0.5)); // three.js looks half a cell in front of surfaces
        quad.lookAt(quad.position.clone().add(normal));
        camera.position.copy(quad.position).addScaledVector(normal, 0.1);
        camera.up.set(0, Math.abs(normal.y) > 0.9 ? 0 : 1, Math.abs(normal.y) > 0.9 ? 1 : 0);
        camera.lookAt(quad.position);
        renderer.setRenderTarget(target);
        renderer.render(scene, camera);
        const pixels = await read(renderer, target, 4, 4);
        const { radiance } = loaded.halflight.field.sample(probe.toArray());
        const irradiance = [0, 1, 2].map((c) => radiance.reduce((sum, x, k) => sum + (k % 3 === c ? x * shIrradianceWeight((k - c) / 3, normal) : 0), 0));
        result.push({ index, drawn: [...pixels.slice(20, 23)], exact: irradiance.map((e) => Math.max(e, 0) / Math.PI) });
    }
    renderer.setRenderTarget(null);
    target.dispose();
    return { resolution: n, result };
}

const toneMapping = async (pictures) => differenceFrom(await makeRenderer(160, 90), read, pictures);
const evaluateCases = async (functions) => evaluate(await makeRenderer(64, 64), read, functions, kind === 'webgl2-nodes');

window.halflightTest = { put: async (where) => put(loaded, where), evaluate: evaluateCases, toneMapping, probeGrid, load, draw, compare, picture, agreement, atPoints, replaceDynamic, lightNames, intensityOf, changeLight, moveLight, disposeTest, frameCost: async (options) => frameCost(window.halflightPage, options), sentences };
/** For tests that are functions of their own. */
window.halflightPage = { THREE, GLTFLoader, HalflightPlugin, loaded, load, draw, makeRenderer, viewOf, readPixels: read };
window.ready = true;

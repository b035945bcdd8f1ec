// The viewer page: a baked file, its modes, lights and views.
import * as THREE from 'three';
import { HalflightPlugin, VIEWS } from '@halflight/three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

import { Flight } from './flight.js';
import { readLink, writeLink } from './link.js';
import { showLights, showModes, showStatistics } from './panel.js';

const SHOWCASE = 'courtyard-baked.glb';
const element = (id) => document.getElementById(id);

const renderer = new THREE.WebGLRenderer({ canvas: element('picture'), antialias: true });
renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
renderer.shadowMap.enabled = true;
renderer.toneMapping = THREE.NeutralToneMapping; // as the program's displayed pictures

const camera = new THREE.PerspectiveCamera(52, 1, 0.05, 1000);
const orbit = new OrbitControls(camera, renderer.domElement);
const flight = new Flight(camera, orbit, redraw);
const scene = new THREE.Scene();
/** @type {{gltf: any, halflight: any, bytes: number} | null} */
let shown = null;
let requested = false;
let trouble = '';
let opened = 0; // files that were chosen: only the last one is shown, even where an earlier one takes longer to read

/** One frame is drawn for all changes before it; no frame is requested while nothing changes. */
function redraw() {
    if (requested) return;
    requested = true;
    requestAnimationFrame(draw);
}

function draw(time) {
    requested = false;
    flight.move(time);
    if (!shown) return;
    const start = performance.now();
    shown.halflight.update(renderer, camera);
    renderer.render(scene, camera);
    showStatistics(element('statistics'), shown, renderer, (performance.now() - start) / 1000);
    say();
    document.body.dataset.frames = String(Number(document.body.dataset.frames ?? 0) + 1);
}

function resize() {
    renderer.setSize(innerWidth, innerHeight, false);
    camera.aspect = innerWidth / innerHeight;
    camera.updateProjectionMatrix();
    redraw();
}

/** What is wrong with the last file, and what the one that is shown leaves out. */
function say(sentence = trouble) {
    trouble = sentence;
    element('message').textContent = [trouble, ...(shown?.halflight.warnings ?? [])].filter(Boolean).join(' ');
}

/** @param {Promise<ArrayBuffer>} reading */
async function open(reading, name) {
    const turn = ++opened;
    say('');
    try {
        const bytes = await reading;
        const loader = new GLTFLoader();
        loader.setMeshoptDecoder(MeshoptDecoder);
        loader.register((parser) => new HalflightPlugin(parser));
        const gltf = await loader.parseAsync(bytes, '');
        const halflight = gltf.userData.halflight;
        if (!halflight) throw new Error('the file is not baked: halflight bake makes a baked one of it');
        if (turn === opened) show(gltf, bytes.byteLength, name);
        else halflight.dispose();
    } catch (error) {
        if (turn === opened) say(`${name}: ${error.message}`);
    }
    redraw();
}

function show(gltf, size, name) {
    shown?.halflight.dispose();
    shown?.gltf.scene.removeFromParent();
    shown = { gltf, halflight: gltf.userData.halflight, bytes: size };
    scene.add(gltf.scene);
    element('file').textContent = name;
    fillPanel();
}

function fillPanel() {
    const { gltf, halflight } = shown;
    element('controls').hidden = false;
    showModes(element('modes'), halflight, redraw);
    showLights(element('lights'), halflight, redraw);
    element('view').replaceChildren(...VIEWS.map((view) => new Option(view, view)));
    const cameras = gltf.cameras.length > 0 ? gltf.cameras : [null];
    element('camera').replaceChildren(...cameras.map((c, i) => new Option(c?.name || c?.parent?.name || 'whole scene', String(i))));
    useCamera(0);
    readLink(location.hash, { halflight, camera, orbit, renderer });
    syncPanel();
}

/** Controls show what the scene has. */
function syncPanel() {
    const { halflight } = shown;
    const set = (id, value, text) => {
        element(id).value = value;
        element(`${id}Value`).textContent = text;
    };
    set('distance', halflight.shadowDistance, `${halflight.shadowDistance} m`);
    set('fade', halflight.shadowFadeRange, `${halflight.shadowFadeRange} m`);
    const ev = -Math.log2(renderer.toneMappingExposure);
    set('exposure', ev, `${ev.toFixed(2)} EV`);
    element('view').value = halflight.debugView;
    for (const radio of element('modes').querySelectorAll('input')) radio.checked = radio.value === halflight.mode;
}

function useCamera(index) {
    const from = shown.gltf.cameras[index];
    const box = shown.halflight.bounds;
    if (from) {
        from.updateWorldMatrix(true, false);
        from.matrixWorld.decompose(camera.position, camera.quaternion, new THREE.Vector3());
        camera.fov = from.fov ?? 52;
    } else {
        const size = box.getSize(new THREE.Vector3()).length();
        camera.position.copy(box.getCenter(new THREE.Vector3())).add(new THREE.Vector3(0.4, 0.35, 0.6).multiplyScalar(size));
        camera.lookAt(box.getCenter(new THREE.Vector3()));
    }
    const reach = Math.max(box.getSize(new THREE.Vector3()).length() * 0.2, 1);
    orbit.target.copy(camera.getWorldDirection(new THREE.Vector3())).multiplyScalar(reach).add(camera.position);
    camera.updateProjectionMatrix();
    orbit.update();
    redraw();
}

function onInput(id, apply) {
    element(id).addEventListener('input', (event) => {
        apply(event.target.value);
        syncPanel();
        redraw();
    });
}

onInput('distance', (value) => (shown.halflight.shadowDistance = Number(value)));
onInput('fade', (value) => (shown.halflight.shadowFadeRange = Number(value)));
onInput('exposure', (value) => (renderer.toneMappingExposure = 2 ** -Number(value)));
onInput('view', (value) => (shown.halflight.debugView = value));
onInput('camera', (value) => useCamera(Number(value)));
element('link').addEventListener('click', async () => {
    history.replaceState(null, '', `#${writeLink({ halflight: shown.halflight, camera, orbit, renderer })}`); // no hashchange
    await navigator.clipboard?.writeText(location.href).catch(() => {});
});
element('open').addEventListener('change', (event) => {
    const [file] = event.target.files;
    if (file) open(file.arrayBuffer(), file.name);
});
addEventListener('hashchange', () => {
    if (!shown) return;
    readLink(location.hash, { halflight: shown.halflight, camera, orbit, renderer });
    syncPanel();
    redraw();
});
addEventListener('dragover', (event) => {
    event.preventDefault();
    document.body.classList.add('dropping');
});
addEventListener('dragleave', () => document.body.classList.remove('dropping'));
addEventListener('drop', (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    const [file] = event.dataTransfer.files;
    if (file) open(file.arrayBuffer(), file.name);
});
orbit.addEventListener('change', redraw);
element('picture').addEventListener('webglcontextrestored', redraw);
addEventListener('resize', resize);
resize();
element('panel').open = innerWidth > 640; // else it hides most of the picture

const wanted = new URLSearchParams(location.search).get('file') ?? SHOWCASE;
const response = await fetch(wanted).catch(() => null);
if (response?.ok) open(response.arrayBuffer(), wanted);
else element('file').textContent = 'no file open';

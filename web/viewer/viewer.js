// The viewer page: opens files, and wires the picture, the camera, the panel and the address.
import { Vector3 } from 'three';
import { VIEWS } from '@halflight/three';

import { Bakery } from './bake.js';
import { Divider } from './divider.js';
import { chosenFiles, droppedFiles, load, sourceOfAddress, sourceOfFiles } from './files.js';
import { Keys } from './keys.js';
import { parametersOf, readLink, writeLink } from './link.js';
import { Orbit } from './orbit.js';
import { showGroups, showLegend, showLights, showModes, showNotes, showStatistics } from './panel.js';
import { Stage } from './stage.js';
import { MODE_SENTENCES } from './views.js';

await window.halflightIsolating; // isolate.js may load the page again: no file is taken before

const SHOWCASE = 'courtyard-baked.glb';
const element = (id) => document.getElementById(id);

/** What is wrong: with the last file that was chosen, or with the browser. @param {string} sentence */
function complain(sentence) {
    element('message').textContent = sentence;
}

function startStage() {
    try {
        return new Stage(element('picture'), { beforeFrame: (time) => keys.move(time), afterFrame, failed });
    } catch {
        complain('This browser has no WebGL 2, or it is switched off: no picture can be drawn.');
        throw new Error('no WebGL 2');
    }
}

const stage = startStage();
const { camera, renderer } = stage;
const redraw = () => stage.redraw();
const orbit = new Orbit(camera, renderer.domElement, () => stage.shown?.gltf.scene ?? null, redraw);
const keys = new Keys(orbit, redraw, actions());
const divider = new Divider((part) => {
    stage.split = part;
    redraw();
});
const bakery = new Bakery({ started: () => complain(''), failed: complain, baked: showBaked });
let plain = null; // the file that the bakery bakes, where it can be shown
let showWeights = () => {}; // of light groups, in the panel
let odd = []; // sentences about parameters of the address
let opened = 0; // files that were chosen: only the last one is shown, even where an earlier one takes longer to read
let wanted = ''; // the part of the address that says what is open

function afterFrame(seconds) {
    showStatistics(element('statistics'), stage.shown, stage.drawn, seconds);
    notes();
    syncExposure();
    showWeights();
    if (stage.shown?.halflight.isFollowing) redraw();
}

function failed(error) {
    complain(`The file cannot be drawn: ${error.message}.`);
    close();
}

function close() {
    showWeights = () => {};
    element('controls').hidden = true;
    divider.show(false);
    element('file').textContent = 'no file open';
    notes();
}

function notes() {
    const lacks = stage.shown?.missing.map((name) => `${name} is missing: what it holds is not shown.`) ?? [];
    const sentences = [...(stage.shown?.halflight.warnings ?? [])].map(
        (sentence) => `${sentence[0].toUpperCase()}${sentence.slice(1)}.`
    );
    const dark = stage.shown?.isPlain && stage.shown.halflight.lights.length === 0;
    const lights = dark ? [`${stage.shown.name} has no lights: what does not glow is black.`] : [];
    showNotes(element('notes'), [...odd, ...lacks, ...lights, ...sentences]);
}

/** @param {import('./files.js').Source} source @param {boolean} isLinked whether the address is about it */
async function open(source, isLinked) {
    const turn = ++opened;
    const last = element('file').textContent;
    complain('');
    bakery.cancel();
    try {
        const progress = (bytes) =>
            turn === opened && (element('file').textContent = `loading ${source.name}, ${(bytes / 1e6).toFixed(1)} MB`);
        progress(0);
        const file = await load(source, progress);
        if (turn !== opened) return file.halflight.dispose();
        plain = file.isPlain ? file : null;
        bakery.offer(file.isPlain ? source : null);
        show(file, isLinked ? parametersOf(location) : new Map());
    } catch (error) {
        if (turn !== opened) return;
        if (error.isPlain) {
            plain = null;
            stage.show(null);
            close();
            bakery.offer(source);
            element('file').textContent = source.name;
            return complain(`${error.message}.`);
        }
        element('file').textContent = stage.shown?.name ?? (last.startsWith('loading') ? 'no file open' : last);
        complain(`${error.message}.`);
    }
}

/** Shows what a bake made beside what it was, from where the camera is. @param {Uint8Array<ArrayBuffer>} glb */
async function showBaked(glb, name) {
    const turn = ++opened;
    const file = await load(sourceOfFiles([{ path: name, file: new File([glb], name) }]), () => {});
    if (turn !== opened) return file.halflight.dispose();
    const view = new Map(plain ? new URLSearchParams(writeLink(viewOfPage())) : []);
    for (const key of ['mode', 'exposure']) view.delete(key);
    nameFile(name);
    show(file, view, plain);
}

function show(file, parameters, before = null) {
    stage.show(file, before);
    divider.show(before !== null);
    element('file').textContent = file.name;
    element('controls').hidden = false;
    element('copied').textContent = '';
    const { gltf, halflight } = file;
    keys.speed = Math.min(Math.max(0.12 * halflight.bounds.getSize(new Vector3()).length(), 0.3), 30);
    showModes(element('modes'), halflight, setMode);
    element('groupsSection').hidden = halflight.lightGroups.length === 0;
    showWeights = showGroups(element('groups'), halflight, redraw);
    showLights(element('lights'), halflight, redraw);
    file.cameras = [
        ...gltf.cameras.map((from, i) => ({ from, name: from.name || from.parent?.name || `camera ${i + 1}` })),
        { from: null, name: 'whole scene' },
    ];
    element('view').replaceChildren(...VIEWS.map((view) => new Option(view, view)));
    element('camera').replaceChildren(...file.cameras.map(({ name }, i) => new Option(name, String(i))));
    useCamera(0);
    follow(parameters);
}

const viewOfPage = () => ({
    halflight: stage.shown.halflight,
    camera,
    orbit,
    cameras: stage.shown.cameras,
    useCamera,
    exposure: stage.exposure,
    expose: (ev) => stage.expose(ev),
});

/** Shows the view of a link. @param {Map<string, string>} parameters */
function follow(parameters) {
    odd = readLink(parameters, viewOfPage());
    camera.updateProjectionMatrix();
    orbit.about(orbit.target);
    syncPanel();
    redraw();
}

function useCamera(index) {
    const { halflight, cameras } = stage.shown;
    const { from } = cameras[index];
    const size = halflight.bounds.getSize(new Vector3()).length();
    camera.fov = from?.fov ?? 52;
    if (from) {
        orbit.take(from, Math.max(0.2 * size, 0.1));
    } else {
        const middle = halflight.bounds.getCenter(new Vector3());
        const distance = (0.5 * size) / Math.sin((0.5 * camera.fov * Math.PI) / 180) / Math.min(camera.aspect, 1);
        orbit.place(new Vector3(0.49, 0.43, 0.74).normalize().multiplyScalar(distance).add(middle), middle);
    }
    element('camera').value = String(index);
    camera.updateProjectionMatrix();
    stage.exposeAutomatically();
    redraw();
}

function setMode(mode) {
    stage.shown.halflight.mode = mode;
    syncPanel();
    redraw();
}

/** Controls show what the scene has. */
function syncPanel() {
    const { halflight } = stage.shown;
    for (const [id, value] of [
        ['distance', halflight.shadowDistance],
        ['fade', halflight.shadowFadeRange],
    ]) {
        element(id).value = value;
        element(`${id}Value`).textContent = `${value} m`;
    }
    element('view').value = halflight.debugView;
    for (const radio of element('modes').querySelectorAll('input')) radio.checked = radio.value === halflight.mode;
    element('modeSentence').textContent = MODE_SENTENCES[halflight.mode];
    showLegend(element('legend'), halflight);
    syncExposure();
}

function syncExposure() {
    element('exposure').value = stage.exposure;
    element('exposureValue').textContent = `${stage.exposure.toFixed(2)} EV${stage.isAutomatic ? ', automatic' : ''}`;
}

function onInput(id, apply) {
    element(id).addEventListener('input', (event) => {
        apply(event.target.value);
        syncPanel();
        redraw();
    });
}

/** What single keys do, by their code. */
function actions() {
    const chosen = (act) => () => stage.shown && act();
    const all = {
        KeyV: chosen(() => setView(VIEWS[(VIEWS.indexOf(stage.shown.halflight.debugView) + 1) % VIEWS.length])),
        KeyF: chosen(() => useCamera(stage.shown.cameras.length - 1)),
        KeyX: chosen(() => exposeAutomatically()),
    };
    for (let i = 0; i < 5; ++i)
        all[`Digit${i + 1}`] = chosen(() => stage.shown.halflight.modes[i] && setMode(stage.shown.halflight.modes[i]));
    return all;
}

function setView(name) {
    stage.shown.halflight.debugView = name;
    syncPanel();
    redraw();
}

function exposeAutomatically() {
    stage.exposeAutomatically();
    redraw();
}

/** @param {string} text @param {string} what was copied */
async function copy(text, what) {
    const copied = await navigator.clipboard?.writeText(text).then(
        () => true,
        () => false
    );
    element('copied').textContent = copied
        ? `${what} was copied.`
        : `The browser lets no page copy here. Copy it yourself: ${text}`;
}

/** The address of this view; of a file without an address it has the name, and whoever follows it opens the file. */
function addressOfView() {
    const { local } = Object.fromEntries(parametersOf(location));
    const hash = writeLink(viewOfPage());
    const url = new URL(location.href);
    for (const name of [...url.searchParams.keys()]) if (name !== 'file') url.searchParams.delete(name);
    url.hash = local ? `${new URLSearchParams({ local })}&${hash}` : hash;
    return url;
}

function embedCode() {
    const url = addressOfView();
    url.searchParams.set('panel', 'none');
    const title = stage.shown.name.replaceAll(/[&"<]/g, '');
    const source = url.href.replaceAll('&', '&amp;');
    return `<iframe src="${source}" title="${title}" width="960" height="540" style="border: 0"></iframe>`;
}

/** The address tells of a file of this computer from now on. @param {string} name */
function nameFile(name) {
    const url = new URL(location.href);
    url.searchParams.delete('file');
    url.hash = new URLSearchParams({ local: name }).toString();
    history.replaceState(null, '', url);
    wanted = keyOf(parametersOf(location));
}

/** Files of a drop or a choice. @param {{path: string, file: File}[]} files */
function openFiles(files) {
    const source = sourceOfFiles(files);
    if (!source) return;
    const { local } = Object.fromEntries(parametersOf(location));
    const isLinked = local === source.name && stage.shown === null; // the file that a link asked for
    if (!isLinked) nameFile(source.name);
    open(source, isLinked);
}

const keyOf = (parameters) => JSON.stringify([parameters.get('file'), parameters.get('local')]);

/** Opens what the address names, or shows its view of what is open. */
function route() {
    const parameters = parametersOf(location);
    if (keyOf(parameters) === wanted) {
        if (stage.shown) follow(parameters);
        return;
    }
    wanted = keyOf(parameters);
    const local = parameters.get('local');
    if (local === undefined) return open(sourceOfAddress(parameters.get('file') || SHOWCASE), true);
    ++opened;
    plain = null;
    stage.show(null);
    close();
    bakery.offer(null);
    element('file').textContent = `The link shows ${local}, a file of another place: open it, or drop it.`;
}

onInput('distance', (value) => (stage.shown.halflight.shadowDistance = Number(value)));
onInput('fade', (value) => (stage.shown.halflight.shadowFadeRange = Number(value)));
onInput('exposure', (value) => stage.expose(Number(value)));
onInput('view', setView);
onInput('camera', (value) => useCamera(Number(value)));
element('saved').addEventListener('click', () => {
    const { halflight } = stage.shown;
    for (const { name, savedWeight } of halflight.lightGroups) halflight.setLightGroup(name, savedWeight);
    redraw();
});
element('automatic').addEventListener('click', exposeAutomatically);
element('link').addEventListener('click', () => {
    const url = addressOfView();
    history.replaceState(null, '', url); // no hashchange
    copy(url.href, 'The link');
});
element('embed').addEventListener('click', () => copy(embedCode(), 'The code'));
for (const id of ['open', 'folder'])
    element(id).addEventListener('change', (event) => {
        openFiles(chosenFiles(event.target.files));
        event.target.value = ''; // the same file may be chosen again
    });
addEventListener('hashchange', route);
addEventListener('dragover', (event) => {
    event.preventDefault();
    document.body.classList.add('dropping');
});
addEventListener('dragleave', () => document.body.classList.remove('dropping'));
addEventListener('drop', async (event) => {
    event.preventDefault();
    document.body.classList.remove('dropping');
    openFiles(await droppedFiles(event.dataTransfer));
});
element('picture').addEventListener('webglcontextlost', () =>
    complain('The graphics driver has stopped. The picture comes back when it starts again.')
);
element('picture').addEventListener('webglcontextrestored', () => complain(''));

const panel = parametersOf(location).get('panel');
document.body.classList.toggle('bare', panel === 'none');
element('panel').open = panel ? panel === 'open' : innerWidth > 640; // on a phone it would hide much of the picture
route();

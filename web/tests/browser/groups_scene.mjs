// The scene of light groups with what it lacks: objects that move, one with a proxy volume. Its bake has several pages.
import { join } from 'node:path';

import { readGlb, writeGlb } from '../glb.mjs';
import { halflight, repository } from '../harness.mjs';
import { studio } from './studio.mjs';

const POST = 12; // mesh

/** @param {{onePage?: boolean, plain?: boolean}} [options] plain: without reflection probes and objects that move @returns {string} name of the baked file */
export function bakeGroups({ onePage = false, plain = false } = {}) {
    const name = `light-groups${onePage ? '-of-one-page' : ''}${plain ? '-plain' : ''}`;
    if (studio.baked.has(name)) return name;
    const file = readGlb(join(repository, 'assets/tests/light_groups.glb'));
    const [scene] = file.json.scenes;
    const add = (node, translation, extras) => scene.nodes.push(file.json.nodes.push({ name: node, mesh: POST, translation, extras: { halflight_static: 0, ...extras } }) - 1);
    if (!plain) add('mover', [-1.6, 0.3, 0.7], {});
    if (!plain) add('volume', [-2.6, 0.2, -0.6], { halflight_probes: 'volume', halflight_probe_resolution: 18 }); // of more texels than a frame relights
    const source = join(studio.files, 'light-groups-source.glb');
    writeGlb(source, file);
    const options = ['--quality', 'preview', '--directional', 'on', '--texels-per-meter', onePage ? '4' : '6', '--lightmap-size', onePage ? '128' : '96', '--probe-layout', 'grid', '--probe-spacing', '1', '--samples', '16', '--reflection-probes', plain ? 'off' : 'on'];
    halflight('bake', source, '-o', studio.pathOf(name), ...options, '-q');
    studio.baked.add(name);
    return name;
}

/** States by name: weights by group. */
export const STATES = {
    saved: {},
    'all off': { lamp: [0, 0, 0], sun: [0, 0, 0], west: [0, 0, 0], east: [0, 0, 0], day: [0, 0, 0] },
    'a white lamp alone': { lamp: [1, 1, 1], sun: [0, 0, 0], west: [0, 0, 0], east: [0, 0, 0], day: [0, 0, 0] },
    'a bright evening': { lamp: [2, 3, 9], sun: [0, 0, 0], west: [0.1, 0.2, 0], east: [0, 0, 0], day: [0.02, 0.05, 0.3] },
};

/** Options of `render` and `compose`. */
export const optionsOf = (state) => Object.entries(state).flatMap(([name, rgb]) => ['--group', `${name}=${rgb.join(',')}`]);

/** A composed file of a state. @returns {string} its name */
export function compose(name, label) {
    const composed = `${name}-${label.replaceAll(' ', '-')}`;
    if (!studio.baked.has(composed)) halflight('compose', studio.pathOf(name), '-o', studio.pathOf(composed), '-q', ...optionsOf(STATES[label]));
    studio.baked.add(composed);
    return composed;
}

/** Gives the page's file weights, and draws until all its light has them. */
export const setGroups = (page, state) =>
    page.evaluate(async (weights) => {
        const { loaded, makeRenderer, viewOf } = window.halflightPage;
        const { halflight } = loaded;
        for (const { name, savedWeight } of halflight.lightGroups) halflight.setLightGroup(name, weights[name] ?? savedWeight);
        const renderer = await makeRenderer(32, 18);
        const frame = () => halflight.update(renderer, viewOf('main', 16 / 9));
        for (frame(); halflight.isFollowing; ) frame();
    }, state);

/** Bakes a test scene after a change of its document. @param {(json: any) => void} change @returns {string} name of the baked file */
export function bakeChanged(name, scene, change, ...options) {
    if (studio.baked.has(name)) return name;
    const file = readGlb(join(repository, `assets/tests/${scene}.glb`));
    change(file.json);
    writeGlb(studio.pathOf(`${name}-source`), file);
    halflight('bake', studio.pathOf(`${name}-source`), '-o', studio.pathOf(name), '--quality', 'preview', '-q', ...options);
    studio.baked.add(name);
    return name;
}

/** The rooms of metal under a sky that changes: reflection probes have most of their light. */
export const bakeMetal = () =>
    bakeChanged('metal-under-a-sky', 'light_groups', ({ scenes, materials }) => {
        const { extras } = scenes[0];
        delete extras.halflight_sky_group;
        extras.halflight_sky_changes = 1;
        for (const material of materials) Object.assign((material.pbrMetallicRoughness ??= {}), { metallicFactor: 1, roughnessFactor: 0.3 });
    }, '--directional', 'on', '--texels-per-meter', '5', '--probe-spacing', '1.3', '--samples', '16', '--reflection-probes', 'on');

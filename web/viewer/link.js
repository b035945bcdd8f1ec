// A view as parameters of the address: camera, mode, shadows, exposure, debug view. They stand in the fragment (a link)
// or before it (an embedded page). The fragment goes first.
import { Vector3 } from 'three';
import { VIEWS } from '@halflight/three';

/** Parameters of the page itself: what it opens, and how much of its panel it shows. */
export const PAGE = ['file', 'local', 'panel'];
const MOST_METERS = 1e6;
const MOST_WEIGHT = 1e12;

const numbers = (list) => list.map((x) => Number(x.toFixed(3))).join(',');

/** Weights of the light groups in their order, where one is not that of the file. */
function weightsOf({ lightGroups: groups }) {
    if (groups.every(({ weight, savedWeight }) => weight.every((x, c) => x === savedWeight[c]))) return {};
    return { weights: groups.flatMap(({ weight }) => weight.map((x) => Number(x.toPrecision(4)))).join(',') };
}

export function writeLink({ halflight, camera, orbit, exposure }) {
    return new URLSearchParams({
        eye: numbers(camera.position.toArray()),
        target: numbers(orbit.target.toArray()),
        fov: numbers([camera.fov]),
        mode: halflight.mode,
        view: halflight.debugView,
        distance: numbers([halflight.shadowDistance]),
        fade: numbers([halflight.shadowFadeRange]),
        exposure: numbers([exposure]),
        ...weightsOf(halflight),
    }).toString();
}

/** All parameters of an address. @param {Location | URL} address */
export function parametersOf({ search, hash }) {
    return new Map([...new URLSearchParams(search), ...new URLSearchParams(hash.slice(1))]);
}

/** `count` numbers from `least` to `most`, or null. */
function read(text, count, least, most) {
    const list = text.split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
    return list.length === count && list.every((x) => x >= least && x <= most) ? list : null;
}

/** By name: what it takes, in words, and what it does; null where the text is none of that. */
const PARAMETERS = {
    camera: {
        takes: ({ cameras }) => `one of ${cameras.map(({ name }) => name).join(', ')}`,
        set: (text, { cameras, useCamera }) => {
            const index = cameras.findIndex(({ name }) => name === text);
            return index < 0 ? null : (useCamera(index), true);
        },
    },
    mode: {
        takes: ({ halflight }) => `one of ${halflight.modes.join(', ')}`,
        set: (text, { halflight }) => (halflight.modes.includes(text) ? ((halflight.mode = text), true) : null),
    },
    view: {
        takes: () => `one of ${VIEWS.join(', ')}`,
        set: (text, { halflight }) => (VIEWS.includes(text) ? ((halflight.debugView = text), true) : null),
    },
    weights: {
        takes: ({ halflight }) => `${3 * halflight.lightGroups.length} numbers from 0 on, three for each light group`,
        set: (text, { halflight }) => {
            const groups = halflight.lightGroups;
            const list = read(text, 3 * groups.length, 0, MOST_WEIGHT);
            if (list === null || groups.length === 0) return null;
            groups.forEach(({ name }, i) => halflight.setLightGroup(name, list.slice(3 * i, 3 * i + 3)));
            return true;
        },
    },
    fov: number('from 1 to 170 degrees', 1, 170, (x, { camera }) => (camera.fov = x)),
    distance: number('of metres from 0 on', 0, MOST_METERS, (x, { halflight }) => (halflight.shadowDistance = x)),
    fade: number('of metres from 0 on', 0, MOST_METERS, (x, { halflight }) => (halflight.shadowFadeRange = x)),
    exposure: number('of stops from -24 to 24', -24, 24, (x, view) => view.expose(x)),
    eye: point('eye', 'target', (eye, target, { orbit }) => orbit.place(eye, target)),
    target: point('target', 'eye', () => true), // with eye
};

function number(words, least, most, set) {
    return {
        takes: () => `a number ${words}`,
        set: (text, view) => (read(text, 1, least, most) ? (set(Number(text), view), true) : null),
    };
}

/** A camera has both an eye and a target. */
function point(own, other, set) {
    const three = (text) => read(text ?? '', 3, -MOST_METERS, MOST_METERS);
    const takes = () => `three numbers, beside ${other}`;
    return {
        takes,
        set: (text, view, parameters) => {
            const points = { [own]: three(text), [other]: three(parameters.get(other)) };
            if (!points.eye || !points.target || points.eye.join() === points.target.join()) return null;
            return (set(new Vector3(...points.eye), new Vector3(...points.target), view), true);
        },
    };
}

/**
 * What a link lacks, or has wrong, stays as it is. @param {Map<string, string>} parameters
 * @param {{halflight: any, camera: any, orbit: any, cameras: {name: string}[], useCamera: (index: number) => void,
 *     expose: (ev: number) => void}} view
 * @returns {string[]} a sentence for each parameter that was left out
 */
export function readLink(parameters, view) {
    const odd = [];
    for (const [name, { takes, set }] of Object.entries(PARAMETERS)) {
        const text = parameters.get(name);
        if (text !== undefined && set(text, view, parameters) === null)
            odd.push(`The address has ${name}=${text}, which is left out: it takes ${takes(view)}.`);
    }
    for (const name of parameters.keys())
        if (!PARAMETERS[name] && !PAGE.includes(name))
            odd.push(`The address has ${name}, which is left out: no parameter has this name.`);
    return odd;
}

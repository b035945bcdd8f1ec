// The state of light groups: one weight each, which lights, emission and the sky follow.
import { CHANGED } from '../scene/lights.js';
import { checkNumber } from '../scene/warnings.js';
import { Turning } from './turning.js';

/** As docs/format.md has the range of weights. */
const MOST = 1e12;

/** Degrees between directions of a bake from which on bounced light is off, as kMostStepRadians of turning_lights.h. */
const MOST_STEP = 20.1;

const equal = (a, b) => a.every((x, c) => x === b[c]);
const apart = (a, b) => Math.max(...a.map((x, c) => Math.abs(x - b[c])));

/** A weight as three numbers. @param {number | number[] | {r: number, g: number, b: number}} color */
function rgbOf(name, color) {
    const list = color?.isColor ? [color.r, color.g, color.b] : typeof color === 'number' ? [color, color, color] : color;
    if (!Array.isArray(list) || list.length !== 3) throw new Error(`the weight of light group "${name}" is ${color}: it is a number, a colour or three numbers`);
    return list.map((x) => checkNumber(`the weight of light group "${name}"`, x, '', 0, MOST));
}

/** A colour of at most 1 with an intensity that stays where it can, as setColorIntensity() in src/render/frame/group_members.cpp. */
function split(rgb, intensity) {
    const most = Math.max(...rgb);
    if (!(most > 0)) return { intensity: 0, color: null };
    const kept = intensity >= most ? intensity : most;
    return { intensity: kept, color: rgb.map((x) => x / kept) };
}

/** A weight by which all lights changed, or null. @param {number[][]} now colour times intensity of each @param {number[][]} white @param {number[]} last */
function commonFactor(now, white, last) {
    const factors = [0, 1, 2].map((c) => now.flatMap((rgb, i) => (white[i][c] > 0 ? [rgb[c] / white[i][c]] : [])));
    const most = Math.max(...factors.flat(), 0);
    const agrees = factors.every((list) => list.every((x) => Math.abs(x - list[0]) <= CHANGED * most));
    const isWhole = now.every((rgb, i) => rgb.every((x, c) => white[i][c] > 0 || x <= CHANGED * Math.max(...white[i]) * most));
    return agrees && isWhole && most <= MOST ? factors.map((list, c) => list[0] ?? last[c]) : null;
}

/** A group: what PropertyBinding of three.js may drive. */
class Group {
    /** @param {LightGroups} groups @param {import('../file/groups.js').GroupData} data */
    constructor(groups, data) {
        this.groups = groups;
        this.data = data;
        this.rgb = [...data.weight];
        /** The light that turns of which it is a direction, and which it follows. @type {TurningGroup | null} */
        this.owner = null;
        /** Lights of the file, and materials with their emission at the weight 1, cd/m2. */
        this.lights = [];
        this.materials = new Map();
        /** Colour times intensity of each light when the weight was last found. */
        this.seen = [];
    }

    /** For tracks of animations. */
    get weight() {
        return this;
    }

    toArray(array = [], offset = 0) {
        this.rgb.forEach((x, c) => (array[offset + c] = x));
        return array;
    }

    fromArray(array, offset = 0) {
        const rgb = [0, 1, 2].map((c) => Math.min(Math.max(array[offset + c], 0), MOST)); // splines swing below 0
        if (!rgb.some(Number.isNaN) && !this.owner) this.groups.change(this, rgb);
    }

    isChanged() {
        return apart(this.rgb, this.data.weight) > CHANGED * Math.max(...this.data.weight);
    }

    /** Gives groups that share its weight their parts. */
    spread() {}

    look() {
        this.seen = this.lights.map((light) => light.shining());
    }
}

/** A light that turns, as one group: those of its directions share its weight. */
class TurningGroup extends Group {
    /** @param {LightGroups} groups @param {import('../scene/lights.js').BakedLight} light */
    constructor(groups, light) {
        const turning = new Turning(light, groups.list.map(({ data }) => data));
        super(groups, /** @type {any} */ ({ name: turning.name, weight: turning.weight }));
        this.turning = turning;
        this.own = groups.list.slice(turning.first, turning.first + turning.directions.length);
        for (const group of this.own) group.owner = this;
    }

    spread() {
        this.own.forEach((group, i) => (group.rgb = this.rgb.map((x) => x * this.turning.shares[i])));
    }
}

export class LightGroups {
    /** @param {import('../scene/scene.js').HalflightScene} scene with its lights and objects */
    constructor(scene) {
        this.scene = scene;
        this.list = scene.data.groups.map((data) => new Group(this, data));
        /** @type {TurningGroup[]} */
        this.turning = [];
        /** Counts the changes of weights, and which of them the probes have. */
        this.version = 0;
        this.probesVersion = 0;
        /** Whether a part of the light still has earlier weights: it follows piece by piece. */
        this.isFollowing = false;
        /** Colours and intensities of lights and of emission before they were changed here. */
        this.before = new Map();
        for (const light of scene.lights) {
            const group = light.data.turns && light.light.isDirectionalLight ? new TurningGroup(this, light) : this.list[light.data.group];
            if (!group) continue;
            if (group instanceof TurningGroup) this.turning.push(group);
            light.group = group;
            group.lights.push(light);
        }
        /** What there is to set: groups in the file's order, each light that turns as one. */
        this.settable = this.list.flatMap((group) => (group.owner ? (group.owner.own[0] === group ? [group.owner] : []) : [group]));
        for (const group of this.settable) group.seen = group.lights.map((light) => light.expected());
        for (const { materials } of scene.objects) for (const [mesh, index] of materials) this.#addMaterial(mesh.material, scene.data.materials.get(index));
    }

    #addMaterial(material, data) {
        const group = this.list[data?.group];
        if (group && material.emissive) group.materials.set(material, data.white);
    }

    /** @returns {number[][]} */
    weights() {
        return this.list.map(({ rgb }) => rgb);
    }

    /** Lower limit of subtractive shadows, lux. */
    shadowColor() {
        return this.scene.data.shadowColor.map((x, c) => this.list.reduce((sum, { rgb, data }) => sum + rgb[c] * data.shadowColor[c], x));
    }

    /** @param {string} name "sky" stands for all parts of a sky that changes @param {number | number[] | import('three').Color} color linear */
    set(name, color) {
        const direction = this.list.find(({ data, owner }) => owner && data.name === name);
        if (direction) throw new Error(`light group "${name}" is of one direction of a light and follows it: turn the light, or set "${direction.owner.data.name}"`);
        const named = this.settable.filter(({ data }) => data.name === name);
        const chosen = named.length === 0 && name === 'sky' ? this.list.filter(({ data }) => data.name.startsWith('sky.')) : named;
        const names = this.settable.map(({ data }) => data.name).join(', ');
        const ofSky = name === 'sky' || String(name).startsWith('sky.') ? ': give the scene halflight_sky_changes = 1, and bake it again' : '';
        if (chosen.length === 0) throw new Error(`there is no light group "${name}": ${names ? `the file has ${names}` : 'the file has none'}${ofSky}`);
        const rgb = rgbOf(name, color);
        for (const group of chosen) this.change(group, rgb);
    }

    /** Gives a light or an emission its white times a weight. */
    #shine(object, [color, intensity], white, rgb) {
        if (!this.before.has(object)) this.before.set(object, { [color]: object[color].clone(), [intensity]: object[intensity] });
        const own = split(white.map((x, c) => x * rgb[c]), object[intensity]);
        if (own.color) object[color].setRGB(...own.color);
        object[intensity] = own.intensity;
    }

    /** @param {Group} group @param {number[]} rgb */
    change(group, rgb) {
        for (const { group: own, light, data } of this.scene.frameLights.states.values())
            if (own === group) this.#shine(light, ['color', 'intensity'], data.white, rgb);
        group.look();
        const isHidden = group.lights.length > 0 && group.lights.every((light) => !light.isShown());
        this.#take(group, isHidden ? [0, 0, 0] : rgb);
    }

    #take(group, rgb) {
        if (equal(rgb, group.rgb)) return;
        group.rgb = rgb;
        group.spread();
        this.version += 1;
        for (const [material, white] of group.materials) this.#shine(material, ['emissive', 'emissiveIntensity'], white, rgb);
    }

    /** Before each frame: adds light up where a weight changed. */
    update(renderer, camera) {
        if (this.list.length === 0) return;
        this.follow();
        const { backend, field, reflections, volumes } = this.scene;
        if (this.probesVersion !== this.version) field.setWeights(this.weights());
        this.probesVersion = this.version;
        const arePagesDone = backend.compose(renderer);
        const areVolumesDone = volumes?.relight(camera) ?? true;
        const areReflectionsDone = reflections?.compose(this) ?? true;
        this.isFollowing = !(arePagesDone && areVolumesDone && areReflectionsDone);
    }

    /** A light that turns has the weights of its direction. One that is hidden has the weight 0; where all lights of a group changed by one factor, that is its weight. */
    follow() {
        for (const group of this.turning) {
            if (group.turning.turn()) {
                group.spread();
                this.version += 1;
            }
            const away = group.turning.away();
            if (away > MOST_STEP)
                this.scene.say(`light "${group.turning.light.name}" shines ${away.toFixed(0)} degrees away from the nearest direction of its bake: its bounced light is that of there, dimmed`);
        }
        for (const group of this.settable) {
            const now = group.lights.map((light) => light.shining());
            const same = now.every((rgb, i) => apart(rgb, group.seen[i]) <= CHANGED * Math.max(...group.seen[i]));
            if (same) continue;
            group.seen = now;
            const rgb = commonFactor(now, group.lights.map(({ data }) => data.white), group.rgb);
            if (rgb) this.#take(group, rgb);
        }
        if (!this.scene.data.reflections) return;
        for (const group of this.list)
            if (!group.data.reflections && group.isChanged())
                this.scene.say(`the light group ${group.data.name} has less than 1 % of what reflection probes show: glossy surfaces reflect it as it was in the bake`);
    }

    /** Lights and emission are as they were before their weights changed here. */
    dispose() {
        for (const [object, before] of this.before)
            for (const [key, value] of Object.entries(before)) {
                if (value.isColor) object[key].copy(value);
                else object[key] = value;
            }
    }
}

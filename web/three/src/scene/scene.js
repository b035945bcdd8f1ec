// A baked scene in three.js: what the application holds.
import { Box3, Vector3 } from 'three';

import { LightGroups } from '../groups/weights.js';
import { ProbeField } from '../probes/field.js';
import { makeLightProbeGrid } from '../probes/grid.js';
import { checkFrame } from './checks.js';
import { FrameLights } from './frame_lights.js';
import { Instance, stampOf, topOf } from './instances.js';
import { BakedLight } from './lights.js';
import { DYNAMIC, Members } from './members.js';
import { checkMode, MODES, VIEWS } from './modes.js';
import { BakedObject } from './objects.js';
import { Reflections } from './reflections.js';
import { boundsOf } from './shadows.js';
import { ObjectTable } from './table.js';
import { enterFile } from './units.js';
import { checkNumber, Warnings } from './warnings.js';
import { planVolumes, ProxyVolumes } from './volumes.js';

const DYNAMIC_LAYER = 31;

/** @typedef {{sky?: boolean, brdf?: 'gltf' | 'three', dynamicLayer?: number}} Options */

const backends = {};

/** A backend for renderers that have a property set. */
export function useBackend(property, backend) {
    backends[property] = backend;
}

export class HalflightScene {
    #mode;
    #view = 'lit';
    #shadowDistance = 60;
    #shadowFadeRange = 1;
    #shadowColor = null;
    #warnings = new Warnings();
    #thrown = '';
    #clones = new Set();
    #watched = [];
    #seen = null;
    #disposed = false;

    /**
     * @param {import('three').Object3D} root gltf.scene
     * @param {import('../file/read.js').BakedData} data
     * @param {{root: any, meshes: any[], node: number, name: string}[]} objects @param {{light: any, node: number, name: string}[]} lights
     * @param {Options} options @param {string} file the mark of its objects in their userData
     */
    constructor(root, data, objects, lights, options, file) {
        this.root = root;
        this.data = data;
        this.options = options;
        this.file = file;
        this.#mode = data.mode;
        if (options.dynamicLayer !== undefined) checkNumber('dynamicLayer', options.dynamicLayer, ' of a layer', 0, 31);
        this.dynamicLayer = options.dynamicLayer ?? DYNAMIC_LAYER;
        for (const lost of data.lost) this.#warnings.keep(`the file has lost part of its bake: ${lost}; use the file that the bake wrote, or a tool that keeps its extensions`);
        this.field = new ProbeField(data.probes, data.sky, 4 * data.maskLayers, data.groups);
        if (!this.field.empty && !this.field.cellsOfFile)
            this.#warnings.keep(`${data.probes.cells ? "the file's tetrahedra do not fit the positions of its probes" : 'the file has no tetrahedra between its probes'}: moving objects take the light of the nearest probe; bake the scene again`);
        this.table = new ObjectTable();
        root.updateWorldMatrix(true, true);
        /** Where the file stands: its scene. Clones have instances of their own. */
        this.instance = new Instance(this.table, root);
        this.members = new Members(this, this.instance);
        /** The first that is drawn: the sky is turned as that. */
        this.shown = this.instance;
        this.lights = lights.map((l) => new BakedLight(l.light, data.lights.get(l.node), l.name, this.instance));
        this.frameLights = new FrameLights(this, this.lights, lights.map((l) => l.node));
        for (const o of objects) {
            const object = new BakedObject(o.root, o.meshes, data.nodes.get(o.node) ?? DYNAMIC, o.name, o.materials, this.instance);
            this.members.originals.set(o.node, object);
            this.members.enter(object);
        }
        this.groups = new LightGroups(this);
        const plan = planVolumes(this.objects, this.field);
        this.volumes = plan.length > 0 ? new ProxyVolumes(plan, this.field, this.table) : null;
        for (const v of this.volumes?.volumes ?? []) {
            const members = v.instance < 0 ? Array.from({ length: v.object.instances }, (_, i) => i) : [v.instance];
            for (const i of members) v.object.setVolume(this.table, i, v.row);
        }
        this.reflections = data.reflections ? new Reflections(data, this.table) : null;
        /** In bake space. */
        this.bounds = boundsOf(this.objects);
        this.backend = null;
        /** Above all that is drawn. */
        this.top = null;
        for (const object of this.objects) for (const mesh of object.meshes) this.#watchFrames(mesh);
        this.#watchClones();
    }

    /** A mesh that is drawn before the first update() is drawn without its bake. */
    #watchFrames(mesh) {
        if (this.#watched === null || Object.hasOwn(mesh, 'onBeforeRender')) return;
        mesh.onBeforeRender = () => this.say('update() was not called before a frame, so the file shows no bake: call it before each');
        this.#watched.push(mesh);
    }

    #unwatchFrames() {
        for (const mesh of this.#watched ?? []) delete mesh.onBeforeRender;
        this.#watched = null;
    }

    /** @type {BakedObject[]} of the file, of clones, and of the application */
    get objects() {
        return this.members.objects;
    }

    get mode() {
        return this.#mode;
    }
    set mode(mode) {
        checkMode(mode, this.data);
        this.#mode = mode;
    }

    /** Modes that the bake holds data for. */
    get modes() {
        return MODES.filter((mode) => {
            try {
                checkMode(mode, this.data);
                return true;
            } catch {
                return false;
            }
        });
    }

    /** From here on no realtime shadow is sampled, metres of the file. */
    get shadowDistance() {
        return this.#shadowDistance;
    }
    set shadowDistance(meters) {
        this.#shadowDistance = checkNumber('shadowDistance', meters, ' of metres');
    }

    /** Shadows fade over this range before the shadow distance, metres of the file. */
    get shadowFadeRange() {
        return this.#shadowFadeRange;
    }
    set shadowFadeRange(meters) {
        this.#shadowFadeRange = checkNumber('shadowFadeRange', meters, ' of metres');
    }

    /** Lower limit of subtractive shadows, lux: by the weights of light groups, unless it was set here. */
    get shadowColor() {
        return this.#shadowColor ?? this.groups.shadowColor();
    }
    set shadowColor(color) {
        if (color?.length !== 3) throw new Error(`shadowColor is ${color}: it has three numbers`);
        this.#shadowColor = [...color].map((x) => checkNumber('shadowColor', x, ' of lux'));
    }

    /** Light groups of the file, in its order, each light that turns as one: their names, weights by channel, and those that the file saves. */
    get lightGroups() {
        return this.groups.settable.map(({ data, rgb }) => ({ name: data.name, weight: [...rgb], savedWeight: [...data.weight] }));
    }

    /**
     * What the light of a group is multiplied by: baked and emitted light, probes, mixed lights, the sky.
     * @param {string} name @param {number | number[] | import('three').Color} color linear, 0 for off
     */
    setLightGroup(name, color) {
        this.groups.set(name, color);
    }

    /** Whether light still follows a change of weights: an application that draws on demand draws another frame. */
    get isFollowing() {
        return this.groups.isFollowing;
    }

    /** @type {Set<string>} sentences about what is left out or shows in part, while it is so */
    get warnings() {
        return this.#warnings.sentences;
    }

    /** A sentence about the frame. @param {string} sentence */
    say(sentence) {
        this.#warnings.say(sentence);
    }

    /** A sentence about the file. @param {string} sentence */
    keep(sentence) {
        this.#warnings.keep(sentence);
    }

    get debugView() {
        return this.#view;
    }
    set debugView(view) {
        if (!VIEWS.includes(view)) throw new Error(`there is no view "${view}": it is one of ${VIEWS.join(', ')}`);
        this.#view = view;
    }

    /** Lights an object of the application by the probes: a dynamic object. @param {import('three').Object3D} root */
    add(root) {
        root.updateWorldMatrix(true, true);
        root.traverse((mesh) => mesh.isMesh && !this.members.rows.has(mesh) && this.members.addMesh(mesh));
    }

    /** Takes back what `add()` did, or forgets a clone. Objects that leave the scene are removed by themselves. @param {import('three').Object3D} root */
    remove(root) {
        this.members.remove(root);
    }

    /** First row of an object's data in the table. @param {any} object that is drawn @param {any} [scene] three.js's @param {any} [material] */
    rowOf(object, scene, material) {
        const row = this.members.rows.get(object);
        if (row !== undefined) return row;
        this.#seen = scene ?? null; // it came after update(), or update() does not find the scene
        if (stampOf(object, this.file)) {
            this.members.adopt(object);
        } else {
            this.#warnings.keep(`"${object.name}" has a material of the bake but is no object of it: it is lit by probes, as by add()`);
            this.members.addMesh(object);
        }
        this.#updateProbes();
        if (material) material.uniformsNeedUpdate = true;
        return this.members.rows.get(object) ?? 0;
    }

    /** Clones of the file's scene are found before they are drawn. */
    #watchClones() {
        const { root } = this;
        const { clone } = root;
        const own = Object.hasOwn(root, 'clone');
        const clones = this.#clones;
        const watch = (copy) => copy.traverse((object) => object.isMesh && this.#watchFrames(object));
        root.clone = function (recursive) {
            const copy = clone.call(this, recursive);
            clones.add(new WeakRef(copy));
            watch(copy);
            return copy;
        };
        this.undoClone = () => {
            if (own) root.clone = clone;
            else delete root.clone;
        };
    }

    /**
     * The probes as three.js's LightProbeGrid, for objects that the plug-in does not light.
     * @param {any} Grid the class: LightProbeGridWebGL for WebGLRenderer, LightProbeGrid for WebGPURenderer
     * @param {{box?: Box3, resolution?: number[]}} [options] the scene's box and the distance of probes where absent
     */
    toLightProbeGrid(Grid, { box, resolution } = {}) {
        const positions = this.data.probes?.positions ?? [];
        const all = this.bounds.clone();
        for (let i = 0; i < positions.length; i += 3) all.expandByPoint(new Vector3(positions[i], positions[i + 1], positions[i + 2]));
        const { grid, clipped } = makeLightProbeGrid(this.field, Grid, box ?? all, resolution);
        if (clipped) this.#warnings.keep('probe light above 65504 is cut in the LightProbeGrid: its texture holds half floats');
        return grid;
    }

    /**
     * Before each frame: `renderer` draws it through `camera`.
     * @param {any} renderer @param {any} camera @param {any} [scene] three.js's, where the file's own objects are in none
     */
    update(renderer, camera, scene) {
        try {
            this.#update(renderer, camera, scene);
        } catch (error) {
            if (error.message === this.#thrown) return; // once is enough: an exception in each frame stops the application
            this.#thrown = error.message;
            throw error;
        }
    }

    #update(renderer, camera, scene) {
        if (this.#disposed) return;
        this.#unwatchFrames();
        if (!this.backend) this.#start(renderer);
        this.#warnings.begin();
        const top = this.#top(scene);
        enterFile(this, top);
        this.members.drop(top);
        for (const object of [this.sky, this.backend.noLight]) if (object && object.parent !== top) top.add(object);
        top.updateMatrixWorld();
        for (const instance of this.members.instances.values()) instance.update();
        const found = this.#find(top);
        this.shown = [...this.members.instances.values()].find(({ object }) => topOf(object) === top) ?? this.instance;
        const view = cameraOf(renderer, camera);
        this.groups.update(renderer, view);
        this.#updateProbes();
        this.frameLights.update(renderer, view, found);
        this.backend.update();
        checkFrame(this, found.lights);
        this.#warnings.end();
    }

    /** The object above all that is drawn. */
    #top(scene) {
        if (scene) return topOf(scene);
        if (this.root.parent) return topOf(this.root);
        if (this.#seen) return topOf(this.#seen);
        for (const reference of this.#clones) {
            const clone = reference.deref();
            if (!clone) this.#clones.delete(reference);
            else if (clone.parent) return topOf(clone);
        }
        return this.root;
    }

    /** Enters clones, and lists the lights. */
    #find(top) {
        const found = { lights: new Set(), drawn: [] };
        const visit = (object, shown) => {
            const visible = shown && object.visible;
            const stamp = stampOf(object, this.file);
            if (stamp && object.isMesh && !this.members.rows.has(object)) this.members.adopt(object);
            if (stamp?.isAreaLight && !object.isHalflightAreaLight) this.frameLights.standIn(object, stamp.node);
            if (object.isLight || object.isHalflightAreaLight) {
                if (stamp && !this.frameLights.states.has(object)) {
                    const instance = this.members.instanceOf(object);
                    if (instance) this.frameLights.adopt(object, stamp.node, instance);
                }
                found.lights.add(object);
                if (visible && object.isLight) found.drawn.push(object);
            }
            for (const child of object.children) visit(child, visible);
        };
        visit(top, true);
        return found;
    }

    #start(renderer) {
        const kind = Object.keys(backends).find((name) => renderer[name] === true);
        if (!kind)
            throw new Error("import the plug-in from '@halflight/three' for WebGLRenderer, from '@halflight/three/webgpu' for WebGPURenderer");
        this.backend = new backends[kind](this);
        for (const object of this.objects) this.members.attach(object);
        if (this.options.sky !== false && this.#hasSky()) this.sky = this.backend.makeSky();
    }

    /** Whether the sky shines, or may by a weight. */
    #hasSky() {
        const { zenith, horizon, ground } = this.data.sky;
        return [zenith, horizon, ground].flat().some((x) => x > 0) || this.data.groups.some(({ sky }) => sky);
    }

    #updateProbes() {
        for (const object of this.objects) {
            object.follow();
            if (object.lightmapped && this.debugView !== 'probes') continue; // only that view shows their probes
            if (!object.isDark && object.lightVersion === this.field.version) continue;
            for (const v of this.volumes?.volumes ?? []) if (v.object === object && object.isDark) this.volumes.fill(v);
            object.isDark = false;
            object.lightVersion = this.field.version;
            for (let i = 0; i < object.instances; ++i) object.sample(i, this.field, this.table);
        }
    }

    /** Takes everything back: materials, lights and objects are as they were loaded. */
    dispose() {
        if (this.#disposed) return;
        this.#disposed = true;
        enterFile(this, null);
        this.#unwatchFrames();
        this.undoClone();
        for (const object of this.objects) object.detach();
        this.frameLights.dispose();
        this.groups.dispose();
        this.backend?.dispose();
        this.backend = null;
        this.volumes?.dispose();
        this.reflections?.dispose();
        this.table.dispose();
        for (const object of this.objects) for (const mesh of object.meshes) forget(mesh, this.file);
        this.root.traverse((object) => forget(object, this.file));
        if (this.sky) {
            this.sky.removeFromParent();
            this.sky.geometry.dispose();
            this.sky.material.dispose();
            this.sky = null;
        }
    }
}

/** The camera that a frame is drawn through: in a headset three.js's own, with this frame's pose, for both eyes. */
function cameraOf(renderer, camera) {
    if (!camera.parent) camera.updateMatrixWorld();
    else camera.updateWorldMatrix(true, false);
    const { xr } = renderer;
    if (!xr?.enabled || !xr.isPresenting) return camera;
    if (xr.cameraAutoUpdate) xr.updateCamera(camera);
    return xr.getCamera();
}

function forget(object, file) {
    if (stampOf(object, file)) delete object.userData.halflight;
}

// A baked scene in three.js: what the application holds.
import { Box3, Vector3 } from 'three';

import { ProbeField } from '../probes/field.js';
import { makeLightProbeGrid } from '../probes/grid.js';
import { checkFrame } from './checks.js';
import { FrameLights } from './frame_lights.js';
import { Instance, rootOf, stampOf } from './instances.js';
import { BakedLight } from './lights.js';
import { checkMode, MODES, VIEWS } from './modes.js';
import { BakedObject } from './objects.js';
import { Reflections } from './reflections.js';
import { boundsOf } from './shadows.js';
import { ObjectTable } from './table.js';
import { checkNumber, Warnings } from './warnings.js';
import { planVolumes, ProxyVolumes } from './volumes.js';

const DYNAMIC = { isStatic: false, castShadows: true, receiveShadows: true, lightmap: null, probes: 'single', probeResolution: [0, 0, 0] };
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
    #shadowColor;
    #warnings = new Warnings();
    #thrown = '';
    #clones = new Set();
    #watched = [];
    #seen = null;
    #originals = new Map();

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
        this.#shadowColor = [...data.shadowColor];
        if (options.dynamicLayer !== undefined) checkNumber('dynamicLayer', options.dynamicLayer, ' of a layer', 0, 31);
        this.dynamicLayer = options.dynamicLayer ?? DYNAMIC_LAYER;
        for (const lost of data.lost) this.#warnings.keep(`the file has lost part of its bake: ${lost}; use the file that the bake wrote, or a tool that keeps its extensions`);
        this.field = new ProbeField(data.probes, data.sky);
        if (data.probes?.cells && !this.field.cellsOfFile && !this.field.empty)
            this.#warnings.keep("the file's tetrahedra do not fit the positions of its probes: others are made, which takes a while");
        this.table = new ObjectTable();
        root.updateWorldMatrix(true, true);
        /** Where the file stands: its scene. Clones have instances of their own. */
        this.instance = new Instance(this.table, root);
        this.instances = new Map([[root, this.instance]]);
        /** The first that is drawn: the sky is turned as that. */
        this.shown = this.instance;
        this.lights = lights.map((l) => new BakedLight(l.light, data.lights.get(l.node), l.name, this.instance));
        this.frameLights = new FrameLights(this, this.lights, lights.map((l) => l.node));
        /** First row of the table by mesh. */
        this.rows = new Map();
        /** @type {BakedObject[]} */
        this.objects = [];
        for (const o of objects) {
            const object = new BakedObject(o.root, o.meshes, data.nodes.get(o.node) ?? DYNAMIC, o.name, o.materials, this.instance);
            this.#originals.set(o.node, object);
            this.#enter(object);
        }
        const plan = planVolumes(this.objects, this.field);
        this.volumes = plan.length > 0 ? new ProxyVolumes(plan, this.field, this.table) : null;
        for (const v of this.volumes?.volumes ?? []) {
            const members = v.instance < 0 ? Array.from({ length: v.object.instances }, (_, i) => i) : [v.instance];
            for (const i of members) v.object.setVolume(this.table, i, v.row);
        }
        this.reflections = data.reflections ? new Reflections(data.reflections, this.table) : null;
        /** In bake space. */
        this.bounds = boundsOf(this.objects);
        this.backend = null;
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

    /** Lower limit of subtractive shadows, lux. */
    get shadowColor() {
        return this.#shadowColor;
    }
    set shadowColor(color) {
        if (color?.length !== 3) throw new Error(`shadowColor is ${color}: it has three numbers`);
        this.#shadowColor = [...color].map((x) => checkNumber('shadowColor', x, ' of lux'));
    }

    /** @type {Set<string>} sentences about what is left out or shows in part, while it is so */
    get warnings() {
        return this.#warnings.sentences;
    }

    /** A sentence about the frame. @param {string} sentence */
    say(sentence) {
        this.#warnings.say(sentence);
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
        root.traverse((mesh) => mesh.isMesh && !this.rows.has(mesh) && this.#addMesh(mesh));
    }

    #addMesh(mesh) {
        const data = { ...DYNAMIC, castShadows: mesh.castShadow, receiveShadows: mesh.receiveShadow };
        this.#enter(new BakedObject(mesh, [mesh], data, mesh.name, new Map(), this.#instanceAt(mesh), null, false));
    }

    #enter(object) {
        object.place(this.table);
        this.objects.push(object);
        for (const mesh of object.meshes) this.rows.set(mesh, object.firstRow);
        if (this.backend) this.#attach(object);
    }

    /** Of an object of the application: the clone that holds it, or the nearest. */
    #instanceAt(mesh) {
        const root = rootOf(mesh, this.file);
        if (root && this.instances.has(root)) return this.instances.get(root);
        const distance = (instance) => this.bounds.distanceToPoint(new Vector3().setFromMatrixPosition(mesh.matrixWorld).applyMatrix4(instance.bakeFromWorld)) * instance.scale;
        const placed = [...this.instances.values()].filter(({ object, objectFromBake }) => object.parent && !objectFromBake);
        return placed.reduce((best, instance) => (best && distance(best) <= distance(instance) ? best : instance), null) ?? this.instance;
    }

    /** Of an object of a clone. @param {any} object @param {BakedObject} [original] of a mesh */
    #instanceOf(object, original) {
        const root = rootOf(object, this.file);
        if (!root && !original) return null;
        const key = root ?? object;
        if (!this.instances.has(key)) this.instances.set(key, new Instance(this.table, key, root ? undefined : original.atLoad));
        return this.instances.get(key);
    }

    /** A mesh of a clone, lit as its original. */
    #adopt(mesh) {
        const original = this.#originals.get(stampOf(mesh, this.file).node);
        if (!original) return;
        const { isStatic, castShadows, receiveShadows, probes, probeResolution, placement } = original;
        const data = { isStatic, castShadows, receiveShadows, probes, probeResolution, lightmap: placement };
        const material = original.materials.get(original.meshes[stampOf(mesh, this.file).primitive]);
        const object = new BakedObject(mesh, [mesh], data, original.name, new Map([[mesh, material]]), this.#instanceOf(mesh, original), original);
        this.#enter(object);
        if (!isStatic) return;
        for (const v of this.volumes?.volumes ?? [])
            for (let i = 0; i < object.instances; ++i) if (v.object === original && (v.instance < 0 || v.instance === i)) object.setVolume(this.table, i, v.row);
    }

    /** First row of an object's data in the table. @param {any} object that is drawn @param {any} [scene] three.js's @param {any} [material] */
    rowOf(object, scene, material) {
        const row = this.rows.get(object);
        if (row !== undefined) return row;
        this.#seen = scene ?? null; // it came after update(), or update() does not find the scene
        if (stampOf(object, this.file)) {
            this.#adopt(object);
        } else {
            this.#warnings.keep(`"${object.name}" has a material of the bake but is no object of it: it is lit by probes, as by add()`);
            this.#addMesh(object);
        }
        this.#updateProbes();
        if (material) material.uniformsNeedUpdate = true;
        return this.rows.get(object) ?? 0;
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
        this.#unwatchFrames();
        if (!this.backend) this.#start(renderer);
        this.#warnings.begin();
        const top = this.#top(scene);
        for (const object of [this.sky, this.backend.noLight]) if (object && object.parent !== top) top.add(object);
        top.updateMatrixWorld();
        if (!camera.parent) camera.updateMatrixWorld();
        else camera.updateWorldMatrix(true, false);
        for (const instance of this.instances.values()) instance.update();
        const found = this.#find(top);
        this.shown = [...this.instances.values()].find(({ object }) => topOf(object) === top) ?? this.instance;
        this.#updateProbes();
        this.frameLights.update(renderer, camera, found);
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
            if (stamp && object.isMesh && !this.rows.has(object)) this.#adopt(object);
            if (object.isLight || object.isHalflightAreaLight) {
                if (stamp && !this.frameLights.states.has(object)) {
                    const instance = this.#instanceOf(object);
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
        for (const object of this.objects) {
            this.#attach(object);
        }
        if (this.options.sky !== false && Object.values(this.data.sky).flat().some((x) => x > 0)) this.sky = this.backend.makeSky();
    }

    #attach(object) {
        object.attach();
        for (const mesh of object.meshes) {
            const before = { castShadow: mesh.castShadow, receiveShadow: mesh.receiveShadow, layers: mesh.layers.mask };
            const switches = this.data.materials.get(object.materials.get(mesh)) ?? DYNAMIC; // shadows want both switches
            mesh.castShadow = object.castShadows && switches.castShadows;
            mesh.receiveShadow = object.receiveShadows && switches.receiveShadows;
            if (!object.isStatic) mesh.layers.enable(this.dynamicLayer);
            object.undo.push(() => {
                mesh.castShadow = before.castShadow;
                mesh.receiveShadow = before.receiveShadow;
                mesh.layers.mask = before.layers;
            });
            this.backend.patchMesh(mesh);
        }
    }

    #updateProbes() {
        for (const object of this.objects) {
            if (object.lightmapped && this.debugView !== 'probes') continue; // only that view shows their probes
            if (!object.moved()) continue;
            const own = (this.volumes?.volumes ?? []).filter((v) => v.object === object);
            for (const v of own) this.volumes.fill(v);
            for (let i = 0; i < object.instances; ++i) this.table.setSample(object.firstRow + i, this.field.sample(object.anchor(i)));
        }
    }

    /** Takes everything back: materials, lights and objects are as they were loaded. */
    dispose() {
        this.#unwatchFrames();
        this.undoClone();
        for (const object of this.objects) object.detach();
        this.frameLights.dispose();
        this.backend?.dispose();
        this.backend = null;
        this.volumes?.dispose();
        this.table.dispose();
        if (this.sky) {
            this.sky.removeFromParent();
            this.sky.geometry.dispose();
            this.sky.material.dispose();
            this.sky = null;
        }
    }
}

function topOf(object) {
    let top = object;
    while (top.parent) top = top.parent;
    return top;
}

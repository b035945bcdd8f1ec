// A baked scene in three.js: what the application holds.
import { Box3, Vector3 } from 'three';

import { ProbeField } from '../probes/field.js';
import { makeLightProbeGrid } from '../probes/grid.js';
import { BakedLight, findMainLight } from './lights.js';
import { checkMode, MODES, VIEWS } from './modes.js';
import { BakedObject } from './objects.js';
import { Reflections } from './reflections.js';
import { boundsOf, chooseCasters, fitShadow, releaseCasters } from './shadows.js';
import { ObjectTable } from './table.js';
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
    #drawn = null;

    /**
     * @param {import('three').Object3D} root gltf.scene
     * @param {import('../file/read.js').BakedData} data
     * @param {{root: any, meshes: any[], node: number, name: string}[]} objects @param {{light: any, node: number, name: string}[]} lights
     * @param {Options} options
     */
    constructor(root, data, objects, lights, options = {}) {
        this.root = root;
        this.data = data;
        this.options = options;
        this.#mode = data.mode;
        /** From here on no realtime shadow is sampled, metres. */
        this.shadowDistance = 60;
        /** Shadows fade over this range before the shadow distance, metres. */
        this.shadowFadeRange = 1;
        /** Lower limit of subtractive shadows, lux. */
        this.shadowColor = [...data.shadowColor];
        /** @type {Set<string>} sentences about what is left out or shows in part */
        this.warnings = new Set();
        this.dynamicLayer = options.dynamicLayer ?? DYNAMIC_LAYER;
        this.field = new ProbeField(data.probes, data.sky);
        if (data.probes?.cells && !this.field.cellsOfFile && !this.field.empty)
            this.warnings.add("the file's tetrahedra do not fit the positions of its probes: others are made, which takes a while");
        this.table = new ObjectTable();
        this.lights = lights.map((l) => new BakedLight(l.light, data.lights.get(l.node), l.name));
        root.updateWorldMatrix(true, true);
        this.objects = objects.map((o) => new BakedObject(o.root, o.meshes, data.nodes.get(o.node) ?? DYNAMIC, o.name, o.materials));
        for (const object of this.objects) object.place(this.table);
        const plan = planVolumes(this.objects, this.field);
        this.volumes = plan.length > 0 ? new ProxyVolumes(plan, this.field, this.table) : null;
        for (const v of this.volumes?.volumes ?? []) {
            const members = v.instance < 0 ? Array.from({ length: v.object.instances }, (_, i) => i) : [v.instance];
            for (const i of members) v.object.setVolume(this.table, i, v.row);
        }
        this.reflections = data.reflections ? new Reflections(data.reflections, this.table) : null;
        this.bounds = boundsOf(this.objects);
        this.backend = null;
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

    get debugView() {
        return this.#view;
    }
    set debugView(view) {
        if (!VIEWS.includes(view)) throw new Error(`there is no view "${view}": it is one of ${VIEWS.join(', ')}`);
        this.#view = view;
    }

    /** Lights an object of the application by the probes: a dynamic object. @param {import('three').Object3D} root */
    add(root) {
        const meshes = [];
        root.traverse((o) => o.isMesh && meshes.push(o));
        for (const mesh of meshes) {
            const object = new BakedObject(mesh, [mesh], { ...DYNAMIC, castShadows: mesh.castShadow, receiveShadows: mesh.receiveShadow }, mesh.name);
            mesh.updateWorldMatrix(true, false);
            object.place(this.table);
            this.objects.push(object);
            if (this.backend) this.#attach(object);
        }
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
        if (clipped) this.warnings.add('probe light above 65504 is cut in the LightProbeGrid: its texture holds half floats');
        return grid;
    }

    /** Before each frame: `renderer` draws it through `camera`. */
    update(renderer, camera) {
        if (!this.backend) this.#start(renderer);
        let top = this.root;
        while (top.parent) top = top.parent;
        top.updateMatrixWorld();
        if (!camera.parent) camera.updateMatrixWorld();
        else camera.updateWorldMatrix(true, false);
        this.#updateProbes();
        this.#updateLights(renderer, camera, top);
        this.backend.update();
    }

    #start(renderer) {
        const kind = Object.keys(backends).find((name) => renderer[name] === true);
        if (!kind)
            throw new Error("import the plug-in from '@halflight/three' for WebGLRenderer, from '@halflight/three/webgpu' for WebGPURenderer");
        this.backend = new backends[kind](this);
        for (const object of this.objects) {
            this.#attach(object);
        }
        if (this.options.sky !== false && Object.values(this.data.sky).flat().some((x) => x > 0)) {
            this.sky = this.backend.makeSky();
            this.root.add(this.sky);
        }
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
            for (const material of [mesh.material].flat())
                if (!material.isMeshStandardMaterial && !material.isMeshBasicMaterial)
                    this.warnings.add(`material "${material.name}" is a ${material.type}: only MeshStandardMaterial and MeshPhysicalMaterial show the bake`);
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

    #updateLights(renderer, camera, top) {
        const main = this.mode === 'subtractive' ? findMainLight(this.lights) : null;
        this.mainLight = findMainLight(this.lights)?.light ?? null;
        const shadows = renderer.shadowMap.enabled;
        for (const state of this.lights) state.planFor(this.mode, state === main, this.debugView);
        this.#limitShadowMaps(renderer, camera);
        for (const state of this.lights) {
            const { light } = state;
            light.layers.mask = state.plan.drawn ? state.before.layers : 0;
            light.castShadow = shadows && state.mapAllowed && this.#wantsMap(state);
            if (light.castShadow) {
                fitShadow(state, camera, this.shadowDistance, this.bounds);
                chooseCasters(state, this.dynamicLayer, renderer);
            }
            const sentence = state.moved();
            if (sentence && this.mode !== 'realtime') this.warnings.add(sentence);
        }
        const states = new Map(this.lights.map((s) => [s.light, s]));
        this.backend.setAreaLights(this.lights.filter((state) => state.isArea).map((state) => this.#areaLight(state, camera)));
        const drawn = [];
        const visit = (object) => {
            if (!object.visible) return;
            if (object.isLight && object.layers.test(camera.layers)) drawn.push(object);
            object.children.forEach(visit);
        };
        visit(top);
        this.backend.setLights(drawn, (light) => {
            const hasMap = light.castShadow && shadows;
            const state = states.get(light) ?? new BakedLight(light, undefined, light.name);
            if (!states.has(light)) state.shadowStrength = light.shadow?.intensity ?? 1;
            return state.uniforms(hasMap);
        });
    }

    /** What a backend draws of an area light. */
    #areaLight(state, camera) {
        const { light } = state;
        let shown = state.plan.drawn && light.layers.test(camera.layers);
        for (let object = light; object; object = object.parent) shown &&= object.visible;
        if (shown && state.plan.casts && this.#castsWithoutMap(state))
            this.warnings.add(`area light "${state.name}" has no realtime shadow in three.js: its shadows are those of the mask`);
        const [halfX, halfY] = light.halfSides();
        const color = light.color.clone().multiplyScalar(shown ? light.intensity : 0);
        return { ...state.uniforms(false), halfX, halfY, color, isDisk: light.isDisk, range: light.range, position: new Vector3().setFromMatrixPosition(light.matrixWorld) };
    }

    /** Whether an object that casts into the light's map in the program is there. */
    #castsWithoutMap(state) {
        return this.objects.some((o) => (state.plan.staticCasters || !o.isStatic) && o.meshes.some((m) => m.castShadow));
    }

    #wantsMap(state) {
        if (!state.plan.casts || state.isArea) return false;
        return state.plan.staticCasters || this.objects.some((o) => !o.isStatic && o.meshes.some((m) => m.castShadow));
    }

    /** Each shadow map takes a texture unit of the fragment shader. Lights that get none keep their baked shadows. */
    #limitShadowMaps(renderer, camera) {
        const wanting = this.lights.filter((state) => this.#wantsMap(state));
        const units = renderer.capabilities?.maxTextures ?? Infinity; // of fragment shaders
        const most = Math.max(units - this.backend.samplers(), 0);
        for (const state of wanting) state.mapAllowed = true;
        if (wanting.length <= most) return;
        wanting.sort((a, b) => b.importance(camera) - a.importance(camera));
        for (const state of wanting.slice(most)) {
            state.mapAllowed = false;
            this.warnings.add(`light "${state.name}" gets no realtime shadow: the browser's shaders read ${units} textures at most`);
        }
    }

    /** Takes everything back: materials, lights and objects are as they were loaded. */
    dispose() {
        for (const object of this.objects) object.detach();
        for (const state of this.lights) {
            releaseCasters(state);
            state.restore();
        }
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

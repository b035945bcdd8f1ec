// The lights of a file and of its clones, as one frame draws them.
import { Vector3 } from 'three';

import { BakedLight, findMainLight } from './lights.js';
import { chooseCasters, fitShadow, releaseCasters } from './shadows.js';
import { filesBeside, limitMaps } from './units.js';

/** States of the lights of all files: a light of another file lights by its own metres too. */
const owners = new WeakMap();

/** What decides whether three.js draws lights, and in which order. */
const switchesOf = (lights) => lights.map((light) => `${light.layers.mask} ${light.castShadow}`).join();

/** GLTFLoader's target is a child of the light; `clone()` gives the clone another, which is in no scene. @param {any} light of a clone @param {any} original */
function aimAs(light, original) {
    if (!light.target || light.target.parent) return;
    const index = original.children.indexOf(original.target);
    light.target = index < 0 ? original.target : (light.children[index] ?? light.target);
    if (!light.target.parent) light.add(light.target);
    light.target.updateWorldMatrix(true, false);
}

export class FrameLights {
    /** @param {import('./scene.js').HalflightScene} scene @param {BakedLight[]} own of the file, by `node` */
    constructor(scene, own, nodes) {
        this.scene = scene;
        this.own = own;
        this.byNode = new Map(nodes.map((node, i) => [node, own[i]]));
        this.states = new Map(own.map((state) => [state.light, state]));
        for (const state of own) owners.set(state.light, state);
        /** three.js's lights that may be subtractive's main light, one for each clone. */
        this.mainLights = new Set();
    }

    /** A light of a clone. @param {any} light @param {number} node @param {import('./instances.js').Instance} instance */
    adopt(light, node, instance) {
        const original = this.byNode.get(node);
        if (!original) return;
        aimAs(light, original.light);
        const state = new BakedLight(light, original.data, original.name, instance, original);
        this.states.set(light, state);
        owners.set(light, state);
    }

    /** An area light for a plain object that was made of one, as drei's Clone does. @param {any} object @param {number} node */
    standIn(object, node) {
        const original = this.byNode.get(node)?.light;
        if (!original || object.children.some((child) => child.isHalflightAreaLight)) return;
        const light = original.clone();
        light.position.setScalar(0);
        light.quaternion.identity();
        light.scale.setScalar(1);
        object.add(light);
        light.updateWorldMatrix(false, false);
    }

    /** @param {(state: BakedLight) => boolean} gone */
    drop(gone) {
        for (const [light, state] of this.states) {
            if (!state.original || !gone(state)) continue;
            releaseCasters(state);
            this.states.delete(light);
        }
    }

    /**
     * @param {any} renderer @param {any} camera
     * @param {{lights: Set<any>, drawn: any[]}} found lights below the top, and those that the camera's layers and visibility leave
     */
    update(renderer, camera, { lights, drawn }) {
        const { mode, debugView, shadowDistance, bounds, dynamicLayer, backend } = this.scene;
        const present = [...this.states.values()].filter((state) => lights.has(state.light));
        const mains = this.findMains(present);
        this.mainLights = new Set(mains.map((state) => state.light));
        const shadows = renderer.shadowMap.enabled;
        for (const state of present) {
            state.scaleRange();
            state.planFor(mode, mode === 'subtractive' && mains.includes(state), debugView);
        }
        const others = filesBeside(this.scene);
        const before = others.length > 0 ? switchesOf(drawn) : '';
        limitMaps(this, camera, drawn, { units: backend.units(renderer), taken: FrameLights.unitsOf(this.scene.top), perMap: renderer.shadowMap.transmitted ? 2 : 1 });
        for (const state of present) {
            const { light } = state;
            light.layers.mask = state.plan.drawn ? state.before.layers : 0;
            light.castShadow = shadows && state.mapAllowed && this.wantsMap(state);
            if (light.castShadow) {
                fitShadow(state, camera, shadowDistance, bounds);
                chooseCasters(state, dynamicLayer, renderer);
            }
        }
        backend.setAreaLights(present.filter((state) => state.isArea).map((state) => this.areaLight(state, camera)));
        this.setLights(drawn, camera, shadows);
        // Their materials have the lights of all files, in an order that their switches make.
        if (others.length > 0 && switchesOf(drawn) !== before) for (const other of others) other.frameLights.setLights(drawn, camera, shadows);
    }

    setLights(drawn, camera, shadows) {
        this.scene.backend.setLights(drawn.filter((light) => light.layers.test(camera.layers)), (light) => this.uniformsOf(light, shadows));
    }

    /** Each clone has its own. */
    findMains(present) {
        const groups = new Map();
        for (const state of present) groups.set(state.instance, [...(groups.get(state.instance) ?? []), state]);
        return [...groups.values()].map(findMainLight).filter((state) => state !== null);
    }

    uniformsOf(light, shadows) {
        const known = this.states.get(light);
        const state = known ?? new BakedLight(light, undefined, light.name);
        if (!known) state.shadowStrength = Math.min(Math.max(light.shadow?.intensity ?? 1, 0), 1);
        const uniforms = state.uniforms(light.castShadow && shadows);
        if (!known) uniforms.own[1] = owners.get(light)?.scale ?? 1;
        return uniforms;
    }

    /** What a backend draws of an area light. */
    areaLight(state, camera) {
        const { light } = state;
        let shown = state.plan.drawn && light.layers.test(camera.layers);
        for (let object = light; object; object = object.parent) shown &&= object.visible;
        if (shown && state.plan.casts && this.castsWithoutMap(state))
            this.scene.say(`area light "${state.name}" has no realtime shadow in three.js: its shadows are those of the mask`);
        const [halfX, halfY] = light.halfSides();
        const color = light.color.clone().multiplyScalar(shown ? light.intensity : 0);
        return { ...state.uniforms(false), halfX, halfY, color, isDisk: light.isDisk, range: light.range, position: new Vector3().setFromMatrixPosition(light.matrixWorld) };
    }

    /** Whether an object that casts into the light's map in the program is there. */
    castsWithoutMap(state) {
        return this.scene.objects.some((o) => (state.plan.staticCasters || !o.isStatic) && o.meshes.some((m) => m.castShadow));
    }

    wantsMap(state) {
        if (!state.plan.casts || state.isArea) return false;
        return state.plan.staticCasters || this.scene.objects.some((o) => !o.isStatic && o.meshes.some((m) => m.castShadow));
    }

    /** Units that the scene takes in all materials: a picture around it, and three.js's own grid of probes. */
    static unitsOf(top) {
        return (top.environment ? 1 : 0) + (top.children.some((object) => object.isLightProbeGrid) ? 1 : 0);
    }

    dispose() {
        for (const state of this.states.values()) {
            releaseCasters(state);
            state.restore();
        }
    }
}

// The bake as WebGLRenderer draws it: textures, uniforms, patched materials.
import { Matrix3, Vector2, Vector3, Vector4 } from 'three';

import { makeComposer } from '../groups/composer.js';
import { kLightDisk, kLightRectangle } from '../generated/shading.js';
import { hasColoredMasks } from '../scene/lights.js';
import { MODES, VIEWS } from '../scene/modes.js';
import { makeSky } from '../scene/sky.js';
import { skyTexture, skyTurn } from '../scene/sky_picture.js';
import { arrayTexture, FORMATS } from '../scene/textures.js';
import { texturesOf } from '../scene/units.js';
import { WebGLPageDraws } from './compose.js';
import { MaterialPatches } from './patch.js';

const NO_LIGHT = { flags: new Vector4(-1, 0, 0, 1), reach: new Vector4(), cone: new Vector4(0, 0, 0, -2), own: new Vector2(-1, 1) };

const lightOf = ({ flags, reach, cone, own }) => ({ flags: new Vector4(...flags), reach: new Vector4(...reach), cone: new Vector4(...cone), own: new Vector2(...own) });

const vectors = (...colors) => colors.map((c) => new Vector3(c[0], c[1], c[2]));

export class WebGLBackend {
    /** @param {import('../scene/scene.js').HalflightScene} scene */
    constructor(scene) {
        this.scene = scene;
        const { data, table, volumes } = scene;
        this.textures = [];
        const features = [];
        /** Makes the pages of light groups. */
        this.composer = makeComposer(data, WebGLPageDraws);
        const pages = (name, feature, list, kind, composed) => {
            if (list.length === 0) return {};
            features.push(feature);
            const texture = composed ?? arrayTexture(list, FORMATS[kind]);
            if (!composed) this.textures.push(texture);
            return { [name]: { value: texture } };
        };
        const sh = Array.from({ length: 9 }, (_, i) => scene.field.sky.radiance.subarray(3 * i, 3 * i + 3));
        this.uniforms = {
            ...pages('hlLightmaps', 'HL_LIGHTMAPS', data.lightmaps, 'rgb9e5', this.composer?.lightmaps),
            ...pages('hlDirections', 'HL_DIRECTIONS', data.directions, 'rgba8', this.composer?.directions),
            ...pages('hlMasks', 'HL_MASKS', data.masks, 'rgba8'),
            hlTable: { value: table.texture },
            hlPointLights: { value: [] },
            hlSpotLights: { value: [] },
            hlDirectionalLights: { value: [] },
            hlMode: { value: 0 },
            hlView: { value: 0 },
            hlShadow: { value: new Vector2() },
            hlUnitLux: { value: data.unitLux },
            hlShadowColor: { value: new Vector3(...data.shadowColor) },
            hlSky: { value: vectors(data.sky.zenith, data.sky.horizon, data.sky.ground) },
            hlSkyFactor: { value: new Vector3(1, 1, 1) },
            hlSkySh: { value: vectors(...sh) },
            hlSkyFromWorld: { value: new Matrix3() },
            hlMaskRange: { value: data.maskChannels.map((c) => c.rangeTexels) },
            hlMaskPenumbra: { value: data.maskChannels.map((c) => c.penumbraTexels) },
        };
        if (data.sky.picture) {
            features.push('HL_SKY_PICTURE');
            this.uniforms.hlSkyPicture = { value: skyTexture(data.sky.picture.pixels) };
            this.uniforms.hlSkyTurn = { value: new Vector4(...skyTurn(data.sky.picture)) };
            this.textures.push(this.uniforms.hlSkyPicture.value);
        }
        if (scene.reflections) {
            features.push('HL_REFLECTIONS');
            this.uniforms.hlReflectionPicture = { value: scene.reflections.texture };
            const [probes, size, firstRow] = scene.reflections.numbers;
            this.uniforms.hlReflections = { value: new Vector4(probes, size, 1, firstRow) };
        }
        if (volumes) {
            features.push('HL_VOLUMES');
            this.uniforms.hlVolumes = { value: volumes.texture };
        }
        this.ownSamplers = 1 + features.length;
        if (hasColoredMasks(data)) features.push('HL_COLORED_MASKS');
        this.uniforms.hlAreaLights = { value: [] };
        this.patches = new MaterialPatches(this.uniforms, [`HL_MASK_LAYERS ${data.maskLayers}`, ...features], scene.options.brdf === 'three', (...drawn) => scene.rowOf(...drawn));
    }

    /** Texture units of a fragment shader besides shadow maps: the plug-in's, three.js's table, the material's. */
    samplers() {
        let most = 0;
        for (const material of this.patches.patched.keys()) most = Math.max(most, texturesOf(material));
        return this.ownSamplers + 1 + most;
    }

    /** Texture units of a fragment shader. */
    units(renderer) {
        return renderer.capabilities.maxTextures;
    }

    /** @param {import('three').Mesh} mesh @param {boolean} fromFile whether the file or a clone holds it */
    patchMesh(mesh, fromFile) {
        for (const material of [mesh.material].flat()) if (material.isMeshStandardMaterial) this.patches.apply(material, fromFile);
    }

    /**
     * The lights' uniforms in three.js's order: those of each kind as the scene holds them, casters first, then those with
     * a texture (shadowCastingAndTexturingLightsFirst() in WebGLLights).
     * @param {any[]} lights in the scene's order @param {(light: any) => any} uniformsOf
     */
    setLights(lights, uniformsOf) {
        const rank = (light) => (light.castShadow ? 2 : 0) + (light.map ? 1 : 0);
        const sorted = [...lights].sort((a, b) => rank(b) - rank(a));
        for (const [name, kind] of [['hlPointLights', 'isPointLight'], ['hlSpotLights', 'isSpotLight'], ['hlDirectionalLights', 'isDirectionalLight']]) {
            const list = sorted.filter((light) => light[kind]).map((light) => lightOf(uniformsOf(light)));
            while (list.length < 32) list.push(NO_LIGHT); // a program may still hold more than are left
            this.uniforms[name].value = list;
        }
    }

    /** @param {any[]} lights what HalflightScene knows of each area light */
    setAreaLights(lights) {
        if (lights.length !== this.uniforms.hlAreaLights.value.length) this.patches.define('HL_AREA_LIGHTS', lights.length);
        this.uniforms.hlAreaLights.value = lights.map(({ position, range, color, halfX, halfY, isDisk, ...light }) => ({
            light: lightOf(light),
            place: new Vector4(...position, range), color, halfX, halfY, type: isDisk ? kLightDisk : kLightRectangle,
        }));
    }

    unpatch(material) {
        this.patches.remove(material);
    }

    /** Whether a material shows the bake. */
    shows(material) {
        return this.patches.patched.has(material);
    }

    makeSky() {
        return makeSky(this.uniforms);
    }

    /** @param {any} renderer @returns {boolean} whether the pages have all weights */
    compose(renderer) {
        if (!this.composer) return true;
        const isDone = this.composer.compose(renderer, this.scene.groups);
        this.uniforms.hlUnitLux.value = this.composer.unitLux;
        return isDone;
    }

    update() {
        const { scene, uniforms } = this;
        const { sky } = scene.field;
        [sky.gradient.zenith, sky.gradient.horizon, sky.gradient.ground].forEach((color, i) => uniforms.hlSky.value[i].set(...color));
        uniforms.hlSkySh.value.forEach((coefficient, i) => coefficient.fromArray(sky.radiance, 3 * i));
        uniforms.hlSkyFactor.value.set(...sky.factor);
        if (scene.reflections) uniforms.hlReflections.value.z = scene.reflections.unitNits;
        uniforms.hlMode.value = MODES.indexOf(scene.mode);
        uniforms.hlView.value = VIEWS.indexOf(scene.debugView);
        uniforms.hlShadow.value.set(scene.shadowDistance, scene.shadowFadeRange);
        uniforms.hlSkyFromWorld.value.setFromMatrix4(scene.shown.bakeFromWorld);
        uniforms.hlTable.value = scene.table.texture;
        uniforms.hlShadowColor.value.set(...scene.shadowColor);
    }

    dispose() {
        this.patches.dispose();
        this.composer?.dispose();
        for (const texture of this.textures) texture.dispose();
    }
}

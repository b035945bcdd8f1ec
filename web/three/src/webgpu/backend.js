// The bake as WebGPURenderer draws it: hooks on materials' lighting models. Materials stay the application's own.
import { AmbientLight, BackSide, BoxGeometry, Color, DoubleSide, Mesh, MeshPhysicalNodeMaterial, MeshStandardNodeMaterial, NodeMaterial, Object3D, LightsNode, Matrix3, MeshBasicNodeMaterial, Vector2, Vector3, Vector4 } from 'three/webgpu';
import { bool, context, diffuseColor, emissive, float, positionLocal, renderGroup, select, uniform, uniformArray, vec3, vec4 } from 'three/tsl';

import { makeComposer } from '../groups/composer.js';
import { kLightDisk, kLightRectangle, kNoCutoff } from '../generated/shading.js';
import { hlCoverageOf, hlPassedOf } from '../generated/shading.tsl.js';
import { hasColoredMasks } from '../scene/lights.js';
import { MODES, VIEWS } from '../scene/modes.js';
import { skyTexture, skyTurn } from '../scene/sky_picture.js';
import { arrayTexture, FORMATS } from '../scene/textures.js';
import { addLightOf, follow, glassOf, makePass } from '../scene/glass.js';
import { texturesOf } from '../scene/units.js';
import { WebGPUPageDraws } from './compose.js';
import { mirroredNormal, SceneNodes, skyNodes } from './nodes.js';

const HOOKS = ['setupLightingModel', 'setupNormal', 'setupOutput', 'contextNode', 'halflight', 'shadowSide'];
let scenes = 0;

const shared = (value, type) => uniform(value, type).setGroup(renderGroup);

/** Uniforms of one light. */
function lightUniforms() {
    return {
        flags: shared(new Vector4(-1, 0, 0, 1)), reach: shared(new Vector4()), cone: shared(new Vector4(0, 0, 0, -2)), own: shared(new Vector2(-1, 1)),
        position: shared(new Vector4()), axis: shared(new Vector3(0, -1, 0)), color: shared(new Color()), spot: shared(new Vector2()),
    };
}

/** Uniforms of one area light. */
function areaUniforms() {
    return {
        flags: shared(new Vector4(-1, 0, 0, 1)), reach: shared(new Vector4()), cone: shared(new Vector4(0, 0, 0, -2)), own: shared(new Vector2(-1, 1)),
        place: shared(new Vector4()), color: shared(new Color(0)), halfX: shared(new Vector3(1, 0, 0)), halfY: shared(new Vector3(0, 1, 0)), type: shared(kLightRectangle, 'int'),
    };
}

function setOwn(u, { flags, reach, cone, own }) {
    u.flags.value.set(...flags);
    u.reach.value.set(...reach);
    u.cone.value.set(...cone);
    u.own.value.set(...own);
}

const kindOf = (light) => (light.isDirectionalLight ? 'directional' : light.isSpotLight ? 'spot' : light.isPointLight ? 'point' : null);

/** Multiplies what is behind glass by what passes. */
function glassPass(glass) {
    const { blended, tinted, share } = glass;
    const pass = makePass(new MeshBasicNodeMaterial());
    pass.lights = false;
    pass.halflight = JSON.stringify(glass); // part of the program's key
    pass.setupOutput = () => vec4(hlPassedOf(diffuseColor.a, float(kNoCutoff), bool(blended), float(share), diffuseColor.rgb, bool(tinted), vec3(1)), 1);
    return pass;
}

/** Of a pass without lights. */
const noLights = new LightsNode();

export class WebGPUBackend {
    /** @param {import('../scene/scene.js').HalflightScene} scene */
    constructor(scene) {
        this.scene = scene;
        this.id = `scene ${++scenes}`;
        this.revision = 0; // of what the programs are made of
        const { data, table, volumes } = scene;
        const pages = (list, kind) => (list.length > 0 ? arrayTexture(list, FORMATS[kind]) : null);
        const colors = (list) => uniformArray(list.map((c) => new Vector3(c[0], c[1], c[2])), 'vec3');
        /** Makes the pages of light groups. */
        this.composer = makeComposer(data, WebGPUPageDraws);
        const composed = this.composer ?? { lightmaps: pages(data.lightmaps, 'rgb9e5'), directions: pages(data.directions, 'rgba8') };
        this.textures = { lightmaps: composed.lightmaps, directions: composed.directions, masks: pages(data.masks, 'rgba8'), skyPicture: data.sky.picture ? skyTexture(data.sky.picture.pixels) : null };
        const channels = (key) => Array.from({ length: data.maskLayers }, (_, k) => shared(new Vector4(...data.maskChannels.slice(4 * k, 4 * k + 4).map((c) => c[key]))));
        this.u = {
            ...this.textures,
            table: table.texture,
            volumes: volumes?.texture ?? null,
            reflectionPicture: scene.reflections?.texture ?? null,
            reflections: scene.reflections?.numbers ?? null,
            reflectionUnit: shared(1),
            mode: shared(0, 'int'),
            view: shared(0, 'int'),
            shadow: shared(new Vector2()),
            unitLux: shared(data.unitLux),
            shadowColor: shared(new Vector3()),
            sky: colors([data.sky.zenith, data.sky.horizon, data.sky.ground]),
            skySh: colors(Array.from({ length: 9 }, (_, i) => scene.field.sky.radiance.subarray(3 * i, 3 * i + 3))),
            skyFactor: shared(new Vector3(1, 1, 1)),
            skyTurn: shared(new Vector4(...(data.sky.picture ? skyTurn(data.sky.picture) : [1, 0, 0, 0]))),
            skyFromWorld: shared(new Matrix3()),
            maskLayers: data.maskLayers,
            coloredMasks: hasColoredMasks(data),
            maskRange: channels('rangeTexels'),
            maskPenumbra: channels('penumbraTexels'),
        };
        this.nodes = new SceneNodes(this.u, (object, drawn) => scene.rowOf(object, drawn));
        this.lights = new Map();
        this.areaLights = [];
        this.noLight = new AmbientLight(0x000000, 0); // without any light three.js leaves lighting out altogether
        this.noLight.clone = () => new Object3D();
        this.patched = new Map();
        /** By material of glass: what multiplies, and what takes its change back. */
        this.glass = new Map();
        // Lights with a shadow map reach the lighting model without their shadow, which the law applies.
        this.context = context(vec3(0), {
            getShadow: (lightNode, builder) => {
                (builder.halflightShadows ??= new Map()).set(lightNode.light, lightNode.shadowNode);
                return lightNode.baseColorNode;
            },
        });
    }

    uniformsOf(light) {
        if (!this.lights.has(light)) this.lights.set(light, lightUniforms());
        return this.lights.get(light);
    }

    /** @param {boolean} fromFile whether the file or a clone holds it @returns {(() => void) | undefined} what takes back the change of the mesh itself */
    patchMesh(mesh, fromFile) {
        const materials = [mesh.material].flat().filter((m) => m.isMeshStandardMaterial || m.isMeshStandardNodeMaterial);
        for (const material of materials) this.apply(material, fromFile);
        if (!materials.some((material) => this.glass.has(material))) return undefined;
        const own = Object.hasOwn(mesh, 'onBeforeRender') ? mesh.onBeforeRender : null;
        const before = mesh.onBeforeRender;
        mesh.onBeforeRender = (renderer, scene, camera, geometry, material, group) => {
            before.call(mesh, renderer, scene, camera, geometry, material, group);
            const pass = this.glass.get(material)?.pass;
            if (!pass || scene.overrideMaterial) return;
            follow(pass, material);
            renderer.renderObject(mesh, scene, camera, geometry, pass, group, noLights);
        };
        return () => {
            if (own) mesh.onBeforeRender = own;
            else delete mesh.onBeforeRender;
        };
    }

    /** @param {any} material @param {boolean} fromFile glass of the application is three.js's */
    apply(material, fromFile) {
        if (this.patched.has(material)) return;
        const before = Object.fromEntries(HOOKS.filter((name) => Object.hasOwn(material, name)).map((name) => [name, material[name]]));
        this.patched.set(material, before);
        const backend = this;
        const glass = fromFile ? glassOf(material) : null;
        if (glass) this.glass.set(material, { pass: glassPass(glass), undo: addLightOf(material) });
        const base = material.isMeshPhysicalMaterial || material.isMeshPhysicalNodeMaterial ? MeshPhysicalNodeMaterial : MeshStandardNodeMaterial;
        material.setupLightingModel = function (builder) {
            return backend.lightingModel(base.prototype.setupLightingModel.call(this, builder));
        };
        material.setupNormal = function (builder) {
            return mirroredNormal(this, builder) ?? base.prototype.setupNormal.call(this, builder);
        };
        material.setupOutput = function (builder, output) {
            const lit = base.prototype.setupOutput.call(this, builder, output);
            const shown = select(backend.u.view.equal(0), vec3(0), emissive); // views show no emission
            const alpha = glass ? hlCoverageOf(lit.a, float(kNoCutoff), bool(glass.blended), float(glass.share)) : lit.a;
            return vec4(lit.rgb.sub(shown), alpha);
        };
        material.contextNode = this.context;
        material.halflight = this.keyOf(material);
        material.shadowSide = DoubleSide;
        material.needsUpdate = true;
    }

    lightingModel(model) {
        const { nodes } = this;
        const { direct, indirect, finish } = model;
        const surfaceOf = (builder) => (builder.halflightSurface ??= nodes.surface(builder));
        model.direct = (data, builder) => {
            const { light } = data.lightNode;
            const kind = kindOf(light);
            if (!kind) return direct.call(model, data, builder);
            const s = surfaceOf(builder);
            const u = this.uniformsOf(light);
            const shadow = s.receive && light.castShadow ? builder.halflightShadows?.get(light) : null;
            const realtime = shadow ? vec3(shadow).x.toVar() : float(1);
            const { direction, illuminance } = nodes.sample(s, u, kind);
            const own = nodes.isOwn(s, u).toVar();
            if (this.scene.frameLights.mainLights.has(light)) (builder.halflightMain ??= []).push({ light: u, own, hasMap: Boolean(shadow), realtime });
            const counts = own.and(u.flags.z.toInt().bitAnd(8).greaterThan(0)).and(illuminance.length().greaterThan(0));
            builder.halflightOverlap = (builder.halflightOverlap ?? float(0)).add(counts.select(float(1), float(0)));
            const skipped = s.lightmapped.select(u.flags.z.toInt().bitAnd(1), u.flags.z.toInt().bitAnd(2)).greaterThan(0).or(own.not());
            const attenuation = nodes.attenuation(s, u, Boolean(shadow), realtime);
            const radiance = nodes.reflected(s, direction, illuminance.mul(attenuation));
            data.reflectedLight.directDiffuse.addAssign(skipped.select(vec3(0), radiance));
        };
        model.indirect = (builder) => {
            const s = surfaceOf(builder);
            for (const u of this.areaLights) {
                const { reached, radiance } = nodes.areaLight(s, u);
                const counts = u.flags.z.toInt().bitAnd(8).greaterThan(0).and(reached);
                builder.halflightOverlap = (builder.halflightOverlap ?? float(0)).add(counts.select(float(1), float(0)));
                builder.context.reflectedLight.directDiffuse.addAssign(radiance);
            }
            builder.context.reflectedLight.indirectDiffuse.addAssign(nodes.indirect(s, builder.halflightMain));
            indirect.call(model, builder);
        };
        model.finish = (builder) => {
            finish.call(model, builder);
            const { outgoingLight } = builder.context;
            outgoingLight.assign(nodes.debugView(surfaceOf(builder), outgoingLight, builder.halflightOverlap ?? float(0)));
        };
        return model;
    }

    setLights(lights, uniformsOf) {
        const position = new Vector3();
        const target = new Vector3();
        for (const light of lights) {
            if (!kindOf(light)) continue;
            const u = this.uniformsOf(light);
            setOwn(u, uniformsOf(light));
            position.setFromMatrixPosition(light.matrixWorld);
            u.position.value.set(position.x, position.y, position.z, (light.distance ?? 0) / u.own.value.y);
            if (light.target) u.axis.value.copy(target.setFromMatrixPosition(light.target.matrixWorld).sub(position).normalize());
            u.color.value.copy(light.color).multiplyScalar(light.intensity);
            if (light.isSpotLight) u.spot.value.set(Math.cos(light.angle * (1 - light.penumbra)), Math.cos(light.angle));
        }
    }

    /** @param {any[]} lights what HalflightScene knows of each area light, in its order */
    setAreaLights(lights) {
        if (lights.length !== this.areaLights.length) {
            this.areaLights = lights.map((_, i) => this.areaLights[i] ?? areaUniforms());
            this.recompile();
        }
        for (const [i, { position, range, color, halfX, halfY, isDisk, ...light }] of lights.entries()) {
            const u = this.areaLights[i];
            setOwn(u, light);
            u.place.value.set(...position, range);
            u.color.value.copy(color);
            u.halfX.value.copy(halfX);
            u.halfY.value.copy(halfY);
            u.type.value = isDisk ? kLightDisk : kLightRectangle;
        }
    }

    unpatch(material) {
        const before = this.patched.get(material);
        if (!before) return;
        this.patched.delete(material);
        this.glass.get(material)?.undo();
        this.glass.get(material)?.pass.dispose();
        this.glass.delete(material);
        for (const name of HOOKS) {
            if (Object.hasOwn(before, name)) material[name] = before[name];
            else delete material[name];
        }
        material.needsUpdate = true;
    }

    /** Whether a material shows the bake. */
    shows(material) {
        return this.patched.has(material);
    }

    makeSky() {
        const material = new NodeMaterial();
        Object.assign(material, { name: 'halflight sky', side: BackSide, depthTest: false, depthWrite: false, fog: false });
        Object.assign(material, skyNodes(this.u, positionLocal));
        const mesh = new Mesh(new BoxGeometry(2, 2, 2), material);
        Object.assign(mesh, { name: 'halflight sky', renderOrder: -1e9, frustumCulled: false, raycast: () => {}, clone: () => new Object3D() });
        return mesh;
    }

    /** Part of the program's key: another scene has other textures. */
    keyOf(material) {
        return `${this.id} ${this.revision} ${this.glass.get(material)?.pass.halflight ?? ''}`;
    }

    recompile() {
        this.revision += 1;
        for (const material of this.patched.keys()) {
            material.halflight = this.keyOf(material);
            material.needsUpdate = true;
        }
    }

    /** @param {any} renderer @returns {boolean} whether the pages have all weights */
    compose(renderer) {
        if (!this.composer) return true;
        const isDone = this.composer.compose(renderer, this.scene.groups);
        this.u.unitLux.value = this.composer.unitLux;
        return isDone;
    }

    update() {
        const { scene, u } = this;
        const { sky } = scene.field;
        [sky.gradient.zenith, sky.gradient.horizon, sky.gradient.ground].forEach((color, i) => u.sky.array[i].set(...color));
        u.skySh.array.forEach((coefficient, i) => coefficient.fromArray(sky.radiance, 3 * i));
        u.skyFactor.value.set(...sky.factor);
        if (scene.reflections) u.reflectionUnit.value = scene.reflections.unitNits;
        if (u.table !== scene.table.texture) {
            u.table = scene.table.texture; // it grew; programs hold the one before
            this.recompile();
        }
        u.skyFromWorld.value.setFromMatrix4(scene.shown.bakeFromWorld);
        u.mode.value = MODES.indexOf(scene.mode);
        u.view.value = VIEWS.indexOf(scene.debugView);
        u.shadow.value.set(scene.shadowDistance, scene.shadowFadeRange);
        u.shadowColor.value.set(...scene.shadowColor);
    }

    /** Texture units of a fragment shader besides shadow maps: the plug-in's, three.js's table, the material's. */
    samplers() {
        const own = ['lightmaps', 'directions', 'masks', 'skyPicture', 'table', 'volumes', 'reflectionPicture'].filter((name) => this.u[name]).length;
        let most = 0;
        for (const material of this.patched.keys()) most = Math.max(most, texturesOf(material));
        return own + 1 + most;
    }

    /** Texture units of a fragment shader. WebGPU's default is 16, whatever the device could do; a renderer may have no device yet. */
    units({ backend }) {
        const { gl, device } = backend;
        if (gl) return gl.getParameter(gl.MAX_TEXTURE_IMAGE_UNITS);
        return device ? Math.min(device.limits.maxSampledTexturesPerShaderStage, device.limits.maxSamplersPerShaderStage) : 16;
    }

    dispose() {
        for (const material of [...this.patched.keys()]) this.unpatch(material);
        this.noLight.removeFromParent();
        this.composer?.dispose();
        for (const texture of Object.values(this.textures)) texture?.dispose();
    }
}

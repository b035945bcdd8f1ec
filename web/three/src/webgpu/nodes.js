// The glue of webgl/*_text.js as nodes of WebGPURenderer. Formulas are the headers', by generated/shading.tsl.js.
import { BackSide, DoubleSide, RGBAFormat, TangentSpaceNormalMap } from 'three';
import {
    If, Loop, attribute, cameraPosition, cameraProjectionMatrix, cameraViewMatrix, dFdx, dFdy, diffuseColor, faceDirection, float, int, ivec2, mat4,
    materialMetalness, materialReference, materialRoughness, materialSpecularIntensity, mix, normalMap, normalView, normalViewGeometry, positionViewDirection,
    positionWorld, reflect, select, texture, texture3D, textureLoad, uniform, varying, vec2, vec3, vec4, instanceIndex,
} from 'three/tsl';

import { kReflectionLevels } from '../generated/shading.js';
import * as hl from '../generated/shading.tsl.js';
import { slabsOf } from '../scene/volumes.js';
import { COLUMNS, ROWS } from '../webgl/table_text.js';

const REALTIME = 0;
const SUBTRACTIVE = 4;

const toWorld = (v) => vec4(v, 0).mul(cameraViewMatrix).xyz.normalize();
/** Component `index` of a vec4, which is no constant. */
const component = (v, index) => select(index.equal(0), v.x, select(index.equal(1), v.y, select(index.equal(2), v.z, v.w)));

/** A vertex's normal on the side that is seen. three.js has a function of two names for it, one before 0.185. */
function towardsSeen(normal, { side }) {
    if (side === BackSide) return normal.negate();
    return side === DoubleSide ? normal.mul(faceDirection) : normal;
}

const handedness = uniform(1).onObjectUpdate(({ object }) => (object.matrixWorld.determinant() < 0 ? -1 : 1));

/**
 * The normal by a material's texture with the bitangents of the mirrored surface, as in the program; three.js's are those
 * of the surface before. Null where three.js's normal is right.
 */
export function mirroredNormal({ normalMap: map, normalMapType, normalNode }, { geometry }) {
    if (!map || normalNode || normalMapType !== TangentSpaceNormalMap || map.format !== RGBAFormat || !geometry.hasAttribute('tangent')) return null;
    return normalMap(materialReference('normalMap', 'texture'), materialReference('normalScale', 'vec2').mul(vec2(1, handedness)));
}

/** Nodes that a scene's materials share. */
export class SceneNodes {
    /** @param {any} u uniforms and textures: see WebGPUBackend @param {(object: any, scene: any) => number} rowOf */
    constructor(u, rowOf) {
        this.u = u;
        this.row = uniform(0, 'int').onObjectUpdate(({ object, scene }) => rowOf(object, scene));
    }

    cell(row, column) {
        const whole = int(row); // before 0.187 max() of an integer and a number is no integer
        const x = whole.div(int(ROWS)).mul(int(COLUMNS)).add(int(column));
        return textureLoad(this.u.table, ivec2(x, whole.mod(int(ROWS))));
    }

    bakeFromWorld(row) {
        const place = this.cell(row, 1).w.toInt().toVar();
        return mat4(this.cell(place, 0), this.cell(place, 1), this.cell(place, 2), this.cell(place, 3));
    }

    /** Whether a light belongs to no other clone of the file than a surface. */
    isOwn(s, light) {
        return light.own.x.lessThan(0).or(light.own.x.toInt().equal(s.place));
    }

    /** The fragment as lights see it: HlSurface of surface_text.js. */
    surface(builder) {
        const { u } = this;
        const { object, geometry, material } = builder;
        const s = {};
        const row = object.isInstancedMesh ? varying(this.row.add(int(instanceIndex)).toFloat()).add(0.5).toInt() : this.row;
        s.row = row.toVar();
        const info = this.cell(s.row, 1).toVar();
        s.lightmapped = info.x.greaterThan(0.5).toVar();
        s.page = int(info.y.add(0.5));
        s.volume = int(info.z).toVar();
        s.place = info.w.toInt().toVar();
        s.bakeFromWorld = this.bakeFromWorld(s.row).toVar();
        s.toBake = (v) => s.bakeFromWorld.mul(vec4(v, 0)).xyz;
        const ofView = (v) => s.toBake(toWorld(v)).normalize();
        s.position = s.bakeFromWorld.mul(vec4(positionWorld, 1)).xyz.toVar();
        s.normal = ofView(normalView).toVar();
        s.vertexNormal = ofView(towardsSeen(normalViewGeometry, material)).toVar();
        s.side = faceDirection;
        s.view = ofView(positionViewDirection).toVar();
        s.fade = hl.hlShadowFade(s.bakeFromWorld.mul(vec4(cameraPosition, 1)).xyz.sub(s.position).length(), hl.hlFadeConstants(u.shadow.x, u.shadow.y)).toVar();
        s.receive = object.receiveShadow;
        s.baseColor = diffuseColor.rgb;
        s.metallic = materialMetalness.clamp();
        s.roughness = materialRoughness.clamp().toVar();
        s.specular = material.isMeshPhysicalNodeMaterial || material.isMeshPhysicalMaterial ? materialSpecularIntensity : float(1);
        s.uv = null;
        if (geometry.hasAttribute('hlLightmapUv')) {
            const place = this.cell(s.row, 0);
            s.uv = attribute('hlLightmapUv', 'vec2').mul(place.xy).add(place.zw).toVar();
        }
        s.baked = Array.from({ length: u.maskLayers }, (_, layer) => {
            const mask = s.uv && u.masks ? this.mask(s, layer) : vec4(1);
            return select(s.lightmapped, mask, this.probeOcclusion(s, layer)).toVar();
        });
        return s;
    }

    mask(s, layer) {
        const { u } = this;
        const stored = texture(u.masks, s.uv).depth(s.page.mul(int(u.maskLayers)).add(int(layer))).level(0);
        const { width, height } = u.masks.image;
        const across = (d) => d.mul(vec2(width, height)).length();
        const footprint = across(dFdx(s.uv)).max(across(dFdy(s.uv)));
        const decode = (c) => hl.hlDecodeMask(stored[c], u.maskRange[layer][c], u.maskPenumbra[layer][c], footprint);
        return vec4(decode('x'), decode('y'), decode('z'), decode('w'));
    }

    volumeTexture(s, slab) {
        const row = s.volume.max(0);
        const slabFromWorld = mat4(this.cell(row, 0), this.cell(row, 1), this.cell(row, 2), this.cell(row, 3));
        const at = slabFromWorld.mul(vec4(s.position, 1)).xyz.clamp(this.cell(row, 4).xyz, this.cell(row, 5).xyz);
        return texture3D(this.u.volumes, at.add(vec3(0, 0, slab / slabsOf(4 * this.u.maskLayers)))).level(0);
    }

    probeOcclusion(s, layer) {
        const own = this.cell(s.row, layer === 0 ? 2 : 11 + layer);
        return this.u.volumes ? select(s.volume.greaterThanEqual(0), this.volumeTexture(s, layer === 0 ? 3 : 7 + layer), own) : own;
    }

    /** B of a channel. @param {any} channel a node */
    bakedOf(s, channel) {
        const ofLayer = (layer) => component(s.baked[layer], channel.sub(int(4 * layer)));
        return s.baked.reduceRight((rest, _, layer) => (rest ? select(channel.lessThan(4 * layer + 4), ofLayer(layer), rest) : ofLayer(layer)), null);
    }

    /** B by colour of a light; all alike where its mask is grey. @param {any} light uniforms of one light */
    bakedByColor(s, light) {
        const channel = int(light.flags.x.max(0));
        const layer = s.baked.reduceRight((rest, own, k) => (rest ? select(channel.lessThan(4 * k + 4), own, rest) : own), null);
        return select(light.flags.z.toInt().bitAnd(16).greaterThan(0), layer.rgb, vec3(this.bakedOf(s, channel)));
    }

    /** Irradiance from the object's probes. */
    probeIrradiance(s, n) {
        const weight = (i) => hl.hlShIrradianceWeight(int(i), n);
        let own = vec3(0);
        for (let i = 0; i < 9; ++i) own = own.add(this.cell(s.row, 3 + i).rgb.mul(weight(i)));
        if (!this.u.volumes) return own.max(0);
        const low = vec4(weight(0), weight(1), weight(2), weight(3));
        const high = vec4(weight(4), weight(5), weight(6), weight(7));
        const channel = (c) => this.volumeTexture(s, c).dot(low).add(this.volumeTexture(s, 4 + c).dot(high));
        const volume = vec3(channel(0), channel(1), channel(2)).add(this.volumeTexture(s, 7).rgb.mul(weight(8)));
        return select(s.volume.greaterThanEqual(0), volume.mul(this.cell(s.volume.max(0), 4).w), own).max(0);
    }

    skyIrradiance(n) {
        let sum = vec3(0);
        for (let i = 0; i < 9; ++i) sum = sum.add(this.u.skySh.element(i).mul(hl.hlShIrradianceWeight(int(i), n)));
        return sum.max(0);
    }

    /** B of a light where its mask says `baked`. @param {any} light uniforms of one light @param {any} baked a node */
    withinReach(s, light, baked) {
        const fromLight = s.position.sub(light.reach.xyz);
        const distance = fromLight.length().max(1e-6);
        const cosAngle = fromLight.dot(light.cone.xyz).div(distance);
        return hl.hlBakedWithinReach(baked, distance, light.reach.w, cosAngle, light.cone.w);
    }

    /** Irradiance on a surface that faces the light, without shadow, and its direction. */
    sample(s, light, kind) {
        if (kind === 'directional') return { direction: s.toBake(light.axis.negate()).normalize(), illuminance: light.color };
        const toLight = light.position.xyz.sub(positionWorld).toVar();
        const distance = toLight.length().div(light.own.y).max(1e-6); // in the light's own metres
        const direction = toLight.normalize().toVar();
        let attenuation = hl.hlDistanceAttenuation(distance, light.position.w);
        if (kind === 'spot') {
            const constants = hl.hlSpotConstantsOfCosines(light.spot.x, light.spot.y);
            attenuation = attenuation.mul(hl.hlSpotAttenuation(direction.negate().dot(light.axis), constants));
        }
        return { direction: s.toBake(direction).normalize(), illuminance: light.color.mul(attenuation) };
    }

    attenuation(s, light, hasMap, realtime) {
        if (!s.receive) return float(1);
        const hasBaked = light.flags.x.greaterThanEqual(0);
        const has = hasMap ? light.flags.y.greaterThan(0.5) : float(0).greaterThan(0.5);
        if (this.u.coloredMasks) {
            const byColor = this.bakedByColor(s, light).max(vec3(this.withinReach(s, light, float(0))));
            return hl.hlMixShadowsByColor(this.u.mode, hasBaked, byColor, has, realtime, s.fade, light.flags.w);
        }
        const baked = this.withinReach(s, light, this.bakedOf(s, int(light.flags.x.max(0))));
        return hl.hlMixShadows(this.u.mode, hasBaked, baked, has, realtime, s.fade, light.flags.w);
    }

    /** An area light, without a shadow map: whether its light reaches the fragment, and radiance towards the camera. */
    areaLight(s, u) {
        const own = this.isOwn(s, u);
        const toCenter = s.bakeFromWorld.mul(vec4(u.place.xyz, 1)).xyz.sub(s.position).toVar();
        const halfX = s.toBake(u.halfX).toVar();
        const halfY = s.toBake(u.halfY).toVar();
        const radiance = u.color.mul(hl.hlRangeWindow(toCenter.dot(toCenter), u.place.w)).toVar();
        const reached = own.and(toCenter.dot(halfX.cross(halfY)).greaterThan(0)).and(radiance.length().greaterThan(0));
        const reflected = hl.hlReflectAreaLight(s.baseColor, s.metallic, s.roughness, s.specular, s.normal, s.view, u.type, toCenter, halfX, halfY, radiance);
        const skipped = s.lightmapped.select(u.flags.z.toInt().bitAnd(1), u.flags.z.toInt().bitAnd(2)).greaterThan(0);
        const lit = reflected.mul(this.attenuation(s, u, false, float(1)));
        return { reached, radiance: select(reached.and(skipped.not()), lit, vec3(0)) };
    }

    reflected(s, direction, light) {
        return hl.hlReflectLight(s.baseColor, s.metallic, s.roughness, s.specular, s.normal, s.view, direction, light);
    }

    lightmap(s) {
        if (!s.uv || !this.u.lightmaps) return vec3(0);
        return texture(this.u.lightmaps, s.uv).depth(s.page).level(0).rgb.mul(this.u.unitLux);
    }

    /** Lightmap less what dynamic objects keep from it of the main light, one for each clone of the file. @param {any[]} mains see WebGPUBackend */
    subtracted(s, mains) {
        const lightmap = this.lightmap(s).toVar();
        if (!mains || !s.receive) return lightmap;
        return mains.reduce((rest, main) => select(main.own, this.subtractedOf(s, main, lightmap), rest), lightmap);
    }

    subtractedOf(s, { light, hasMap, realtime }, lightmap) {
        const irradiance = light.color.mul(s.vertexNormal.dot(s.toBake(light.axis.negate()).normalize()).clamp());
        const has = hasMap ? light.flags.y.greaterThan(0.5) : float(0).greaterThan(0.5);
        const faded = hl.hlMixShadowsFullStrength(this.u.mode, float(0).greaterThan(0.5), float(1), has, realtime, s.fade);
        const hasBaked = light.flags.x.greaterThanEqual(0);
        const rest = [faded, this.u.shadowColor, light.flags.w];
        const result = this.u.coloredMasks
            ? hl.hlSubtractiveIrradianceByColor(lightmap, irradiance, select(hasBaked, this.bakedByColor(s, light), vec3(1)), ...rest)
            : hl.hlSubtractiveIrradiance(lightmap, irradiance, select(hasBaked, this.bakedOf(s, int(light.flags.x.max(0))), float(1)), ...rest);
        return select(this.u.mode.equal(SUBTRACTIVE).and(int(light.flags.z).bitAnd(4).greaterThan(0)), result, lightmap);
    }

    lightmapScale(s, normal) {
        if (!s.uv || !this.u.directions) return float(1);
        const direction = hl.hlDecodeMeanDirection(texture(this.u.directions, s.uv).depth(s.page).level(0).rgb);
        return hl.hlDirectionalIrradianceScale(direction, s.vertexNormal.mul(s.side), normal.mul(s.side));
    }

    lightmapSpecularScale(s, lobe) {
        if (!s.uv || !this.u.directions) return float(1);
        const direction = hl.hlDecodeMeanDirection(texture(this.u.directions, s.uv).depth(s.page).level(0).rgb);
        const [baked, normal, view, towards] = [s.vertexNormal, s.normal, s.view, lobe].map((v) => v.mul(s.side));
        return hl.hlDirectionalSpecularScale(direction, baked, normal, view, towards, s.roughness);
    }

    /** How far reflection probes serve this place better than the lightmap's own directions. */
    reflectionTrust(s) {
        if (!s.uv || !this.u.directions) return float(1);
        return select(s.lightmapped, texture(this.u.directions, s.uv).depth(s.page).level(0).a, float(1));
    }

    /** Radiance that a lobe of this roughness about a direction meets, by one probe. */
    reflectionOf(s, probe, direction, roughness) {
        const size = this.u.reflections[1];
        const { width, height } = this.u.reflectionPicture.image;
        const inBox = probe.boxFromWorld.mul(vec4(s.position, 1)).xyz;
        const towards = probe.boxFromWorld.mul(vec4(direction, 0)).xyz;
        const at = hl.hlLookUpReflection(s.position, direction, inBox, towards, probe.place.xyz, roughness).toVar();
        const level = hl.hlReflectionLevel(at.w).toVar();
        const low = int(level).min(kReflectionLevels - 2).toVar();
        const texel = (l) => {
            const place = hl.hlReflectionTexel(int(size), l, at.xyz).add(vec2(0, int(probe.index).mul(hl.hlReflectionTileHeight(int(size))).toFloat()));
            return texture(this.u.reflectionPicture, place.div(vec2(width, height))).level(0).rgb;
        };
        return mix(texel(low), texel(low.add(1)), level.sub(low.toFloat()));
    }

    /** What the probes make of a surface's own surroundings: hlReflected() of indirect_text.js. */
    withReflections(s, surroundings, local) {
        const [count, , first] = this.u.reflections;
        const mirror = reflect(s.view.negate(), s.normal).toVar();
        const radiance = vec3(0).toVar();
        const expected = vec3(0).toVar();
        const left = float(1).toVar();
        const weights = float(0).toVar();
        Loop(count, ({ i }) => {
            const row = int(i).add(first).toVar();
            const boxFromWorld = mat4(this.cell(row, 0), this.cell(row, 1), this.cell(row, 2), this.cell(row, 3)).toVar();
            const place = this.cell(row, 4).toVar();
            const inBox = boxFromWorld.mul(vec4(s.position, 1)).xyz;
            const weight = left.mul(hl.hlReflectionCoverage(inBox, this.cell(row, 5).xyz, place.w)).toVar();
            left.subAssign(weight);
            If(weight.greaterThan(0), () => {
                const probe = { index: i, boxFromWorld, place };
                radiance.addAssign(this.reflectionOf(s, probe, mirror, s.roughness).mul(weight));
                expected.addAssign(this.reflectionOf(s, probe, s.normal, float(1)).mul(weight));
                weights.addAssign(weight);
            });
        });
        const scale = this.u.reflectionUnit.div(weights.max(1e-20));
        return hl.hlReflectedSurroundings(radiance.mul(scale), expected.mul(scale), weights, this.reflectionTrust(s), surroundings, local, s.roughness);
    }

    /** Radiance of light without single directions. */
    indirect(s, main) {
        const openSky = this.u.mode.equal(REALTIME);
        const lobe = hl.hlSpecularLookup(s.view, s.normal, s.roughness).toVar();
        const lightmap = this.subtracted(s, main).toVar();
        const at = (n, scale) => {
            const probes = select(s.lightmapped, lightmap.mul(scale), this.probeIrradiance(s, n));
            return select(openSky, this.skyIrradiance(n), probes);
        };
        const irradiance = at(s.normal, this.lightmapScale(s, s.normal)).toVar();
        const own = at(lobe, this.lightmapSpecularScale(s, lobe)).mul(1 / Math.PI).toVar();
        const around = this.u.reflectionPicture ? select(openSky, own, this.withReflections(s, own, irradiance.mul(1 / Math.PI))).toVar() : own;
        const mirror = skyTowards(this.u, reflect(s.view.negate(), s.normal), s.roughness);
        const surroundings = select(openSky, mix(mirror, around, s.roughness), around);
        const nDotV = s.normal.dot(s.view).abs().clamp(1e-4, 1);
        return hl.hlReflectIndirect(s.baseColor, s.metallic, s.roughness, s.specular, nDotV, irradiance, surroundings);
    }

    /** @param {any} lit the picture's radiance @param {any} overlap lights with a channel, or that lost theirs, that reach the fragment */
    debugView(s, lit, overlap) {
        const { view } = this.u;
        const all = s.baked.reduce((mask, layer) => mask.min(layer)); // mask layers
        const mask = all.rgb.mul(mix(float(0.5), float(1), all.a));
        const lightmap = select(s.lightmapped, this.lightmap(s).mul(1 / Math.PI), vec3(0));
        const probes = this.probeIrradiance(s, s.normal).mul(1 / Math.PI);
        const ramp = [vec3(0), vec3(0, 0, 1), vec3(0, 1, 0), vec3(1, 1, 0), vec3(1, 0, 0), vec3(1)];
        const count = ramp.reduceRight((rest, color, i) => (rest ? select(overlap.lessThan(i + 0.5), color, rest) : color), null);
        const numbers = select(view.equal(3), probes, select(view.equal(4), vec3(s.fade), count));
        const other = select(view.equal(1), mask, select(view.equal(2), lightmap, numbers));
        return select(view.equal(0), lit, other);
    }
}

/** Radiance of the sky from a unit direction, in a mirror of this roughness. @param {any} d @param {any} roughness */
function skyTowards(u, d, roughness) {
    if (!u.skyPicture) return hl.hlSkyRadiance(u.sky.element(0), u.sky.element(1), u.sky.element(2), d);
    const level = hl.hlSkyPictureLevel(roughness, u.skyTurn.z);
    return texture(u.skyPicture, hl.hlSkyPictureUv(d, u.skyTurn.xy)).level(level).rgb.mul(u.skyTurn.w).mul(u.skyFactor);
}

/** Nodes of the sky: where a box around the camera is drawn, and its colour. No fragmentNode: with that three.js writes the first of a pass's outputs alone. */
export function skyNodes(u, position) {
    const clip = cameraProjectionMatrix.mul(vec4(cameraViewMatrix.mul(vec4(position, 0)).xyz, 1));
    const radiance = skyTowards(u, u.skyFromWorld.mul(position).normalize(), float(0));
    return { vertexNode: clip, colorNode: vec4(select(u.view.equal(0), radiance, vec3(0)), 1) };
}

// Lights of the file: what the bake made of each, and what a frame does with it.
import { Vector3 } from 'three';

import { distanceAttenuation, modeUsesBakedShadows, staticCastersInShadowMap } from '../generated/shading.js';
import { MODES } from './modes.js';
import { checkNumber } from './warnings.js';

const NO_CONE = -2;
export const SKIP_LIGHTMAPPED = 1;
export const SKIP_OTHERS = 2;
export const MAIN_LIGHT = 4;
export const OVERLAPS = 8;
export const COLORED_MASK = 16;

/** Whether a light's mask has a colour. @param {import('../file/read.js').BakedData} data */
export const hasColoredMasks = (data) => [...data.lights.values()].some((light) => light.coloredMask);

/** Relative change from which on a light counts as another than that of its bake. */
export const CHANGED = 1e-3;

const unbaked = {
    castShadows: true, shadowStrength: 1, shadowBias: {}, isBaked: false, bakeType: 'realtime', channel: -1, coloredMask: false, reason: '',
    worldFromLight: [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1], reach: 0, outerCone: Math.PI / 2, group: -1, white: [0, 0, 0],
};

/** Texels of a shadow map's side, as far as the application left three.js's default. */
function mapSize(light) {
    if (light.isDirectionalLight) return 4096;
    return light.isSpotLight ? 1024 : 512;
}

const CAMERA = ['left', 'right', 'top', 'bottom', 'near', 'far'];

/** What the plug-in changes of a light. */
function stateOf({ castShadow, layers, shadow }) {
    if (!shadow) return { castShadow, layers: layers.mask };
    const { camera, mapSize, bias, normalBias } = shadow;
    const planes = Object.fromEntries(CAMERA.filter((key) => key in camera).map((key) => [key, camera[key]]));
    return { castShadow, layers: layers.mask, shadowLayers: camera.layers.mask, mapSize: mapSize.clone(), bias, normalBias, planes };
}

export class BakedLight {
    #own = { castShadows: true, shadowStrength: 1 };

    /**
     * @param {any} light three's @param {import('../file/read.js').LightData | undefined} data @param {string} name
     * @param {import('./instances.js').Instance | null} instance whose bake it belongs to
     * @param {BakedLight | null} original of a clone, which has its switches
     */
    constructor(light, data, name, instance = null, original = null) {
        this.light = light;
        this.name = name;
        this.instance = instance;
        this.original = original;
        this.data = data ?? unbaked;
        this.#own = { castShadows: this.data.castShadows, shadowStrength: this.data.shadowStrength };
        /** Its range in metres of the file, and what the plug-in made of it. */
        this.range = original && light.distance === original.scaledRange ? original.range : light.distance;
        this.scaledRange = light.distance;
        /** Whether a texture unit is left for its shadow map. */
        this.mapAllowed = true;
        this.plan = { channel: -1, staticCasters: true, flags: 0, drawn: true, casts: true };
        /** What the plug-in changes of it, as it was; a clone has the original's changes. */
        this.before = original?.before ?? stateOf(light);
        const size = light.shadow?.mapSize;
        if (instance && size?.x === 512 && size.y === 512) size.setScalar(mapSize(light)); // three.js's default
        this.mapSize = size?.clone();
        /** Its light group, whose weight its colour times intensity follows, or null. @type {any} */
        this.group = original?.group ?? null;
        this.atLoad = this.bounce();
        const m = this.data.worldFromLight;
        this.bakedPosition = [m[12], m[13], m[14]];
        this.bakedAxis = new Vector3(-m[8], -m[9], -m[10]).normalize().toArray();
    }

    /** Whether it casts any shadow, baked or realtime. */
    get castShadows() {
        return (this.original ?? this).#own.castShadows;
    }
    set castShadows(casts) {
        if (typeof casts !== 'boolean') throw new Error(`castShadows of light "${this.name}" is ${casts}: it is true or false`);
        (this.original ?? this).#own.castShadows = casts;
    }

    /** 0…1, applied once, after mixing. */
    get shadowStrength() {
        return (this.original ?? this).#own.shadowStrength;
    }
    set shadowStrength(strength) {
        (this.original ?? this).#own.shadowStrength = checkNumber(`shadowStrength of light "${this.name}"`, strength, '', 0, 1);
    }

    get scale() {
        return this.instance?.scale ?? 1;
    }

    /** three.js has ranges in metres of the world. */
    scaleRange() {
        const { light } = this;
        if (!light.isPointLight && !light.isSpotLight) return;
        if (light.distance !== this.scaledRange) this.range = light.distance; // by the application
        this.scaledRange = light.distance = this.range * this.scale;
    }

    get isArea() {
        return this.light.isHalflightAreaLight === true;
    }

    get isMixed() {
        return this.data.isBaked && this.data.bakeType === 'mixed';
    }

    power() {
        const { r, g, b } = this.light.color;
        return (0.2126 * r + 0.7152 * g + 0.0722 * b) * this.light.intensity * (this.isArea ? this.light.area() : 1);
    }

    /** Illuminance that it may bring to where the camera is, nearer than a metre counting as a metre. */
    importance(camera) {
        if (this.light.isDirectionalLight) return this.power();
        const position = new Vector3().setFromMatrixPosition(this.light.matrixWorld);
        const distance = Math.max(position.distanceTo(new Vector3().setFromMatrixPosition(camera.matrixWorld)) / this.scale, 1);
        return this.power() * distanceAttenuation(distance, 0);
    }

    /** What the mode makes of the light: docs/conventions.md, "Who is lit by what". @param {string} mode @param {boolean} isMainLight @param {string} view */
    planFor(mode, isMainLight, view) {
        const number = MODES.indexOf(mode);
        const usesBake = mode !== 'realtime';
        const subtractive = mode === 'subtractive';
        const mixed = usesBake && this.isMixed;
        const inLightmap = subtractive && mixed; // direct light too
        const casts = this.castShadows && this.shadowStrength > 0;
        const hasBaked =
            mixed && casts && modeUsesBakedShadows(number) && this.data.channel >= 0 && (!subtractive || isMainLight);
        const fullyBaked = usesBake && this.data.isBaked && this.data.bakeType === 'baked';
        const overflowed = fullyBaked && this.data.reason !== ''; // it is in the frame for the overlap view alone
        this.plan = {
            channel: hasBaked ? this.data.channel : -1,
            staticCasters: staticCastersInShadowMap(number, hasBaked || inLightmap),
            flags:
                (inLightmap ? SKIP_LIGHTMAPPED : 0) | (fullyBaked ? SKIP_LIGHTMAPPED | SKIP_OTHERS : 0) | (subtractive && isMainLight ? MAIN_LIGHT : 0) |
                (hasBaked || overflowed ? OVERLAPS : 0) | (hasBaked && this.data.coloredMask ? COLORED_MASK : 0),
            drawn: !fullyBaked || (overflowed && view === 'overlap'),
            casts: casts && !fullyBaked,
        };
    }

    /** Uniforms of the light; `hasMap`: it has a shadow map this frame. */
    uniforms(hasMap) {
        const outside = this.isArea ? 0 : NO_CONE; // behind an area light B is 1
        return {
            flags: [this.plan.channel, hasMap ? 1 : 0, this.plan.flags, this.castShadows ? this.shadowStrength : 0],
            reach: [...this.bakedPosition, this.light.isDirectionalLight ? 0 : this.data.reach],
            cone: [...this.bakedAxis, this.light.isSpotLight ? Math.cos(this.data.outerCone) : outside],
            own: [this.instance?.row ?? -1, this.scale],
        };
    }

    /** A sentence where the light stands elsewhere in its file than at its bake, else null. */
    moved() {
        if (!this.isMixed || this.data.channel < 0) return null;
        const m = this.light.matrixWorld.clone().premultiply(this.instance.bakeFromWorld).elements;
        const position = new Vector3(m[12], m[13], m[14]);
        const axis = new Vector3(-m[8], -m[9], -m[10]).normalize();
        const shifted = !this.light.isDirectionalLight && position.distanceTo(new Vector3(...this.bakedPosition)) > 1e-3;
        const turned = !this.light.isPointLight && axis.angleTo(new Vector3(...this.bakedAxis)) > 1e-3;
        return shifted || turned ? `light "${this.name}" moved since its bake: its baked shadows and bounced light stay behind` : null;
    }

    /** Whether neither it nor a node above it in its file is hidden. */
    isShown() {
        for (let object = this.light; object && object !== this.instance?.object; object = object.parent) if (!object.visible) return false;
        return true;
    }

    /** Colour times intensity, 0 where it is hidden. */
    shining() {
        const { color, intensity } = this.light;
        const lit = this.isShown() ? intensity : 0;
        return [lit * color.r, lit * color.g, lit * color.b];
    }

    /** Colour times intensity that its baked light fits. */
    expected() {
        return this.group ? this.data.white.map((x, c) => x * this.group.rgb[c]) : this.atLoad.slice(0, 3);
    }

    /** What its bounced light was made of: power by channel, range and cone. */
    bounce() {
        const { light } = this;
        return [...this.shining(), this.isArea ? light.range : (this.range ?? 0), light.angle ?? 0, light.penumbra ?? 0, light.width ?? 0, light.height ?? 0];
    }

    /** A sentence where its bounced light, which is baked, is that of another light, else null. */
    changed() {
        if (!this.data.isBaked || this.data.bakeType === 'realtime') return null;
        const now = this.bounce();
        const then = [...this.expected(), ...this.atLoad.slice(3)];
        const largest = Math.max(...then.slice(0, 3));
        const differs = now.some((x, i) => Math.abs(x - then[i]) > CHANGED * (i < 3 ? largest : Math.max(Math.abs(then[i]), 1)));
        if (!differs) return null;
        if (this.group && now.slice(3).every((x, i) => Math.abs(x - then[3 + i]) <= CHANGED * Math.max(Math.abs(x), 1)))
            return `light "${this.name}" changed by itself: its baked light is that of all of light group "${this.group.data.name}"; change its lights by one factor, or use setLightGroup()`;
        const part = this.data.bakeType === 'baked' ? 'all its light' : 'its bounced light';
        return `light "${this.name}" changed since its bake: ${part} stays as it was baked; bake again for another`;
    }

    restore() {
        const { light, before } = this;
        light.castShadow = before.castShadow;
        light.layers.mask = before.layers;
        if (light.distance === this.scaledRange && this.range !== undefined) light.distance = this.range;
        if (this.isArea && (!this.original || light.parent?.userData.halflight?.isAreaLight)) light.removeFromParent();
        const { shadow } = light;
        if (!shadow) return;
        shadow.camera.layers.mask = before.shadowLayers;
        Object.assign(shadow.camera, before.planes).updateProjectionMatrix();
        Object.assign(shadow, { bias: before.bias, normalBias: before.normalBias });
        if (shadow.mapSize.equals(this.mapSize)) shadow.mapSize.copy(before.mapSize); // else the application chose another
        shadow.dispose(); // its map has the plug-in's size
        shadow.map = null;
    }
}

/** Subtractive's main light: the mixed directional light of channel 0; if none has it, the brightest. */
export function findMainLight(lights) {
    const candidates = lights.filter((l) => l.light.isDirectionalLight && l.isMixed && l.power() > 0);
    return candidates.find((l) => l.data.channel === 0) ?? candidates.sort((a, b) => b.power() - a.power())[0] ?? null;
}

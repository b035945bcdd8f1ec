// Adds pages of light groups up with WebGPURenderer, as webgl/compose.js does.
import { CustomBlending, HalfFloatType, LinearFilter, NearestFilter, NoBlending, NodeMaterial, OneFactor, QuadMesh, RendererUtils, REVISION, RenderTarget, UnsignedByteType, Vector3 } from 'three/webgpu';
import { int, texture, uniform, uv, vec3, vec4 } from 'three/tsl';

import * as hl from '../generated/shading.tsl.js';
import { planDraws } from '../groups/pages.js';
import { arrayTexture, FORMATS } from '../scene/textures.js';

/** Layer of an array texture where the quad is drawn. */
const layerOf = (array, layer) => texture(array, uv()).depth(int(layer)).level(0);

function makeMaterial(fragmentNode, isFirst) {
    const blending = isFirst ? NoBlending : CustomBlending;
    return Object.assign(new NodeMaterial(), { fragmentNode, blending, blendSrc: OneFactor, blendDst: OneFactor, depthTest: false, depthWrite: false, fog: false });
}

/** Layers of a target at least: before 0.187 three.js draws into no array of one layer on WebGL 2. */
const LEAST_LAYERS = Number.parseInt(REVISION, 10) < 187 ? 2 : 1;

/** Layers that are drawn into one by one and read as one array texture. */
function makeTarget(width, height, layers, type) {
    const target = new RenderTarget(width, height, { depth: Math.max(layers, LEAST_LAYERS), depthBuffer: false, type, minFilter: LinearFilter, magFilter: LinearFilter });
    target.texture.isArrayTexture = true; // of one layer too
    return target;
}

export class WebGPUPageDraws {
    /** @param {import('../file/read.js').BakedData} data @param {import('../groups/pages.js').LightSource[]} sources */
    constructor(data, sources) {
        const { width, height } = data.lightmaps[0];
        const pages = data.lightmaps.length;
        const textures = (list, kind) => list.map((all) => (all.some(Boolean) ? Object.assign(arrayTexture(all.filter(Boolean), FORMATS[kind]), { minFilter: NearestFilter, magFilter: NearestFilter }) : null));
        this.lights = textures(sources.map((s) => s.lightmaps), 'rgb9e5');
        this.towards = textures(sources.map((s) => s.directions), 'rgba8');
        this.light = makeTarget(width, height, pages, HalfFloatType);
        this.lightmaps = this.light.texture;
        this.directions = null;
        this.lightDraws = planDraws(sources, 'lightmaps').map((plan) => this.#draw(plan, false));
        this.momentDraws = [];
        this.divides = [];
        this.quad = new QuadMesh();
        if (data.directions.length === 0) return;
        this.moments = new RenderTarget(width, height, { depthBuffer: false, minFilter: NearestFilter, magFilter: NearestFilter, type: HalfFloatType });
        this.direction = makeTarget(width, height, pages, UnsignedByteType);
        this.directions = this.direction.texture;
        this.momentDraws = planDraws(sources, 'directions').map((plan) => this.#draw(plan, true));
        this.divides = data.directions.map((_, page) => this.#divide(page));
    }

    /** Adds sources: light, or its first moment. */
    #draw({ page, isFirst, sources }, withDirections) {
        const factors = sources.map(() => uniform(new Vector3()));
        const sum = sources.reduce((rest, { source, layer, directionLayer }, i) => {
            const light = layerOf(this.lights[source], layer).rgb.mul(factors[i]);
            if (!withDirections) return rest.add(light);
            return rest.add(hl.hlDirectionMoment(light, layerOf(this.towards[source], directionLayer).rgb));
        }, vec3(0));
        return { page, isFirst, sources, factors, material: makeMaterial(vec4(sum.clamp(-65504, 65504), 1), isFirst) };
    }

    #divide(page) {
        const direction = hl.hlEncodeMomentDirection(layerOf(this.light.texture, page).rgb, texture(this.moments.texture, uv()).level(0).rgb);
        return makeMaterial(vec4(direction, layerOf(this.towards[0], page).a), true);
    }

    /** Null before the renderer has a device: a later frame draws. */
    deviceOf(renderer) {
        return renderer.hasInitialized() ? renderer.backend : null;
    }

    /** @param {any} renderer @param {number[][]} factors of the sources */
    draw(renderer, factors) {
        const state = RendererUtils.resetRendererState(renderer);
        const { enabled } = renderer.xr;
        renderer.autoClear = false;
        renderer.xr.enabled = false;
        for (const draw of this.lightDraws) this.#sum(renderer, draw, factors, this.light, draw.page);
        for (const [page, material] of this.divides.entries()) {
            for (const draw of this.momentDraws) if (draw.page === page) this.#sum(renderer, draw, factors, this.moments, 0);
            this.#render(renderer, material, this.direction, page);
        }
        renderer.xr.enabled = enabled;
        RendererUtils.restoreRendererState(renderer, state);
    }

    #sum(renderer, { isFirst, sources, factors: own, material }, factors, target, layer) {
        const values = sources.map(({ source }) => factors[source]);
        if (!isFirst && values.every((rgb) => rgb.every((x) => x === 0))) return;
        values.forEach((rgb, i) => own[i].value.set(...rgb));
        this.#render(renderer, material, target, layer);
    }

    #render(renderer, material, target, layer) {
        renderer.setRenderTarget(target, layer);
        this.quad.material = material;
        this.quad.render(renderer);
    }

    dispose() {
        for (const material of [...[...this.lightDraws, ...this.momentDraws].map((draw) => draw.material), ...this.divides]) material.dispose();
        for (const own of [...this.lights, ...this.towards]) own?.dispose();
        for (const target of [this.light, this.moments, this.direction]) target?.dispose();
    }
}

// Adds pages of light groups up with WebGLRenderer: additive draws of a few sources into half floats, and for directions their
// first moments, which a last draw divides.
import { CustomBlending, HalfFloatType, LinearFilter, NearestFilter, NoBlending, OneFactor, ShaderMaterial, UnsignedByteType, Vector3, WebGLArrayRenderTarget, WebGLRenderTarget } from 'three';
import { FullScreenQuad } from 'three/addons/postprocessing/Pass.js';

import shading from '../generated/shading.glsl.js';
import { planDraws } from '../groups/pages.js';
import { arrayTexture, FORMATS } from '../scene/textures.js';

/** Adds `count` sources: light, or its first moment. */
function sumText(count, withDirections) {
    const all = Array.from({ length: count }, (_, i) => i);
    const samplers = all.map((i) => `uniform highp sampler2DArray light${i};\n${withDirections ? `uniform highp sampler2DArray direction${i};\n` : ''}`);
    const terms = all.map((i) => {
        const light = `texelFetch(light${i}, ivec3(at, layers[${i}]), 0).rgb * factors[${i}]`;
        if (!withDirections) return `    sum += ${light};\n`;
        return `    sum += hlDirectionMoment(${light}, texelFetch(direction${i}, ivec3(at, directionLayers[${i}]), 0).rgb);\n`;
    });
    return `${shading}${samplers.join('')}
uniform vec3 factors[${count}];
uniform int layers[${count}];
uniform int directionLayers[${count}];
void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 sum = vec3(0.0);
${terms.join('')}    gl_FragColor = vec4(clamp(sum, -65504.0, 65504.0), 1.0);
}`;
}

const divideText = `${shading}
uniform highp sampler2DArray light;
uniform highp sampler2DArray rest; // directions; their alpha stays
uniform highp sampler2D moments;
uniform int page;
void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 irradiance = texelFetch(light, ivec3(at, page), 0).rgb;
    gl_FragColor = vec4(hlEncodeMomentDirection(irradiance, texelFetch(moments, at, 0).rgb), texelFetch(rest, ivec3(at, page), 0).a);
}`;

function makeMaterial(fragmentShader, uniforms, isFirst) {
    return new ShaderMaterial({
        vertexShader: 'void main() { gl_Position = vec4(position.xy, 0.0, 1.0); }',
        fragmentShader,
        uniforms: Object.fromEntries(Object.entries(uniforms).map(([name, value]) => [name, { value }])),
        blending: isFirst ? NoBlending : CustomBlending,
        blendSrc: OneFactor,
        blendDst: OneFactor,
        depthTest: false,
        depthWrite: false,
        toneMapped: false,
    });
}

export class WebGLPageDraws {
    /** @param {import('../file/read.js').BakedData} data @param {import('../groups/pages.js').LightSource[]} sources */
    constructor(data, sources) {
        const { width, height } = data.lightmaps[0];
        const pages = data.lightmaps.length;
        const textures = (list, kind) => list.map((all) => (all.some(Boolean) ? arrayTexture(all.filter(Boolean), FORMATS[kind]) : null));
        this.lights = textures(sources.map((s) => s.lightmaps), 'rgb9e5');
        this.towards = textures(sources.map((s) => s.directions), 'rgba8');
        const plain = { depthBuffer: false, minFilter: LinearFilter, magFilter: LinearFilter };
        this.light = new WebGLArrayRenderTarget(width, height, pages, { ...plain, type: HalfFloatType });
        this.lightmaps = this.light.texture;
        this.directions = null;
        this.lightDraws = planDraws(sources, 'lightmaps').map((plan) => this.#draw(plan, false));
        this.momentDraws = [];
        this.quad = new FullScreenQuad();
        if (data.directions.length === 0) return;
        this.moments = new WebGLRenderTarget(width, height, { depthBuffer: false, minFilter: NearestFilter, magFilter: NearestFilter, type: HalfFloatType });
        this.direction = new WebGLArrayRenderTarget(width, height, pages, { ...plain, type: UnsignedByteType });
        this.directions = this.direction.texture;
        this.momentDraws = planDraws(sources, 'directions').map((plan) => this.#draw(plan, true));
        this.divide = makeMaterial(divideText, { light: this.light.texture, rest: this.towards[0], moments: this.moments.texture, page: 0 }, true);
    }

    #draw({ page, isFirst, sources }, withDirections) {
        const uniforms = { factors: sources.map(() => new Vector3()), layers: sources.map((s) => s.layer), directionLayers: sources.map((s) => s.directionLayer) };
        sources.forEach(({ source }, i) => {
            uniforms[`light${i}`] = this.lights[source];
            if (withDirections) uniforms[`direction${i}`] = this.towards[source];
        });
        return { page, isFirst, sources, material: makeMaterial(sumText(sources.length, withDirections), uniforms, isFirst) };
    }

    /** What holds a renderer's textures: another one after its context was lost. */
    deviceOf(renderer) {
        return renderer.properties;
    }

    /** @param {any} renderer @param {number[][]} factors of the sources */
    draw(renderer, factors) {
        const before = [renderer.getRenderTarget(), renderer.getActiveCubeFace(), renderer.getActiveMipmapLevel()];
        const { autoClear, xr: { enabled } } = renderer;
        renderer.autoClear = false;
        renderer.xr.enabled = false;
        for (const draw of this.lightDraws) this.#sum(renderer, draw, factors, this.light, draw.page);
        for (let page = 0; this.direction && page < this.direction.depth; ++page) {
            for (const draw of this.momentDraws) if (draw.page === page) this.#sum(renderer, draw, factors, this.moments, 0);
            this.divide.uniforms.page.value = page;
            this.divide.uniformsNeedUpdate = true;
            this.#render(renderer, this.divide, this.direction, page);
        }
        renderer.xr.enabled = enabled;
        renderer.autoClear = autoClear;
        renderer.setRenderTarget(...before);
    }

    #sum(renderer, { isFirst, sources, material }, factors, target, layer) {
        const own = sources.map(({ source }) => factors[source]);
        if (!isFirst && own.every((rgb) => rgb.every((x) => x === 0))) return;
        own.forEach((rgb, i) => material.uniforms.factors.value[i].set(...rgb));
        material.uniformsNeedUpdate = true;
        this.#render(renderer, material, target, layer);
    }

    #render(renderer, material, target, layer) {
        renderer.setRenderTarget(target, layer);
        this.quad.material = material;
        this.quad.render(renderer);
    }

    dispose() {
        for (const { material } of [...this.lightDraws, ...this.momentDraws]) material.dispose();
        for (const texture of [...this.lights, ...this.towards]) texture?.dispose();
        for (const own of [this.light, this.moments, this.direction, this.divide, this.quad]) own?.dispose();
    }
}

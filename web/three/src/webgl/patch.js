// Patches MeshStandardMaterial and MeshPhysicalMaterial for WebGLRenderer through onBeforeCompile, and takes it back.
import { MeshBasicMaterial, ShaderChunk } from 'three';

import shading from '../generated/shading.glsl.js';
import { addLightOf, follow, glassOf, makePass } from '../scene/glass.js';
import * as text from './shader_text.js';

const HOOKS = ['onBeforeCompile', 'customProgramCacheKey', 'onBeforeRender'];

/** Replaces exactly `times` occurrences; another number means that three.js's shaders changed. */
function replaceExactly(source, search, replacement, times, where) {
    const parts = source.split(search);
    if (parts.length !== times + 1)
        throw new Error(`Halflight does not fit this release of three.js: ${where} has ${parts.length - 1} of "${search}"`);
    return parts.join(replacement);
}

/** lights_pars_begin with the attenuation of KHR_lights_punctual. */
function lightDeclarations() {
    const chunk = 'lights_pars_begin';
    let source = ShaderChunk[chunk];
    for (const light of ['pointLight', 'spotLight']) {
        const call = `getDistanceAttenuation( lightDistance, ${light}.distance, ${light}.decay )`;
        const ours = `hlLightDistance( lightDistance, ${light}.distance, ${light}.decay )`;
        source = replaceExactly(source, call, ours, 1, chunk);
    }
    const cone = 'getSpotAttenuation( spotLight.coneCos, spotLight.penumbraCos, angleCos )';
    return replaceExactly(source, cone, cone.replace('getSpotAttenuation', 'hlLightCone'), 1, chunk);
}

/** lights_fragment_begin: each light's shadow goes through the law instead of straight into its colour. */
function lightLoops() {
    const chunk = 'lights_fragment_begin';
    let source = ShaderChunk[chunk];
    for (const [kind, lights] of [['Point', 'hlPointLights'], ['Spot', 'hlSpotLights'], ['Directional', 'hlDirectionalLights']]) {
        const begin = source.indexOf(`get${kind}LightInfo(`);
        const end = source.indexOf('#pragma unroll_loop_end', begin);
        if (begin < 0 || end < 0) throw new Error(`Halflight does not fit this release of three.js: ${chunk} has no ${kind} loop`);
        let loop = source.slice(begin, end);
        const read = 'directLight.color *= ( directLight.visible && receiveShadow ) ? get';
        loop = replaceExactly(loop, read, `hlRealtime = hlReads( ${lights}[ i ], directLight.visible ) ? get`, 1, chunk);
        const call = 'RE_Direct( directLight';
        const shade = `hlShade( ${lights}[ i ], hlRealtime, directLight );\n\t\thlRealtime = 1.0;\n\t\thlDirect( directLight`;
        loop = replaceExactly(loop, call, shade, 1, chunk);
        if (kind !== 'Directional') loop = `hlLightScale = ${lights}[ i ].own.y;\n\t\t${loop}`;
        loop = loop.replace(/\b\w+LightShadow\.shadowIntensity/g, '1.0'); // the law applies strength, once
        source = source.slice(0, begin) + loop + source.slice(end);
    }
    return source;
}

/** Whether a material has layers that glTF's plain metallic-roughness BRDF lacks; three.js then lights it. */
function hasLayers(material) {
    if (!material.isMeshPhysicalMaterial) return false;
    const amounts = ['clearcoat', 'sheen', 'iridescence', 'anisotropy', 'transmission', 'diffuseRoughness', 'retroreflectivity'];
    if (amounts.some((name) => material[name] > 0)) return true;
    return material.ior !== 1.5 || material.specularColor.getHex() !== 0xffffff || material.specularColorMap !== null;
}

/** Defines of shaders of glass. */
const glassDefines = ({ blended, tinted, share }) => [`HL_GLASS_SHARE ${share.toFixed(6)}`, `HL_GLASS_BLENDED ${blended}`, `HL_GLASS_TINTED ${tinted}`];

/** Multiplies what is behind glass by what passes. */
function glassPass(glass) {
    const pass = makePass(new MeshBasicMaterial());
    const defines = glassDefines(glass).map((define) => `#define ${define}\n`).join('');
    pass.onBeforeCompile = (shader) => {
        const where = 'the shader of glass';
        shader.fragmentShader = replaceExactly(shader.fragmentShader, '#include <common>', `#include <common>\n${defines}${shading}`, 1, where);
        shader.fragmentShader = replaceExactly(shader.fragmentShader, '#include <opaque_fragment>', text.fragmentGlass, 1, where);
    };
    pass.customProgramCacheKey = () => `halflight glass ${defines}`;
    return pass;
}

export class MaterialPatches {
    /**
     * @param {Record<string, {value: any}>} uniforms @param {string[]} features defines of the shaders
     * @param {(object: any, scene: any, material: any) => number} rowOf an object's row in the table
     */
    constructor(uniforms, features, threeBrdf, rowOf) {
        this.rowOf = rowOf;
        this.uniforms = uniforms;
        this.features = features;
        this.threeBrdf = threeBrdf;
        this.declarations = lightDeclarations();
        this.loops = lightLoops();
        this.patched = new Map();
    }

    /** @param {any} material @param {boolean} fromFile glass of the application is three.js's */
    apply(material, fromFile) {
        if (this.patched.has(material)) return;
        const own = Object.fromEntries(HOOKS.map((name) => [name, Object.hasOwn(material, name) ? material[name] : null]));
        const glass = fromFile && !this.threeBrdf ? glassOf(material) : null;
        const pass = glass ? glassPass(glass) : null;
        const undoGlass = glass ? addLightOf(material) : null;
        this.patched.set(material, { ...own, shadowSide: material.shadowSide, pass, undoGlass });
        const before = material.onBeforeCompile;
        const beforeKey = material.customProgramCacheKey.call({ onBeforeCompile: before });
        const kind = this.threeBrdf || hasLayers(material) ? ['HL_THREE_BRDF'] : [];
        if (glass) kind.push(...glassDefines(glass));
        material.onBeforeCompile = (shader, renderer) => {
            before.call(material, shader, renderer);
            this.patch(shader, [...this.features, ...kind]);
        };
        material.customProgramCacheKey = () => `halflight ${[...this.features, ...kind].join()} ${beforeKey}`;
        const beforeRender = material.onBeforeRender;
        material.onBeforeRender = (renderer, scene, camera, geometry, object, group) => {
            beforeRender.call(material, renderer, scene, camera, geometry, object, group);
            // A vertex attribute without an array has one value for all vertices: three.js uploads a material's
            // uniforms once for all objects that share it, so they cannot hold what differs by object.
            renderer.getContext().vertexAttrib1f(text.ROW_LOCATION, this.rowOf(object, scene, material));
            if (!pass) return;
            follow(pass, material);
            renderer.renderBufferDirect(camera, scene, geometry, pass, object, group);
        };
        material.shadowSide = 2; // DoubleSide: both sides stop the bake's rays
        material.needsUpdate = true;
    }

    patch(shader, defines) {
        const where = 'the material\'s shader';
        const vertex = (search, ours) => {
            shader.vertexShader = replaceExactly(shader.vertexShader, search, ours, 1, where);
        };
        const fragment = (search, ours) => {
            shader.fragmentShader = replaceExactly(shader.fragmentShader, search, ours, 1, where);
        };
        vertex('#include <common>', `#include <common>\n${text.vertexPars}`);
        vertex('#include <normal_vertex>', `#include <normal_vertex>\n${text.vertexNormal}`);
        vertex('#include <project_vertex>', `#include <project_vertex>\n${text.vertexMain}`);
        const defined = defines.map((name) => `#define ${name}\n`).join('');
        fragment('#include <lights_pars_begin>', `${defined}${shading}${text.attenuation}${this.declarations}`);
        fragment('#include <lights_physical_pars_fragment>', `#include <lights_physical_pars_fragment>\n${text.fragmentPars}`);
        fragment('#include <lights_fragment_begin>', text.fragmentBegin + this.loops + text.fragmentAreaLights);
        fragment('#include <aomap_fragment>', `#include <aomap_fragment>\n${text.fragmentIndirect}`);
        fragment('#include <opaque_fragment>', `${text.fragmentView}${text.fragmentCoverage}\n#include <opaque_fragment>`);
        Object.assign(shader.uniforms, this.uniforms);
    }

    /** A number in the shaders: they are compiled anew. */
    define(name, value) {
        this.features = this.features.filter((feature) => !feature.startsWith(`${name} `));
        if (value > 0) this.features.push(`${name} ${value}`);
        for (const material of this.patched.keys()) material.needsUpdate = true;
    }

    remove(material) {
        const own = this.patched.get(material);
        if (!own) return;
        this.patched.delete(material);
        for (const name of HOOKS) {
            if (own[name]) material[name] = own[name];
            else delete material[name];
        }
        material.shadowSide = own.shadowSide;
        own.undoGlass?.();
        own.pass?.dispose();
        material.needsUpdate = true;
    }

    dispose() {
        for (const material of [...this.patched.keys()]) this.remove(material);
    }
}

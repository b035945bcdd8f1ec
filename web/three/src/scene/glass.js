// Glass as the program draws it: what is behind a surface is multiplied by what passes, then the surface's own light is added.
// three.js has a pass of its own for transmission: it reads the picture of opaque surfaces around a pixel, so that glass takes
// the light of what stands before it, and its roughness blurs what is straight behind a pane. It blends other glass grey.
import { AdditiveBlending, AddEquation, CustomBlending, OneFactor, SrcColorFactor, ZeroFactor } from 'three';

import { kFaceTransmittance } from '../generated/shading.js';

/** What a material for the multiplication takes from the glass's own, and whether the program depends on it. */
const FOLLOWED = {
    map: true, alphaMap: true, alphaTest: true, vertexColors: true, side: true, clippingPlanes: true, clipIntersection: false, opacity: false,
    depthTest: false, polygonOffset: false, polygonOffsetFactor: false, polygonOffsetUnits: false,
};

/**
 * What glass lets through, as shaders want it: whether alpha is coverage, whether what it leaves open takes the base colour
 * (halflight_tinted), and the share that passes the rest. Null for other materials, and for glass with a volume or with
 * textures of transmission or metallic, which three.js draws.
 * @param {any} material
 */
export function glassOf(material) {
    const isPane = material.transmission > 0;
    if (isPane && (material.thickness > 0 || material.transmissionMap || (material.metalness > 0 && material.metalnessMap))) return null;
    const blended = material.transparent;
    const tinted = blended && material.userData.gltfExtensions?.HALFLIGHT_material?.tinted === true;
    if (!isPane && !tinted) return null;
    return { blended, tinted, share: isPane ? kFaceTransmittance * material.transmission * (1 - material.metalness) : 0 };
}

/** Its own light is added to what is behind it. @param {any} material @returns {() => void} takes that back */
export function addLightOf(material) {
    const wanted = { blending: AdditiveBlending, transparent: true, depthWrite: false, ...(material.transmission > 0 ? { transmission: 0 } : {}) };
    const before = Object.fromEntries(Object.keys(wanted).map((name) => [name, material[name]]));
    Object.assign(material, wanted);
    return () => Object.assign(material, before);
}

/** The material that multiplies. @template T @param {T & any} pass an unlit material, with a program of its own @returns {T} */
export function makePass(pass) {
    const blend = { blending: CustomBlending, blendEquation: AddEquation, blendSrc: ZeroFactor, blendDst: SrcColorFactor, blendSrcAlpha: ZeroFactor, blendDstAlpha: OneFactor };
    return Object.assign(pass, { name: 'halflight glass', transparent: true, depthWrite: false, forceSinglePass: true, fog: false, toneMapped: false, ...blend });
}

/** Before each draw: the application may change the glass. */
export function follow(pass, material) {
    for (const [name, changesProgram] of Object.entries(FOLLOWED)) {
        if (pass[name] === material[name]) continue;
        pass[name] = material[name];
        if (changesProgram) pass.needsUpdate = true;
    }
    pass.color.copy(material.color);
}

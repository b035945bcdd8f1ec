// glTF Transform extensions for files that Halflight baked: docs/format.md of that project describes them.
import { Extension, PropertyType } from '@gltf-transform/core';
import { AREA_LIGHTS, GROUP_LISTS, LIGHT, MATERIAL, MIXED_LIGHTING, NODE, PICTURE_LISTS, PROBE_ACCESSORS, REFLECTION_PICTURE, SKY_PICTURE, TEXTURE_KTX2 } from './names.js';
import { AreaLight, LightRecord, MaterialSwitches, MixedLighting, NodeLighting, SurfaceOfNode } from './properties.js';
import { mergeSurfaces, splitSurfaces } from './surfaces.js';

export { AreaLight, LightRecord, MaterialSwitches, MixedLighting, NodeLighting, SurfaceOfNode };

const LINEAR = 9729;
const CLAMP_TO_EDGE = 33071;
const REPEAT = 10497;

/**
 * Texels of the bake are data: lossy codecs, and lossless ones that drop colour where alpha is 0, would break them.
 * glTF Transform writes images before it asks extensions, so the texture itself keeps what it was read with.
 */
function keepAsItIs(texture, logger) {
    const refuse = () => {
        logger.info(`halflight: "${texture.getName()}" stays as it is, its texels are data`);
        return texture;
    };
    texture.setImage = refuse;
    texture.setMimeType = () => texture;
}

export class HalflightMixedLighting extends Extension {
    static EXTENSION_NAME = MIXED_LIGHTING;
    extensionName = MIXED_LIGHTING;

    createMixedLighting() {
        return new MixedLighting(this.document.getGraph());
    }

    read(context) {
        const { json } = context.jsonDoc;
        const record = structuredClone(json.extensions?.[MIXED_LIGHTING]);
        if (!record) return this;
        if (record.version !== 2 && record.version !== 3) {
            throw new Error(
                `the bake is of version ${record.version} of the format, and tools keep versions 2 and 3: bake the file again`
            );
        }
        const lighting = this.createMixedLighting();
        const keep = (key, reference) => {
            const def = json.textures[reference.index];
            const source = pictureSource(def);
            const texture = context.textures[source];
            keepAsItIs(texture, this.document.getLogger());
            lighting.setPicture(key, texture);
            if (def.source !== undefined && def.source !== source)
                lighting.setPlaceholder(context.textures[def.source]);
        };
        for (const [own, lists, path] of recordsWithPages(record))
            for (const list of lists) {
                (own[list] ?? []).forEach((reference, page) => {
                    if (reference.index !== undefined) keep(`${path}${list}/${page}`, reference); // pages that are lit everywhere, or nowhere, have none
                });
                if (own[list]) own[list] = own[list].length;
            }
        (record.groups ?? []).forEach((group, g) => {
            if (group.radiance !== undefined) lighting.setProbeAccessor(`groups/${g}/radiance`, context.accessors[group.radiance]);
            delete group.radiance;
            if (!group.reflections) return;
            keep(groupReflections(g), group.reflections.picture);
            delete group.reflections.picture.index;
        });
        if (record.sky?.picture) {
            keep(SKY_PICTURE, record.sky.picture);
            delete record.sky.picture.index;
        }
        if (record.reflectionProbes) {
            keep(REFLECTION_PICTURE, record.reflectionProbes.picture);
            delete record.reflectionProbes.picture.index;
        }
        for (const name of PROBE_ACCESSORS) {
            if (record.probes?.[name] === undefined) continue;
            const accessor = context.accessors[record.probes[name]];
            // Meshopt pads elements to four bytes, and outside of vertex attributes glTF Transform writes no stride.
            if (name === 'valid') accessor.setArray(Uint32Array.from(accessor.getArray()));
            lighting.setProbeAccessor(name, accessor);
            delete record.probes[name];
        }
        this.document.getRoot().setExtension(MIXED_LIGHTING, lighting.setRecord(record));
        return this;
    }

    write(context) {
        const lighting = this.document.getRoot().getExtension(MIXED_LIGHTING);
        if (!lighting) return this;
        const { json } = context.jsonDoc;
        const record = lighting.getRecord();
        for (const [own, lists, path] of recordsWithPages(record))
            for (const list of lists) {
                if (own[list] === undefined) continue;
                own[list] = Array.from({ length: own[list] }, (_, page) => {
                    const picture = lighting.getPicture(`${path}${list}/${page}`);
                    return picture ? { index: writeTexture(context, picture, lighting.getPlaceholder()) } : {};
                });
            }
        (record.groups ?? []).forEach((group, g) => {
            const accessor = lighting.getProbeAccessor(`groups/${g}/radiance`);
            if (accessor) group.radiance = context.accessorIndexMap.get(accessor);
            if (group.reflections) group.reflections.picture.index = writeTexture(context, lighting.getPicture(groupReflections(g)), lighting.getPlaceholder());
        });
        if (record.sky?.picture) {
            const sky = lighting.getPicture(SKY_PICTURE);
            record.sky.picture.index = writeTexture(context, sky, lighting.getPlaceholder(), REPEAT);
        }
        if (record.reflectionProbes) {
            const picture = lighting.getPicture(REFLECTION_PICTURE);
            record.reflectionProbes.picture.index = writeTexture(context, picture, lighting.getPlaceholder());
        }
        for (const name of PROBE_ACCESSORS) {
            const accessor = lighting.getProbeAccessor(name);
            if (accessor) record.probes[name] = context.accessorIndexMap.get(accessor);
        }
        json.extensions = { ...json.extensions, [MIXED_LIGHTING]: record };
        return this;
    }
}

/** Key of the picture of reflection probes that a light group has. @param {number} g its index */
const groupReflections = (g) => `groups/${g}/reflections`;

/** Records that list pictures by page, which lists they have, and the beginning of the pictures' keys. */
function recordsWithPages(record) {
    return [[record, PICTURE_LISTS, ''], ...(record.groups ?? []).map((group, g) => [group, GROUP_LISTS, `groups/${g}/`])];
}

/** Index of the image that a texture of the bake shows. */
function pictureSource(def) {
    return (
        def.extensions?.[TEXTURE_KTX2]?.source ?? def.extensions?.EXT_texture_webp?.source ?? def.source
    );
}

/** Appends a texture for a picture and returns its index. */
function writeTexture(context, texture, placeholder, wrapS = CLAMP_TO_EDGE) {
    const { json } = context.jsonDoc;
    const source = context.imageIndexMap.get(texture);
    const sampler = { magFilter: LINEAR, minFilter: LINEAR, wrapS, wrapT: CLAMP_TO_EDGE };
    json.samplers ??= [];
    json.textures ??= [];
    let samplerIndex = json.samplers.findIndex((other) => JSON.stringify(other) === JSON.stringify(sampler));
    if (samplerIndex < 0) samplerIndex = json.samplers.push(sampler) - 1;
    const def = { name: texture.getName(), sampler: samplerIndex };
    const extension = { 'image/ktx2': TEXTURE_KTX2, 'image/webp': 'EXT_texture_webp' }[texture.getMimeType()];
    if (!extension) {
        def.source = source;
    } else {
        def.extensions = { [extension]: { source } };
        if (placeholder) def.source = context.imageIndexMap.get(placeholder);
        json.extensionsUsed ??= [];
        if (!json.extensionsUsed.includes(extension)) json.extensionsUsed.push(extension);
    }
    return json.textures.push(def) - 1;
}

/** Nodes of a JSON document that have the extension, with its record. */
function* records(defs, properties, name) {
    for (const [index, def] of (defs ?? []).entries()) {
        const record = def.extensions?.[name];
        if (record) yield [properties[index], record];
    }
}

function writeRecords(properties, indexMap, defs, name) {
    for (const property of properties) {
        const extension = property.getExtension(name);
        if (!extension) continue;
        const def = defs[indexMap.get(property)];
        def.extensions = { ...def.extensions, [name]: extension.getRecord() };
    }
}

export class HalflightNode extends Extension {
    static EXTENSION_NAME = NODE;
    extensionName = NODE;
    prewriteTypes = [PropertyType.ACCESSOR];

    createNodeLighting() {
        return new NodeLighting(this.document.getGraph());
    }
    createSurface() {
        return new SurfaceOfNode(this.document.getGraph());
    }

    read(context) {
        const nodes = [];
        for (const [node, record] of records(context.jsonDoc.json.nodes, context.nodes, NODE)) {
            const lighting = this.createNodeLighting().setRecord(record);
            node.setExtension(NODE, lighting);
            nodes.push({ node, lighting });
        }
        const root = this.document.getRoot().getExtension(MIXED_LIGHTING);
        splitSurfaces(this, nodes, (page) => root?.getPicture(`lightmaps/${page}`) ?? null);
        return this;
    }

    prewrite() {
        mergeSurfaces(this.document);
        return this;
    }

    write(context) {
        writeRecords(this.document.getRoot().listNodes(), context.nodeIndexMap, context.jsonDoc.json.nodes, NODE);
        return this;
    }
}

export class HalflightLight extends Extension {
    static EXTENSION_NAME = LIGHT;
    extensionName = LIGHT;

    createLightRecord() {
        return new LightRecord(this.document.getGraph());
    }

    read(context) {
        for (const [node, record] of records(context.jsonDoc.json.nodes, context.nodes, LIGHT))
            node.setExtension(LIGHT, this.createLightRecord().setRecord(record));
        return this;
    }

    write(context) {
        writeRecords(this.document.getRoot().listNodes(), context.nodeIndexMap, context.jsonDoc.json.nodes, LIGHT);
        return this;
    }
}

/** The draft of EXT_lights_area, which glTF Transform does not know: area lights of a file stay in it. */
export class AreaLights extends Extension {
    static EXTENSION_NAME = AREA_LIGHTS;
    extensionName = AREA_LIGHTS;

    createAreaLight() {
        return new AreaLight(this.document.getGraph());
    }

    read(context) {
        const { json } = context.jsonDoc;
        const lights = (json.extensions?.[AREA_LIGHTS]?.lights ?? []).map((record) => this.createAreaLight().setRecord(record));
        for (const [node, { light }] of records(json.nodes, context.nodes, AREA_LIGHTS))
            if (lights[light]) node.setExtension(AREA_LIGHTS, lights[light]);
        return this;
    }

    write(context) {
        const { json } = context.jsonDoc;
        const lights = [];
        for (const node of this.document.getRoot().listNodes()) {
            const light = node.getExtension(AREA_LIGHTS);
            if (!light) continue;
            if (!lights.includes(light)) lights.push(light);
            const def = json.nodes[context.nodeIndexMap.get(node)];
            def.extensions = { ...def.extensions, [AREA_LIGHTS]: { light: lights.indexOf(light) } };
        }
        if (lights.length > 0)
            json.extensions = { ...json.extensions, [AREA_LIGHTS]: { lights: lights.map((light) => light.getRecord()) } };
        return this;
    }
}

export class HalflightMaterial extends Extension {
    static EXTENSION_NAME = MATERIAL;
    extensionName = MATERIAL;

    createMaterialSwitches() {
        return new MaterialSwitches(this.document.getGraph());
    }

    read(context) {
        for (const [material, record] of records(context.jsonDoc.json.materials, context.materials, MATERIAL))
            material.setExtension(MATERIAL, this.createMaterialSwitches().setRecord(record).setEmission(material.getEmissiveFactor()));
        return this;
    }

    write(context) {
        const { json } = context.jsonDoc;
        for (const material of this.document.getRoot().listMaterials()) {
            const isWhole = material.getExtension(MATERIAL)?.followEmission(material.getEmissiveFactor()) ?? true;
            if (!isWhole)
                this.document
                    .getLogger()
                    .warn(`halflight: "${material.getName()}" was off and can no longer be switched on: a palette holds its emission; leave the palette out`);
        }
        writeRecords(this.document.getRoot().listMaterials(), context.materialIndexMap, json.materials, MATERIAL);
        return this;
    }
}

/** A texture whose image is a KTX 2.0 file of any format. HalflightMixedLighting reads and writes it. */
export class HalflightTextureKtx2 extends Extension {
    static EXTENSION_NAME = TEXTURE_KTX2;
    extensionName = TEXTURE_KTX2;

    read() {
        return this;
    }
    write() {
        return this;
    }
}

/** All of them, for NodeIO.registerExtensions() and for the command line's configuration. */
export const HALFLIGHT_EXTENSIONS = [
    AreaLights,
    HalflightLight,
    HalflightMaterial,
    HalflightMixedLighting,
    HalflightNode,
    HalflightTextureKtx2,
];

// The bake as properties of a glTF Transform document.
import { ExtensionProperty, PropertyType, RefMap, TextureInfo } from '@gltf-transform/core';
import { AREA_LIGHTS, LIGHT, MATERIAL, MIXED_LIGHTING, NODE } from './names.js';

/** A record of JSON, kept as text: glTF Transform compares and copies properties by value. */
class RecordProperty extends ExtensionProperty {
    getDefaults() {
        return Object.assign(super.getDefaults(), { record: '{}' });
    }
    getRecord() {
        return JSON.parse(this.get('record'));
    }
    setRecord(record) {
        return this.set('record', JSON.stringify(record));
    }
}

/** The class of an extension's record on properties of a kind. */
const recordOf = (extension, type, parent) => class extends RecordProperty {
    static EXTENSION_NAME = extension;

    init() {
        this.extensionName = extension;
        this.propertyType = type;
        this.parentTypes = [parent];
    }
};

/** HALFLIGHT_mixed_lighting of the document: its pictures and probes by reference, the rest as a record. */
export class MixedLighting extends recordOf(MIXED_LIGHTING, 'HalflightMixedLighting', PropertyType.ROOT) {
    getDefaults() {
        return Object.assign(super.getDefaults(), {
            pictures: new RefMap(),
            accessors: new RefMap(),
            placeholder: null,
        });
    }
    /** @param {string} key such as "shadowmasks/0" */
    getPicture(key) {
        return this.getRefMap('pictures', key);
    }
    setPicture(key, texture) {
        return this.setRefMap('pictures', key, texture);
    }
    listPictures() {
        return this.listRefMapKeys('pictures').map((key) => [key, this.getPicture(key)]);
    }
    /** @param {string} key such as "positions" */
    getProbeAccessor(key) {
        return this.getRefMap('accessors', key);
    }
    setProbeAccessor(key, accessor) {
        return this.setRefMap('accessors', key, accessor);
    }
    /** The grey texel that textures name whose picture core glTF does not allow. */
    getPlaceholder() {
        return this.getRef('placeholder');
    }
    setPlaceholder(texture) {
        return this.setRef('placeholder', texture);
    }
}

/** HALFLIGHT_node of a node with a mesh. */
export class NodeLighting extends recordOf(NODE, 'HalflightNode', PropertyType.NODE) {
    getDefaults() {
        return Object.assign(super.getDefaults(), { mesh: -1 });
    }
}

/** HALFLIGHT_light of a node with a light. */
export class LightRecord extends recordOf(LIGHT, 'HalflightLight', PropertyType.NODE) {}

/** A light of EXT_lights_area, which nodes share. */
export class AreaLight extends recordOf(AREA_LIGHTS, 'AreaLight', PropertyType.NODE) {}

/** HALFLIGHT_material. */
export class MaterialSwitches extends recordOf(MATERIAL, 'HalflightMaterial', PropertyType.MATERIAL) {
    getDefaults() {
        return Object.assign(super.getDefaults(), { emission: [] });
    }
    /** Emission factor that `white` of the record fits. @param {number[]} factor */
    setEmission(factor) {
        return this.set('emission', factor);
    }
    /**
     * palette() moves emission into a texture, whose factor is then another: so is the record's `white`.
     * @param {number[]} factor that the material has now @returns {boolean} whether its light group still can give it all colours
     */
    followEmission(factor) {
        const { baking, ...record } = this.getRecord();
        const before = this.get('emission');
        if (!baking?.white || before.length === 0) return true;
        const white = baking.white.map((x, c) => (before[c] > 0 ? (x * factor[c]) / before[c] : x));
        this.setRecord({ ...record, baking: { ...baking, white } }).setEmission(factor);
        return white.every((x, c) => before[c] > 0 || x === 0 || factor[c] === before[c]);
    }
}

/**
 * Makes the material of a node's primitive differ from all others while tools work, and tells them that it reads the
 * lightmap's texture coordinates. It is not written.
 */
export class SurfaceOfNode extends ExtensionProperty {
    static EXTENSION_NAME = NODE;

    init() {
        this.extensionName = NODE;
        this.propertyType = 'HalflightSurface';
        this.parentTypes = [PropertyType.MATERIAL];
    }
    getDefaults() {
        return Object.assign(super.getDefaults(), {
            key: 0,
            wasDefault: false,
            lightmapTexture: null,
            lightmapTextureInfo: new TextureInfo(this.graph, 'lightmapTextureInfo'),
        });
    }
    setLightmap(texture, texCoord) {
        this.setRef('lightmapTexture', texture);
        this.getRef('lightmapTextureInfo').setTexCoord(texCoord);
        return this;
    }
    hasLightmap() {
        return this.getRef('lightmapTexture') !== null;
    }
    getTexCoord() {
        return this.getRef('lightmapTextureInfo').getTexCoord();
    }
    getKey() {
        return this.get('key');
    }
    setKey(key) {
        return this.set('key', key);
    }
    wasDefault() {
        return this.get('wasDefault');
    }
    setWasDefault(value) {
        return this.set('wasDefault', value);
    }
}

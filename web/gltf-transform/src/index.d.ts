import type { Accessor, Document, Extension, ExtensionProperty, ReaderContext, Texture, WriterContext } from '@gltf-transform/core';

/**
 * Keys of pictures: "lightmaps/0", "lightmapDirections/0", "shadowmasks/0" and so on, one per page, "sky" and "reflectionProbes".
 * Those of light groups begin with the group: "groups/0/lightmaps/0", "groups/0/lightmapDirections/0",
 * "groups/0/reflections".
 */
export type PictureKey = `${'lightmaps' | 'lightmapDirections' | 'shadowmasks'}/${number}` | `groups/${number}/${'lightmaps' | 'lightmapDirections'}/${number}` | `groups/${number}/reflections` | 'sky' | 'reflectionProbes';
export type ProbeAccessor = 'positions' | 'radiance' | 'occlusion' | 'valid' | 'tetrahedra' | 'neighbors' | `groups/${number}/radiance`;

declare abstract class RecordProperty extends ExtensionProperty {
    readonly extensionName: string;
    readonly propertyType: string;
    readonly parentTypes: string[];
    protected init(): void;
    /** The extension's JSON without references to textures and accessors. */
    getRecord(): Record<string, unknown>;
    setRecord(record: Record<string, unknown>): this;
}

export declare class MixedLighting extends RecordProperty {
    static EXTENSION_NAME: 'HALFLIGHT_mixed_lighting';
    getPicture(key: PictureKey): Texture | null;
    setPicture(key: PictureKey, texture: Texture | null): this;
    listPictures(): [PictureKey, Texture][];
    getProbeAccessor(key: ProbeAccessor): Accessor | null;
    setProbeAccessor(key: ProbeAccessor, accessor: Accessor | null): this;
    getPlaceholder(): Texture | null;
    setPlaceholder(texture: Texture | null): this;
}
export declare class NodeLighting extends RecordProperty {
    static EXTENSION_NAME: 'HALFLIGHT_node';
}
export declare class LightRecord extends RecordProperty {
    static EXTENSION_NAME: 'HALFLIGHT_light';
}
/** A light of EXT_lights_area, which nodes share. */
export declare class AreaLight extends RecordProperty {
    static EXTENSION_NAME: 'EXT_lights_area';
}
export declare class MaterialSwitches extends RecordProperty {
    static EXTENSION_NAME: 'HALFLIGHT_material';
}

declare class HalflightExtension extends Extension {
    readonly extensionName: string;
    read(context: ReaderContext): this;
    write(context: WriterContext): this;
}
export declare class HalflightMixedLighting extends HalflightExtension {
    createMixedLighting(): MixedLighting;
}
export declare class HalflightNode extends HalflightExtension {
    createNodeLighting(): NodeLighting;
}
export declare class HalflightLight extends HalflightExtension {
    createLightRecord(): LightRecord;
}
export declare class AreaLights extends HalflightExtension {
    createAreaLight(): AreaLight;
}
export declare class HalflightMaterial extends HalflightExtension {
    createMaterialSwitches(): MaterialSwitches;
}
export declare class HalflightTextureKtx2 extends HalflightExtension {}

/** For NodeIO.registerExtensions() and for the command line's configuration. */
export declare const HALFLIGHT_EXTENSIONS: (typeof Extension)[];

import type { Box3, Camera, Color, Light, Object3D } from 'three';
import type { GLTF, GLTFParser, GLTFLoaderPlugin } from 'three/addons/loaders/GLTFLoader.js';
import type { BakedData } from './file.js';

export type Mode = 'realtime' | 'baked-indirect' | 'shadowmask' | 'distance-shadowmask' | 'subtractive';
export type View = 'lit' | 'shadowmask' | 'lightmap' | 'probes' | 'fade' | 'overlap';

export interface Options {
    /** Draw the bake's sky, a gradient or a picture; true when absent. */
    sky?: boolean;
    /** 'gltf' (when absent): direct light by glTF's BRDF, as in the bake. 'three': by three.js's own. */
    brdf?: 'gltf' | 'three';
    /** Layer that dynamic objects are on, for shadow cameras; 31 when absent. */
    dynamicLayer?: number;
}

/** A rectangle or disk of EXT_lights_area, made by the plug-in. It shines along its -Z and has no realtime shadow. */
export interface AreaLight extends Object3D {
    readonly isHalflightAreaLight: true;
    readonly isDisk: boolean;
    color: Color;
    /** Radiance of its surface, cd/m2. */
    intensity: number;
    /** In units of its node; of a disk both are the diameter. */
    width: number;
    height: number;
    /** Metres of the file from its middle at which its light ends; 0 = unlimited. */
    range: number;
}

/** A light of the file. Colour, intensity and place are those of `light`. */
export interface BakedLight {
    readonly light: Light | AreaLight;
    readonly name: string;
    /** Whether it casts any shadow, baked or realtime. */
    castShadows: boolean;
    /** 0…1. */
    shadowStrength: number;
}

/** A light group of the file: weights by channel, linear. */
export interface LightGroup {
    readonly name: string;
    readonly weight: [number, number, number];
    /** That the file saves, with which it looks as its scene did. */
    readonly savedWeight: [number, number, number];
}

export class HalflightScene {
    /** Throws where the bake holds no data for the mode. */
    mode: Mode;
    readonly modes: Mode[];
    debugView: View;
    /** Metres of the file; from here on no realtime shadow is sampled. */
    shadowDistance: number;
    /** Metres before the shadow distance over which shadows fade. */
    shadowFadeRange: number;
    /** Lower limit of subtractive shadows, lux: by the weights of light groups, unless it was set here. */
    shadowColor: [number, number, number];
    readonly data: BakedData;
    readonly lights: BakedLight[];
    /** Light groups of the file in its order; none where it has none. */
    readonly lightGroups: LightGroup[];
    /** Multiplies the light of a group, from the next update() on: 0 is off. "sky" stands for all parts of a sky that changes. Throws where there is no such group, or no such weight. */
    setLightGroup(name: string, color: number | readonly [number, number, number] | Color): void;
    /** Whether light still follows a change of weights piece by piece: where frames are drawn on demand, draw another one. */
    readonly isFollowing: boolean;
    /** Sentences about what is left out or shows in part, while it is so. */
    readonly warnings: Set<string>;
    /** Call before each frame; throws an error once. `scene` is needed only where the file's own objects are in no scene, such as with clones alone. */
    update(renderer: object, camera: Camera, scene?: Object3D): void;
    /** Lights an object of the application by the bake's probes. */
    add(object: Object3D): void;
    /** Takes back what add() did, or forgets a clone. Objects that leave the scene are removed by themselves. */
    remove(object: Object3D): void;
    /**
     * The probes as three.js's LightProbeGrid: pass the class of its addons, LightProbeGridWebGL for WebGLRenderer (LightProbeGrid
     * in 0.184 and 0.185) or LightProbeGrid for WebGPURenderer. Covers the scene, with probes as far apart as the bake's, where options are absent.
     */
    toLightProbeGrid<Grid extends Object3D>(
        Grid: new (width?: number, height?: number, depth?: number, x?: number, y?: number, z?: number) => Grid,
        options?: { box?: Box3; resolution?: [number, number, number] }
    ): Grid;
    /** Takes every change of materials, lights and objects back, and frees all that the plug-in made. Later updates do nothing. */
    dispose(): void;
}

/** What a loader with the plug-in returns: `const gltf: BakedGLTF = await loader.loadAsync(url)`. */
export interface BakedGLTF extends GLTF {
    /** null where the file is not baked; absent where the loader has no plug-in. */
    userData: Record<string, any> & { halflight?: HalflightScene | null };
}

export class HalflightPlugin implements GLTFLoaderPlugin {
    constructor(parser: GLTFParser, options?: Options);
    readonly name: string;
    /** null until the file is loaded, and for files that are not baked. Also gltf.userData.halflight. */
    readonly scene: HalflightScene | null;
    afterRoot(gltf: object): Promise<void>;
}

export const MODES: readonly Mode[];
export const VIEWS: readonly View[];
/** Releases of three.js that the plug-in fits, as in REVISION. */
export const RELEASES: readonly string[];

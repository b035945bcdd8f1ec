import type { BakedGLTF, HalflightScene, Mode, Options, View } from '@halflight/three';
import type { ObjectMap, ThreeElements } from '@react-three/fiber';
import type { ReactElement, RefObject } from 'react';
import type { Object3D } from 'three';
import type { DRACOLoader } from 'three/addons/loaders/DRACOLoader.js';
import type { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import type { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';

/** Compared by its values: decoders are made once, outside of components. */
export interface HalflightOptions extends Options {
    draco?: DRACOLoader;
    ktx2?: KTX2Loader;
    /** MeshoptDecoder of three/addons/libs/meshopt_decoder.module.js. */
    meshopt?: Parameters<GLTFLoader['setMeshoptDecoder']>[0];
}

export interface UseHalflight {
    /**
     * Loads a baked file once, updates it before each frame, and frees it with the last component that has it.
     * `halflight` is null where the file is not baked. Suspends while the file is loaded.
     */
    (url: string, options?: HalflightOptions): [gltf: BakedGLTF & ObjectMap, halflight: HalflightScene | null];
    /** Loads a file before a component asks for it. */
    preload(url: string, options?: HalflightOptions): void;
    /** Forgets a file, for instance one that could not be loaded: the next component loads it again. */
    clear(url: string, options?: HalflightOptions): void;
}

export const useHalflight: UseHalflight;

export type HalflightModelProps = Omit<ThreeElements['group'], 'args'> & {
    url: string;
    options?: HalflightOptions;
    /** Settings of the file, for all models of its URL; left as they are where absent. */
    mode?: Mode;
    shadowDistance?: number;
    shadowFadeRange?: number;
    debugView?: View;
};

/** A baked file below a group. Each model has objects of its own; geometries and materials are the file's. */
export function HalflightModel(props: HalflightModelProps): ReactElement;

/** The bake's probes light an object: that of the <HalflightModel> above, or `halflight` where it is passed. */
export function useBakedObject(ref: RefObject<Object3D | null>, halflight?: HalflightScene | null): void;

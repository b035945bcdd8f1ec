import type { BakedGLTF, HalflightScene, Mode, View } from '@halflight/three';
import type { Group } from 'three';

/** Attributes of `halflight-model`. */
export interface HalflightModelData {
    src: string;
    /** The file's own where empty. */
    mode: Mode | '';
    shadowDistance: number;
    shadowFadeRange: number;
    debugView: View;
    sky: boolean;
}

/** `entity.components['halflight-model']`. */
export interface HalflightModelComponent {
    readonly data: HalflightModelData;
    /** null until a baked file is loaded */
    readonly halflight: HalflightScene | null;
    readonly gltf: BakedGLTF | null;
}

/** Detail of the event `model-loaded`. */
export interface HalflightModelLoaded {
    format: 'gltf';
    model: Group;
    gltf: BakedGLTF;
    halflight: HalflightScene | null;
}

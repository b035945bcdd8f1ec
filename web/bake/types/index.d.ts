import type { BakeSettings } from './options.d.ts';

export type { BakeSettings } from './options.d.ts';

/** Of a bake that is running. A stage of several passes begins anew. */
export interface BakeProgress {
    stage: string;
    percent: number;
}

export interface BakeOptions extends BakeSettings {
    /** Files that a .gltf or the settings name, by their path beside it. */
    files?: Record<string, Uint8Array | ArrayBuffer | string>;
    /** The scene's name in messages; default `scene.glb` or `scene.gltf`. */
    name?: string;
    /** The text of a settings file, which lies beside the scene. */
    settings?: string;
    /** Called at most ten times a second. An error that it throws ends the bake. */
    onProgress?: (progress: BakeProgress) => void;
    /** Called with sentences for the user. */
    onWarning?: (sentence: string) => void;
    /** Cancels the bake; the promise is then rejected with the signal's reason. */
    signal?: AbortSignal;
    /** Bytes that the bake may take, whole multiples of 64 KiB from 64 MiB on; default 4 GiB, the most that there is. */
    mostMemory?: number;
}

/** What `halflight bake --report` writes. */
export interface BakeReport {
    warnings: string[];
    [key: string]: unknown;
}

export interface BakeResult {
    glb: Uint8Array<ArrayBuffer>;
    report: BakeReport;
}

/** Bakes a .glb or .gltf in a worker of its own. */
export function bake(bytes: Uint8Array | ArrayBuffer, options?: BakeOptions): Promise<BakeResult>;

/** Why a bake was not done: a sentence of the program. */
export class BakeError extends Error {}

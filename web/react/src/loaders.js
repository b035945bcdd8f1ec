// One loader for each set of options: react-three-fiber caches files by loader and URL.
import { HalflightPlugin } from '@halflight/three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';

const loaders = [];

/** @param {import('../types/index.js').HalflightOptions} [options] compared by its values, not by identity */
export function loaderFor({ draco, ktx2, meshopt, sky, brdf, dynamicLayer } = {}) {
    const key = [draco, ktx2, meshopt, sky, brdf, dynamicLayer];
    const known = loaders.find((entry) => entry.key.every((value, i) => value === key[i]));
    if (known) return known.loader;
    const loader = new GLTFLoader();
    loader.register((parser) => new HalflightPlugin(parser, { sky, brdf, dynamicLayer }));
    if (draco) loader.setDRACOLoader(draco);
    if (ktx2) loader.setKTX2Loader(ktx2);
    if (meshopt) loader.setMeshoptDecoder(meshopt);
    loaders.push({ key, loader });
    return loader;
}

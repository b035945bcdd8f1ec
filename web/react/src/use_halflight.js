// const [gltf, halflight] = useHalflight(url): loaded once, updated before each frame, freed with its last component.
import { useFrame, useLoader, useThree } from '@react-three/fiber';
import { useEffect, useReducer } from 'react';

import { hold, release } from './life.js';
import { loaderFor } from './loaders.js';

/** Time of the frame that a file was updated for: several components may hold it. */
const updated = new WeakMap();

/** @param {string} url @param {import('../types/index.js').HalflightOptions} [options] */
export function useHalflight(url, options) {
    const loader = loaderFor(options);
    const gltf = useLoader(loader, url);
    const { halflight } = gltf.userData;
    const invalidate = useThree((state) => state.invalidate);
    const [, loadAgain] = useReducer((count) => count + 1, 0);
    // Effects that Suspense leaves alone: a hidden model is held.
    useEffect(() => {
        if (!hold(gltf)) {
            loadAgain();
            return undefined;
        }
        invalidate();
        return () => release(gltf, () => useLoader.clear(loader, url));
    }, [gltf, loader, url, invalidate]);
    // Priority 0: after controls (-1), before post-processing (1 and more); react-three-fiber still draws by itself.
    useFrame(({ gl, camera, scene, clock }) => {
        if (!halflight || updated.get(halflight) === clock.elapsedTime) return;
        updated.set(halflight, clock.elapsedTime);
        halflight.update(gl, camera, scene);
        if (halflight.isFollowing) invalidate();
    });
    return [gltf, halflight];
}

/** Loads a file before a component asks for it. */
useHalflight.preload = (url, options) => useLoader.preload(loaderFor(options), url);

/** Forgets a file, for instance one that could not be loaded: the next component loads it again. */
useHalflight.clear = (url, options) => useLoader.clear(loaderFor(options), url);

// A loaded file lives as long as a component holds it.
const counts = new WeakMap();
const freed = new WeakSet();

/** @param {any} gltf @returns {boolean} false where the file was freed: it has to be loaded again */
export function hold(gltf) {
    if (freed.has(gltf)) return false;
    counts.set(gltf, (counts.get(gltf) ?? 0) + 1);
    return true;
}

/**
 * The last holder frees the file, unless another follows at once, as in Strict Mode.
 * @param {any} gltf @param {() => void} forget takes it from the cache
 */
export function release(gltf, forget) {
    counts.set(gltf, counts.get(gltf) - 1);
    setTimeout(() => {
        if (counts.get(gltf) > 0 || freed.has(gltf)) return;
        freed.add(gltf);
        forget();
        gltf.userData.halflight?.dispose();
        for (const scene of gltf.scenes) freeObjects(scene, true);
    });
}

/**
 * Frees what the graphics device holds of objects.
 * @param {any} root @param {boolean} shared geometries and materials too, which clones share
 */
export function freeObjects(root, shared) {
    root.traverse((object) => {
        if (object.isLight) object.dispose();
        object.skeleton?.dispose();
        if (!shared) return;
        object.geometry?.dispose();
        for (const material of object.material ? [object.material].flat() : []) {
            for (const value of Object.values(material)) if (value?.isTexture) value.dispose();
            material.dispose();
        }
    });
}

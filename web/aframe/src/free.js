/** Frees the bake of a loaded file, and what the graphics device holds of its objects. @param {any} gltf */
export function freeObjects(gltf) {
    gltf.userData.halflight?.dispose();
    for (const scene of gltf.scenes)
        scene.traverse((object) => {
            if (object.isLight) object.dispose();
            object.skeleton?.dispose();
            object.geometry?.dispose();
            for (const material of object.material ? [object.material].flat() : []) {
                for (const value of Object.values(material)) if (value?.isTexture) value.dispose();
                material.dispose();
            }
        });
}

// Where the loaded file stands: under parents, and as clones.
import * as THREE from 'three';
import { clone as cloneSkinned } from 'three/addons/utils/SkeletonUtils.js';

const COPIES = { clone: (root) => root.clone(), skeleton: (root) => cloneSkinned(root), drei: cloneByParts };

/** As drei's Clone: an object of the same type for each, with some properties of the source. */
function cloneByParts(source) {
    const copy = source.isMesh ? new THREE.Mesh(source.geometry, source.material) : new THREE[source.type]();
    const copied = ['name', 'visible', 'castShadow', 'receiveShadow', 'userData', 'color', 'distance', 'decay', 'penumbra', 'angle', 'intensity'];
    for (const key of copied) if (source[key] !== undefined) copy[key] = source[key];
    for (const key of ['position', 'scale', 'quaternion']) copy[key].copy(source[key]);
    for (const child of source.children) copy.add(cloneByParts(child));
    return copy;
}

/**
 * Puts the file, or a copy in its place or beside it, under a parent. The camera of later pictures moves with it.
 * @param {any} loaded @param {{translation?: number[], rotation?: number[], scale?: number | number[], copy?: string, alone?: boolean}} where
 */
export function put(loaded, { translation = [0, 0, 0], rotation = [0, 0, 0], scale = 1, copy, alone = false }) {
    const { scene, gltf } = loaded;
    const group = new THREE.Group();
    group.position.fromArray(translation);
    group.rotation.set(...rotation);
    if (typeof scale === 'number') group.scale.setScalar(scale);
    else group.scale.fromArray(scale);
    if (copy) {
        group.add(COPIES[copy](gltf.scene));
        if (alone) scene.remove(gltf.scene);
    } else {
        group.add(gltf.scene);
    }
    scene.add(group);
    loaded.group = group;
}

/** Moves a camera as the file. Where the file is mirrored, the camera's picture is too. */
export function follow(loaded, view) {
    const { group } = loaded;
    loaded.isMirrored = group !== null && group !== undefined && group.scale.x < 0;
    if (!group) return;
    group.updateWorldMatrix(true, false);
    const place = new THREE.Matrix4().compose(group.position, group.quaternion, new THREE.Vector3(1, 1, 1));
    const size = Math.abs(group.scale.x);
    const mirror = new THREE.Matrix4().makeScale(loaded.isMirrored ? -1 : 1, 1, 1);
    const from = view.matrixWorld.clone().setPosition(view.position.clone().multiplyScalar(size));
    place.multiply(mirror).multiply(from).multiply(mirror).decompose(view.position, view.quaternion, view.scale);
    view.updateMatrixWorld();
}

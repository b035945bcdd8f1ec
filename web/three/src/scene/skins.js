// Where bones move a skinned mesh: its node alone does not say.
import { Matrix4, Vector3, Vector4 } from 'three';

/** Sums of the vertices by bone, weighted, as homogeneous points. @type {WeakMap<any, Vector4[]>} */
const sums = new WeakMap();
const matrix = new Matrix4();
const point = new Vector4();

/** @param {any} mesh */
export function hasBones(mesh) {
    return mesh?.isSkinnedMesh === true && mesh.skeleton !== undefined && mesh.geometry.hasAttribute('skinWeight');
}

function sumsOf(geometry) {
    if (sums.has(geometry)) return sums.get(geometry);
    const { position, skinIndex, skinWeight } = geometry.attributes;
    const byBone = [];
    for (let v = 0; v < position.count; ++v)
        for (let k = 0; k < 4; ++k) {
            const weight = skinWeight.getComponent(v, k) / position.count;
            if (weight === 0) continue;
            const sum = (byBone[skinIndex.getComponent(v, k)] ??= new Vector4(0, 0, 0, 0));
            sum.add(point.set(position.getX(v), position.getY(v), position.getZ(v), 1).multiplyScalar(weight));
        }
    sums.set(geometry, byBone);
    return byBone;
}

/**
 * The mean of a mesh's vertices where its bones hold them now: skinning is linear, so one product for each bone is enough.
 * @param {any} mesh three.js's SkinnedMesh @param {Vector3} result in the world
 */
export function posedMean(mesh, result = new Vector3()) {
    const { bones, boneInverses } = mesh.skeleton;
    result.setScalar(0);
    for (const [i, sum] of sumsOf(mesh.geometry).entries()) {
        if (!sum || !bones[i]) continue;
        matrix.multiplyMatrices(bones[i].matrixWorld, boneInverses[i]).multiply(mesh.bindMatrix);
        point.copy(sum).applyMatrix4(matrix);
        result.x += point.x;
        result.y += point.y;
        result.z += point.z;
    }
    return result.applyMatrix4(matrix.multiplyMatrices(mesh.matrixWorld, mesh.bindMatrixInverse));
}

/** Its box at its pose, in its own space. @param {any} mesh */
export function posedBox(mesh) {
    const before = mesh.boundingBox;
    mesh.computeBoundingBox();
    const box = mesh.boundingBox;
    mesh.boundingBox = before;
    return box;
}

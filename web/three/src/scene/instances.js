// Where a file stands: its scene, and clones of it, each under a transform of its own. All data of the bake is in bake
// space, the file's own world; shaders go there by a row of the object table:
//   0…3  columns of the matrix from the world to bake space
import { Matrix4, Vector3 } from 'three';

/** Relative difference of the lengths of a matrix's columns, and their cosines, up to which its scale counts as uniform. */
const UNIFORM = 1e-3;

/** @param {Matrix4} matrix @returns {{scale: number, uniform: boolean}} length of a unit, whether it is the same along each axis */
export function scaleOf(matrix) {
    const columns = [0, 1, 2].map((axis) => new Vector3().setFromMatrixColumn(matrix, axis));
    const lengths = columns.map((column) => column.length());
    const most = Math.max(...lengths);
    const equal = most - Math.min(...lengths) <= UNIFORM * most;
    const square = [[0, 1], [1, 2], [2, 0]].every(([a, b]) => Math.abs(columns[a].dot(columns[b])) <= UNIFORM * most * most);
    return { scale: Math.max(Math.cbrt(Math.abs(matrix.determinant())), 1e-12), uniform: equal && square };
}

export class Instance {
    /**
     * @param {import('./table.js').ObjectTable} table
     * @param {import('three').Object3D} object root of the file or of a clone, or a mesh that was cloned alone
     * @param {Matrix4} [bakeFromObject] of a mesh that was cloned alone: where its original was at the bake
     */
    constructor(table, object, bakeFromObject) {
        this.table = table;
        this.object = object;
        this.objectFromBake = bakeFromObject?.clone().invert() ?? null;
        this.row = table.allocate(1);
        /** Counts the changes of its place. */
        this.version = 0;
        this.worldFromBake = new Matrix4();
        this.bakeFromWorld = new Matrix4();
        this.scale = 1;
        this.uniform = true;
        this.lastWorld = new Matrix4().set(...new Array(16).fill(NaN));
        this.update();
    }

    /** Takes the place that `matrixWorld` has now. */
    update() {
        if (this.lastWorld.equals(this.object.matrixWorld)) return;
        this.lastWorld.copy(this.object.matrixWorld);
        this.worldFromBake.copy(this.lastWorld);
        if (this.objectFromBake) this.worldFromBake.multiply(this.objectFromBake);
        this.bakeFromWorld.copy(this.worldFromBake).invert();
        Object.assign(this, scaleOf(this.worldFromBake));
        this.version += 1;
        for (let c = 0; c < 4; ++c) this.table.set(this.row, c, this.bakeFromWorld.elements.slice(4 * c, 4 * c + 4));
    }
}

/** What GLTFLoader's plug-in wrote into userData of an object of a file. @param {any} object @param {string} file */
export function stampOf(object, file) {
    const stamp = object.userData?.halflight;
    return stamp && stamp.file === file ? stamp : null;
}

/** The root of the file or clone that holds an object, or null. */
export function rootOf(object, file) {
    for (let o = object; o; o = o.parent) if (stampOf(o, file)?.root) return o;
    return null;
}

/** @param {any} object */
export function topOf(object) {
    let top = object;
    while (top.parent) top = top.parent;
    return top;
}

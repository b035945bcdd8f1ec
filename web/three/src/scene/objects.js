// A node with a mesh, or instances of one, as the bake sees it.
import { Box3, Matrix4, Vector3 } from 'three';

import { Place } from '../probes/search.js';
import { hasBones, posedBox, posedMean } from './skins.js';

const TEXCOORDS = ['uv', 'uv1', 'uv2', 'uv3'];

/** Difference of matrices, relative to their largest number, that rounding makes of an object that rests in a file that moves. */
const UNMOVED = 1e-6;

/** The same for an object that counts as moved since its bake. */
const MOVED = 1e-4;

const matrix = new Matrix4();
const own = new Matrix4();
const point = new Vector3();

/** @param {Matrix4} a @param {Matrix4} b */
export function apart(a, b) {
    let most = 0;
    let size = 0;
    for (let i = 0; i < 16; ++i) {
        most = Math.max(most, Math.abs(a.elements[i] - b.elements[i]));
        size = Math.max(size, Math.abs(a.elements[i]));
    }
    return most / size;
}

export class BakedObject {
    /**
     * @param {import('three').Object3D} root @param {import('three').Mesh[]} meshes its primitives
     * @param {import('../file/read.js').NodeData} data @param {string} name
     * @param {Map<any, number>} materials of the file, by mesh
     * @param {import('./instances.js').Instance} instance whose bake it belongs to
     * @param {BakedObject | null} original of a clone
     */
    constructor(root, meshes, data, name, materials, instance, original = null, fromFile = true) {
        this.instance = instance;
        this.original = original;
        /** Whether the file or a clone holds it. */
        this.fromFile = fromFile;
        this.root = root;
        this.meshes = meshes;
        this.name = name;
        this.materials = materials;
        this.isStatic = data.isStatic;
        this.castShadows = data.castShadows;
        this.receiveShadows = data.receiveShadows;
        this.probes = data.probes;
        this.probeResolution = data.probeResolution;
        this.placement = data.lightmap;
        this.instances = meshes[0]?.isInstancedMesh ? meshes[0].count : 1;
        this.box = original?.box.clone() ?? new Box3();
        for (const mesh of original ? [] : meshes) {
            if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
            this.box.union(hasBones(mesh) ? posedBox(mesh) : mesh.geometry.boundingBox);
        }
        this.firstRow = -1;
        /** Whether a frame had it in its scene: it is dropped when it leaves. */
        this.wasShown = false;
        this.lastWorld = new Matrix4().set(...new Array(16).fill(NaN));
        this.lastVersion = -1;
        /** Where it is, whether its probe light is that of another place, and whether it is static and moved since its bake. */
        this.lit = null;
        this.isDark = true;
        /** Version of the probes' light that it has. */
        this.lightVersion = 0;
        this.strayed = false;
        /** Where its instances take their light, in bake space, and that light. */
        this.places = [];
        this.anchor = new Float64Array(3);
        /** @type {import('../probes/field.js').ProbeSample | null} */
        this.light = null;
        this.atLoad = original?.atLoad ?? this.bakeFromMesh();
        /** Of a mesh with bones: the mean of its vertices at load and now, in bake space. */
        this.posedAtLoad = hasBones(meshes[0]) ? (original?.posedAtLoad ?? this.posed(new Vector3())) : null;
        this.posedNow = this.posedAtLoad?.clone();
        this.undo = [];
    }

    get lightmapped() {
        return this.placement !== null;
    }

    /** From its mesh to bake space. @param {Matrix4} [result] */
    bakeFromMesh(result = new Matrix4()) {
        return result.multiplyMatrices(this.instance.bakeFromWorld, this.meshes[0].matrixWorld);
    }

    /** From its space to bake space. @param {number} i of a mesh with instances @param {Matrix4} [result] */
    bakeFromObject(i, result) {
        const bakeFromMesh = this.bakeFromMesh(result);
        if (!this.meshes[0].isInstancedMesh) return bakeFromMesh;
        this.meshes[0].getMatrixAt(i, own);
        return bakeFromMesh.multiply(own);
    }

    /** @param {Vector3} result */
    posed(result) {
        return posedMean(this.meshes[0], result).applyMatrix4(this.instance.bakeFromWorld);
    }

    bakeBox() {
        const box = new Box3();
        for (let i = 0; i < this.instances; ++i) box.union(this.box.clone().applyMatrix4(this.bakeFromObject(i)));
        return box;
    }

    /** Lights instance i by the probes where it is. @param {import('../probes/field.js').ProbeField} field @param {import('./table.js').ObjectTable} table */
    sample(i, field, table) {
        this.box.getCenter(point);
        if (this.posedAtLoad) point.applyMatrix4(this.atLoad).add(this.posedNow).sub(this.posedAtLoad); // bones move it
        else point.applyMatrix4(this.bakeFromObject(i, matrix));
        point.toArray(this.anchor);
        table.setSample(this.firstRow + i, field.sample(this.anchor, (this.places[i] ??= new Place()), (this.light ??= field.newSample())));
    }

    /** Rows of the table that do not change while objects move. @param {import('./table.js').ObjectTable} table */
    place(table) {
        this.firstRow = table.allocate(this.instances);
        const perInstance = this.placement?.perInstance;
        const attribute = (name) => this.meshes[0].geometry.getAttribute(name) ?? this.meshes[0].geometry.getAttribute(name.toLowerCase());
        const places = perInstance ? attribute('_HALFLIGHT_LIGHTMAP_ST') : null;
        const pages = perInstance ? attribute('_HALFLIGHT_LIGHTMAP_PAGE') : null;
        for (let i = 0; i < this.instances; ++i) {
            const p = this.placement;
            const scaleOffset = places ? [0, 1, 2, 3].map((k) => places.getComponent(i, k)) : [...(p?.scale ?? [1, 1]), ...(p?.offset ?? [0, 0])];
            const page = pages ? Math.round(pages.getX(i)) : (p?.page ?? -1);
            table.set(this.firstRow + i, 0, scaleOffset);
            table.set(this.firstRow + i, 1, [page >= 0 ? 1 : 0, Math.max(page, 0), -1, this.instance.row]);
        }
    }

    /** @param {import('./table.js').ObjectTable} table @param {number} instance @param {number} volumeRow */
    setVolume(table, instance, volumeRow) {
        table.set(this.firstRow + instance, 1, [0, 0, volumeRow, this.instance.row]);
    }

    /** Lets shaders find the lightmap coordinates. */
    attach() {
        for (const mesh of this.meshes) this.attachCoordinates(mesh.geometry);
    }

    attachCoordinates(geometry) {
        if (!this.placement || geometry.hasAttribute('hlLightmapUv')) return;
        const n = this.placement.texCoord;
        const coordinates = geometry.getAttribute(TEXCOORDS[n] ?? `texcoord_${n}`);
        if (!coordinates) throw new Error(`${this.name}: its mesh lacks TEXCOORD_${n}, which its lightmap needs`);
        geometry.setAttribute('hlLightmapUv', coordinates);
        this.undo.push(() => geometry.deleteAttribute('hlLightmapUv'));
    }

    detach() {
        for (const undo of this.undo) undo();
        this.undo = [];
    }

    /** Finds where it is in its file now: a file that moves as a whole keeps its light. */
    follow() {
        if (this.posedAtLoad) this.followBones();
        const world = this.meshes[0].matrixWorld;
        if (this.lastVersion === this.instance.version && this.lastWorld.equals(world)) return;
        this.lastVersion = this.instance.version;
        this.lastWorld.copy(world);
        this.bakeFromMesh(matrix);
        if (this.isStatic) this.strayed = apart(this.atLoad, matrix) > MOVED;
        if (this.lit && apart(this.lit, matrix) <= UNMOVED) return;
        this.lit = (this.lit ?? new Matrix4()).copy(matrix);
        this.isDark = true;
    }

    followBones() {
        this.posed(point);
        if (point.distanceTo(this.posedNow) <= UNMOVED * point.length()) return;
        this.posedNow.copy(point);
        this.isDark = true;
    }
}

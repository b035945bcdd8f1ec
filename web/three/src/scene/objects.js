// A node with a mesh, or instances of one, as the bake sees it.
import { Box3, Matrix4, Vector3 } from 'three';

import { ROW_LOCATION } from '../webgl/shader_text.js';

const TEXCOORDS = ['uv', 'uv1', 'uv2', 'uv3'];

export class BakedObject {
    /**
     * @param {import('three').Object3D} root @param {import('three').Mesh[]} meshes its primitives
     * @param {import('../file/read.js').NodeData} data @param {string} name
     * @param {Map<any, number>} materials of the file, by mesh
     */
    constructor(root, meshes, data, name, materials = new Map()) {
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
        this.box = new Box3();
        for (const mesh of meshes) {
            if (!mesh.geometry.boundingBox) mesh.geometry.computeBoundingBox();
            this.box.union(mesh.geometry.boundingBox);
        }
        this.firstRow = -1;
        this.lastMatrix = new Matrix4().set(...new Array(16).fill(NaN));
        this.undo = [];
    }

    get lightmapped() {
        return this.placement !== null;
    }

    /** @param {number} instance */
    worldFromObject(instance) {
        const matrix = this.meshes[0].matrixWorld.clone();
        if (!this.meshes[0].isInstancedMesh) return matrix;
        const own = new Matrix4();
        this.meshes[0].getMatrixAt(instance, own);
        return matrix.multiply(own);
    }

    worldBox() {
        const box = new Box3();
        for (let i = 0; i < this.instances; ++i) box.union(this.box.clone().applyMatrix4(this.worldFromObject(i)));
        return box;
    }

    /** Where instance i takes its probe light. */
    anchor(instance) {
        return this.box.getCenter(new Vector3()).applyMatrix4(this.worldFromObject(instance)).toArray();
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
            table.set(this.firstRow + i, 1, [page >= 0 ? 1 : 0, Math.max(page, 0), -1, 0]);
        }
    }

    /** @param {import('./table.js').ObjectTable} table @param {number} instance @param {number} volumeRow */
    setVolume(table, instance, volumeRow) {
        table.set(this.firstRow + instance, 1, [0, 0, volumeRow, 0]);
    }

    /** Lets shaders find the rows and the lightmap coordinates. */
    attach() {
        for (const mesh of this.meshes) {
            const before = mesh.onBeforeRender;
            const row = this.firstRow;
            const hadOwn = Object.hasOwn(mesh, 'onBeforeRender');
            mesh.onBeforeRender = function (renderer, ...rest) {
                // A vertex attribute without an array has one value for all vertices: three.js uploads a material's
                // uniforms once for all objects that share it, so they cannot hold what differs by object.
                if (renderer.isWebGLRenderer) renderer.getContext().vertexAttrib1f(ROW_LOCATION, row);
                before.call(this, renderer, ...rest);
            };
            this.undo.push(() => {
                if (hadOwn) mesh.onBeforeRender = before;
                else delete mesh.onBeforeRender;
            });
            this.attachCoordinates(mesh.geometry);
        }
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

    /** Whether it moved since the last call. */
    moved() {
        if (this.lastMatrix.equals(this.meshes[0].matrixWorld)) return false;
        this.lastMatrix.copy(this.meshes[0].matrixWorld);
        return true;
    }
}

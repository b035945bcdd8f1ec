// The objects that a bake lights: those of the file, of its clones, and of the application.
import { Vector3 } from 'three';

import { Instance, rootOf, stampOf, topOf } from './instances.js';
import { BakedObject } from './objects.js';

export const DYNAMIC = { isStatic: false, castShadows: true, receiveShadows: true, lightmap: null, probes: 'single', probeResolution: [0, 0, 0] };

export class Members {
    /** @param {import('./scene.js').HalflightScene} scene @param {Instance} instance of the file's own scene */
    constructor(scene, instance) {
        this.scene = scene;
        /** @type {BakedObject[]} */
        this.objects = [];
        /** First row of the table by mesh. */
        this.rows = new Map();
        /** Objects of the file by node. */
        this.originals = new Map();
        this.instance = instance;
        this.instances = new Map([[instance.object, instance]]);
    }

    /** @param {BakedObject} object */
    enter(object) {
        object.place(this.scene.table);
        this.objects.push(object);
        for (const mesh of object.meshes) this.rows.set(mesh, object.firstRow);
        if (this.scene.backend) this.attach(object);
    }

    /** An object of the application. @param {any} mesh */
    addMesh(mesh) {
        const data = { ...DYNAMIC, castShadows: mesh.castShadow, receiveShadows: mesh.receiveShadow };
        this.enter(new BakedObject(mesh, [mesh], data, mesh.name, new Map(), this.instanceAt(mesh), null, false));
    }

    /** Of an object of the application: the clone that holds it, or the nearest. */
    instanceAt(mesh) {
        const root = rootOf(mesh, this.scene.file);
        if (root && this.instances.has(root)) return this.instances.get(root);
        const place = new Vector3();
        const distance = (instance) => this.scene.bounds.distanceToPoint(place.setFromMatrixPosition(mesh.matrixWorld).applyMatrix4(instance.bakeFromWorld)) * instance.scale;
        const placed = [...this.instances.values()].filter(({ object, objectFromBake }) => object.parent && !objectFromBake);
        return placed.reduce((best, instance) => (best && distance(best) <= distance(instance) ? best : instance), null) ?? this.instance;
    }

    /** Of an object of a clone. @param {any} object @param {BakedObject} [original] of a mesh */
    instanceOf(object, original) {
        const root = rootOf(object, this.scene.file);
        if (!root && !original) return null;
        const key = root ?? object;
        if (!this.instances.has(key)) this.instances.set(key, new Instance(this.scene.table, key, root ? undefined : original.atLoad));
        return this.instances.get(key);
    }

    /** A mesh of a clone, lit as its original. */
    adopt(mesh) {
        const { file, table, volumes } = this.scene;
        const { node, primitive } = stampOf(mesh, file);
        const original = this.originals.get(node);
        if (!original) return;
        const { isStatic, castShadows, receiveShadows, probes, probeResolution, placement } = original;
        const data = { isStatic, castShadows, receiveShadows, probes, probeResolution, lightmap: placement };
        const material = original.materials.get(original.meshes[primitive]);
        const object = new BakedObject(mesh, [mesh], data, original.name, new Map([[mesh, material]]), this.instanceOf(mesh, original), original);
        object.wasShown = true;
        this.enter(object);
        if (!isStatic) return;
        for (const v of volumes?.volumes ?? [])
            for (let i = 0; i < object.instances; ++i) if (v.object === original && (v.instance < 0 || v.instance === i)) object.setVolume(table, i, v.row);
    }

    /** Switches and material of its meshes. @param {BakedObject} object */
    attach(object) {
        const { data, dynamicLayer, backend } = this.scene;
        object.attach();
        for (const mesh of object.meshes) {
            const before = { castShadow: mesh.castShadow, receiveShadow: mesh.receiveShadow, layers: mesh.layers.mask };
            const switches = data.materials.get(object.materials.get(mesh)) ?? DYNAMIC; // shadows want both switches
            mesh.castShadow = object.castShadows && switches.castShadows;
            mesh.receiveShadow = object.receiveShadows && switches.receiveShadows;
            if (!object.isStatic) mesh.layers.enable(dynamicLayer);
            object.undo.push(() => {
                mesh.castShadow = before.castShadow;
                mesh.receiveShadow = before.receiveShadow;
                mesh.layers.mask = before.layers;
            });
            const undo = backend.patchMesh(mesh, object.fromFile);
            if (undo) object.undo.push(undo);
        }
    }

    /** Forgets objects; materials that no other object has are the application's again. @param {BakedObject[]} gone */
    leave(gone) {
        if (gone.length === 0) return;
        const leaving = new Set(gone);
        this.objects = this.objects.filter((object) => !leaving.has(object));
        const materialsOf = (objects) => objects.flatMap((object) => object.meshes.flatMap((mesh) => mesh.material));
        const used = new Set(materialsOf(this.objects));
        for (const object of gone) {
            object.detach();
            this.scene.table.release(object.firstRow, object.instances);
            for (const mesh of object.meshes) this.rows.delete(mesh);
        }
        for (const material of new Set(materialsOf(gone))) if (!used.has(material)) this.scene.backend?.unpatch(material);
        const places = new Set(this.objects.map((object) => object.instance));
        for (const [key, instance] of this.instances) {
            if (instance === this.instance || places.has(instance)) continue;
            this.instances.delete(key);
            this.scene.table.release(instance.row, 1);
            this.scene.frameLights.drop((state) => state.instance === instance);
        }
    }

    /** @param {any} root */
    remove(root) {
        const below = new Set();
        root.traverse((object) => below.add(object));
        this.leave(this.objects.filter((object) => this.isGuest(object) && object.meshes.some((mesh) => below.has(mesh))));
    }

    isGuest(object) {
        return object.original !== null || !object.fromFile;
    }

    /** Clones and objects of the application that were in a scene and are in none. @param {any} top of the frame's scene */
    drop(top) {
        const gone = [];
        for (const object of this.objects) {
            if (!this.isGuest(object)) continue;
            const own = topOf(object.meshes[0]);
            if (own === top || own.isScene) object.wasShown = true;
            else if (object.wasShown) gone.push(object);
        }
        this.leave(gone);
    }
}

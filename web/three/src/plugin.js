// The plug-in of three.js's GLTFLoader: loader.register((parser) => new HalflightPlugin(parser)).
import { LoaderUtils, MathUtils } from 'three';

import { checkBake } from './file/check.js';
import { isBaked, readBaked } from './file/read.js';
import { checkRelease } from './releases.js';
import { areaLightOf } from './scene/area_lights.js';
import { stampOf } from './scene/instances.js';
import { playPointers } from './scene/pointers.js';
import { HalflightScene } from './scene/scene.js';

export class HalflightPlugin {
    /** @param {any} parser @param {import('./scene/scene.js').Options} [options] */
    constructor(parser, options = {}) {
        checkRelease();
        this.name = 'HALFLIGHT_mixed_lighting';
        this.parser = parser;
        this.options = options;
        /** In userData of the file's objects, and of their clones. */
        this.file = MathUtils.generateUUID();
        /** @type {HalflightScene | null} null until the file is loaded, and for files that are not baked */
        this.scene = null;
    }

    /** Called by GLTFLoader: a broken file is refused before it is loaded. */
    async beforeRoot() {
        if (isBaked(this.parser.json)) checkBake(this.parser.json);
    }

    /** Called by GLTFLoader: other loaders' `associations` do not tell the clones of a mesh apart. @param {number} index */
    loadNode(index) {
        const { parser } = this;
        if (!isBaked(parser.json)) return null;
        const others = Object.values(parser.plugins ?? {}).filter((plugin) => plugin !== this && plugin.loadNode);
        let loading = null;
        for (const plugin of others) loading ??= plugin.loadNode(index);
        return (loading ?? parser.loadNode(index)).then((root) => {
            this.stamp(root, index);
            if (parser.json.nodes[index].extensions?.KHR_node_visibility?.visible === false) root.visible = false;
            return root;
        });
    }

    /** Children that are nodes have their stamps already. */
    stamp(root, node) {
        const { file } = this;
        let primitive = 0;
        const visit = (object) => {
            if (object !== root && stampOf(object, file)) return;
            if (object === root || object.isMesh || object.isLight) object.userData.halflight = { file, node };
            if (object.isMesh) object.userData.halflight.primitive = primitive++;
            object.children.forEach(visit);
        };
        visit(root);
    }

    /** Called by GLTFLoader. @param {any} gltf */
    async afterRoot(gltf) {
        const { parser } = this;
        gltf.userData.halflight = null;
        if (!isBaked(parser.json)) {
            if (lostBake(parser.json)) console.warn(LOST);
            return;
        }
        const accessor = async (index) => plainAccessor(await parser.getDependency('accessor', index));
        const data = await readBaked({
            json: parser.json,
            accessor,
            bufferView: (index) => parser.getDependency('bufferView', index),
            file: (uri) => parser.fileLoader.loadAsync(LoaderUtils.resolveURL(uri, parser.options.path)),
        });
        gltf.scene.userData.halflight = { file: this.file, root: true };
        const { objects, lights, nodes } = collect(gltf.scene, parser.json, this.file);
        this.scene = new HalflightScene(gltf.scene, data, objects, lights, this.options, this.file);
        await playPointers(gltf, parser, this.scene, nodes, lights, accessor);
        gltf.userData.halflight = this.scene;
    }
}

const LOST = 'Halflight: the file was baked, but a tool dropped the bake, extension HALFLIGHT_mixed_lighting: it is shown without. Keep the extension, or bake again';

/** The baker leaves a line in the extras of the scene, which tools keep that drop extensions. */
function lostBake(json) {
    return (json.scenes ?? []).some((scene) => scene.extras?.halflight_baked !== undefined);
}

function plainAccessor(attribute) {
    const { itemSize, count } = attribute;
    const array = new Float64Array(itemSize * count);
    for (let i = 0; i < array.length; ++i) array[i] = attribute.getComponent(Math.floor(i / itemSize), i % itemSize);
    return { array, itemSize, count };
}

/** The nodes with meshes and with lights. GLTFLoader makes one object of a node, or a group of its primitives. */
function collect(scene, json, file) {
    const objects = new Map();
    const lights = [];
    const nodes = new Map();
    scene.updateWorldMatrix(true, true);
    scene.traverse((object) => {
        const { node, primitive } = stampOf(object, file) ?? {};
        if (node === undefined) return;
        if (!nodes.has(node)) nodes.set(node, object);
        const name = json.nodes[node].name ?? `node ${node}`;
        if (object.isLight) lights.push({ light: object, node, name });
        if (!object.isMesh) return;
        if (!objects.has(node)) objects.set(node, { root: nodes.get(node), meshes: [], node, name, materials: new Map() });
        const own = objects.get(node);
        own.meshes.push(object);
        own.materials.set(object, json.meshes[json.nodes[node].mesh]?.primitives[primitive]?.material);
    });
    for (const [node, root] of nodes) {
        const light = areaLightOf(root, json, node);
        if (!light) continue;
        light.userData.halflight = { file, node, isAreaLight: true };
        lights.push({ light, node, name: json.nodes[node].name ?? `node ${node}` });
    }
    return { objects: [...objects.values()], lights, nodes };
}

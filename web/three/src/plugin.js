// The plug-in of three.js's GLTFLoader: loader.register((parser) => new HalflightPlugin(parser)).
import { LoaderUtils } from 'three';

import { isBaked, readBaked } from './file/read.js';
import { checkRelease } from './releases.js';
import { areaLightOf } from './scene/area_lights.js';
import { HalflightScene } from './scene/scene.js';

export class HalflightPlugin {
    /** @param {any} parser @param {import('./scene/scene.js').Options} [options] */
    constructor(parser, options = {}) {
        checkRelease();
        this.name = 'HALFLIGHT_mixed_lighting';
        this.parser = parser;
        this.options = options;
        /** @type {HalflightScene | null} null until the file is loaded, and for files that are not baked */
        this.scene = null;
    }

    /** Called by GLTFLoader. @param {any} gltf */
    async afterRoot(gltf) {
        const { parser } = this;
        gltf.userData.halflight = null;
        if (!isBaked(parser.json)) return;
        const data = await readBaked({
            json: parser.json,
            accessor: async (index) => plainAccessor(await parser.getDependency('accessor', index)),
            bufferView: (index) => parser.getDependency('bufferView', index),
            file: (uri) => parser.fileLoader.loadAsync(LoaderUtils.resolveURL(uri, parser.options.path)),
        });
        const { objects, lights } = collect(gltf.scene, parser);
        this.scene = new HalflightScene(gltf.scene, data, objects, lights, this.options);
        gltf.userData.halflight = this.scene;
    }
}

function plainAccessor(attribute) {
    const { itemSize, count } = attribute;
    const array = new Float64Array(itemSize * count);
    for (let i = 0; i < array.length; ++i) array[i] = attribute.getComponent(Math.floor(i / itemSize), i % itemSize);
    return { array, itemSize, count };
}

/** The nodes with meshes and with lights. GLTFLoader makes one object of a node, or a group of its primitives. */
function collect(scene, parser) {
    const objects = [];
    const lights = [];
    const nodes = new Map();
    scene.updateWorldMatrix(true, true);
    scene.traverse((root) => {
        const node = parser.associations.get(root)?.nodes;
        if (node === undefined) return;
        nodes.set(node, root);
        const name = parser.json.nodes[node].name ?? `node ${node}`;
        const own = (object) => object !== root && parser.associations.get(object)?.nodes !== undefined;
        const visit = (object) => {
            if (own(object)) return;
            if (object.isMesh) meshes.push(object);
            if (object.isLight) lights.push({ light: object, node, name });
            object.children.forEach(visit);
        };
        const meshes = [];
        visit(root);
        const materials = new Map(meshes.map((mesh) => [mesh, parser.associations.get(mesh.material)?.materials]));
        if (meshes.length > 0) objects.push({ root, meshes, node, name, materials });
    });
    for (const [node, root] of nodes) {
        const light = areaLightOf(root, parser.json, node);
        if (light) lights.push({ light, node, name: parser.json.nodes[node].name ?? `node ${node}` });
    }
    return { objects, lights };
}

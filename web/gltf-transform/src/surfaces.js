// While tools work, each node of the bake has a mesh and materials of its own. So no tool joins or instances objects
// that have different places in the lightmap, and none drops the lightmap's coordinates. On writing, what is equal is one
// again.
import { NODE } from './names.js';

/**
 * @param {import('./index.js').HalflightNode} nodeExtension
 * @param {{node: import('@gltf-transform/core').Node, lighting: import('./properties.js').NodeLighting}[]} nodes
 * @param {(page: number) => import('@gltf-transform/core').Texture | null} lightmapOfPage
 */
export function splitSurfaces(nodeExtension, nodes, lightmapOfPage) {
    const meshes = new Map();
    const materials = new Set(); // of which all users have copies
    nodes.forEach(({ node, lighting }, key) => {
        const mesh = node.getMesh();
        if (!mesh) return;
        const { lightmap } = lighting.getRecord();
        if (!meshes.has(mesh)) meshes.set(mesh, meshes.size);
        lighting.set('mesh', meshes.get(mesh));
        const own = mesh.clone();
        for (const primitive of mesh.listPrimitives()) {
            const ownPrimitive = primitive.clone();
            materials.add(primitive.getMaterial());
            ownPrimitive.setMaterial(ownMaterial(nodeExtension, primitive, key, lightmap, lightmapOfPage));
            own.removePrimitive(primitive).addPrimitive(ownPrimitive);
        }
        node.setMesh(own);
    });
    for (const mesh of meshes.keys()) disposeIfUnused(mesh, new Set());
    for (const material of materials) if (material?.listParents().every((parent) => parent.propertyType === 'Root')) material.dispose();
}

function ownMaterial(nodeExtension, primitive, key, lightmap, lightmapOfPage) {
    const source = primitive.getMaterial();
    const material = source ? source.clone() : nodeExtension.document.createMaterial();
    const surface = nodeExtension.createSurface().setKey(key).setWasDefault(!source);
    if (lightmap) surface.setLightmap(lightmapOfPage(lightmap.page ?? 0), lightmap.texCoord);
    return material.setExtension(NODE, surface);
}

/** Undoes splitSurfaces(): to be called before a document is written. */
export function mergeSurfaces(document) {
    const root = document.getRoot();
    followMovedMeshes(root);
    numberSets(root);
    mergeMaterials(root);
    mergeMeshes(root);
}

function lightingNodes(root) {
    return root
        .listNodes()
        .map((node) => ({ node, lighting: node.getExtension(NODE) }))
        .filter(({ lighting }) => lighting);
}

/** quantize() puts the mesh of a node that has children into a new child without a name. */
function followMovedMeshes(root) {
    for (const { node, lighting } of lightingNodes(root)) {
        if (node.getMesh()) continue;
        const moved = node
            .listChildren()
            .filter((child) => child.getMesh() && !child.getName() && !child.getExtension(NODE));
        if (moved.length !== 1) continue;
        node.setExtension(NODE, null);
        moved[0].setExtension(NODE, lighting);
    }
}

/** prune() renumbers texture coordinates for each material, a node names one set for all of its primitives. */
function numberSets(root) {
    for (const { node, lighting } of lightingNodes(root)) {
        const record = lighting.getRecord();
        const mesh = node.getMesh();
        if (!record.lightmap || !mesh) continue;
        const surfaces = mesh
            .listPrimitives()
            .map((primitive) => ({ primitive, surface: primitive.getMaterial()?.getExtension(NODE) }))
            .filter(({ surface }) => surface?.hasLightmap());
        if (surfaces.length === 0) continue;
        // The first set that none of the primitives has for something else. It stands in for those that are missing
        // below it: glTF numbers sets without gaps.
        let texCoord = 1;
        const isTaken = ({ primitive, surface }) =>
            texCoord !== surface.getTexCoord() && primitive.getAttribute(`TEXCOORD_${texCoord}`);
        while (surfaces.some(isTaken)) ++texCoord;
        for (const { primitive, surface } of surfaces) {
            const coordinates = primitive.getAttribute(`TEXCOORD_${surface.getTexCoord()}`);
            if (!coordinates) continue;
            for (let n = 0; n <= texCoord; ++n) {
                if (!primitive.getAttribute(`TEXCOORD_${n}`)) primitive.setAttribute(`TEXCOORD_${n}`, coordinates);
            }
        }
        record.lightmap.texCoord = texCoord;
        lighting.setRecord(record);
    }
}

function mergeMaterials(root) {
    const split = root.listMaterials().filter((material) => material.getExtension(NODE));
    const wasDefault = new Set(split.filter((material) => material.getExtension(NODE).wasDefault()));
    for (const material of split) {
        const surface = material.getExtension(NODE);
        material.setExtension(NODE, null);
        surface.dispose();
    }
    const kept = new Map(); // by name
    for (const material of split) {
        const name = material.getName().replace(/^PaletteMaterial\d+$/, 'PaletteMaterial');
        if (!kept.has(name)) kept.set(name, []);
        const same = kept
            .get(name)
            .find(
                (other) =>
                    wasDefault.has(other) === wasDefault.has(material) && other.equals(material, new Set(['name']))
            );
        if (!same) {
            kept.get(name).push(material);
            continue;
        }
        for (const parent of material.listParents()) if (parent.propertyType !== 'Root') parent.swap(material, same);
        material.dispose();
    }
    for (const material of wasDefault) {
        if (material.isDisposed() || !isDefault(material)) continue;
        for (const parent of material.listParents())
            if (parent.propertyType === 'Primitive') parent.setMaterial(null);
        material.dispose();
    }
}

function isDefault(material) {
    return (
        material.listExtensions().length === 0 &&
        !material.getBaseColorTexture() &&
        material.getBaseColorFactor().every((factor) => factor === 1) &&
        material.getEmissiveFactor().every((factor) => factor === 0)
    );
}

function mergeMeshes(root) {
    const kept = new Map(); // by the mesh they were made of
    const accessors = new Set();
    for (const { node, lighting } of lightingNodes(root)) {
        const mesh = node.getMesh();
        const made = lighting.get('mesh');
        if (!mesh || made < 0) continue;
        if (!kept.has(made)) kept.set(made, []);
        const same = kept.get(made).find((other) => other === mesh || other.equals(mesh));
        if (!same) {
            kept.get(made).push(mesh);
        } else if (same !== mesh) {
            node.setMesh(same);
            disposeIfUnused(mesh, accessors);
        }
    }
    for (const accessor of accessors) {
        if (accessor.listParents().every((parent) => ['Root', 'Buffer'].includes(parent.propertyType)))
            accessor.dispose();
    }
}

function disposeIfUnused(mesh, accessors) {
    if (!mesh.listParents().every((parent) => parent.propertyType === 'Root')) return;
    for (const primitive of mesh.listPrimitives()) {
        for (const accessor of [primitive.getIndices(), ...primitive.listAttributes()]) if (accessor) accessors.add(accessor);
        primitive.dispose();
    }
    mesh.dispose();
}

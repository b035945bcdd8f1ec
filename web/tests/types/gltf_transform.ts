// All of the public API of @halflight/gltf-transform, as a script would use it: compiled by types.test.mjs, never run.
import { Document, NodeIO } from '@gltf-transform/core';
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import {
    AreaLight, AreaLights, HALFLIGHT_EXTENSIONS, HalflightLight, HalflightMaterial, HalflightMixedLighting, HalflightNode, HalflightTextureKtx2,
    LightRecord, MaterialSwitches, MixedLighting, NodeLighting, type PictureKey, type ProbeAccessor,
} from '@halflight/gltf-transform';
import config from '@halflight/gltf-transform/halflight.config.mjs';

export async function list(path: string): Promise<string[]> {
    const io = new NodeIO().registerExtensions([...ALL_EXTENSIONS, ...HALFLIGHT_EXTENSIONS, ...config.extensions]);
    const document: Document = await io.read(path);
    const root = document.getRoot();
    const lighting = root.getExtension<MixedLighting>(MixedLighting.EXTENSION_NAME);
    const key: PictureKey = 'shadowmasks/0';
    const ofGroup: PictureKey = 'groups/0/lightmaps/1';
    const reflected: PictureKey = 'groups/0/reflections';
    lighting?.setPicture(reflected, lighting.getPicture(reflected));
    lighting?.setPicture(ofGroup, lighting.getPicture(ofGroup)).setProbeAccessor('groups/0/radiance', lighting.getProbeAccessor('groups/0/radiance'));
    const accessor: ProbeAccessor = 'tetrahedra';
    const names = (lighting?.listPictures() ?? []).map(([name, texture]) => `${name} ${texture.getMimeType()}`);
    lighting?.setPicture(key, lighting.getPicture(key)).setProbeAccessor(accessor, lighting.getProbeAccessor(accessor));
    lighting?.setPlaceholder(lighting.getPlaceholder());
    for (const node of root.listNodes()) {
        const own = node.getExtension<NodeLighting>(NodeLighting.EXTENSION_NAME);
        own?.setRecord({ ...own.getRecord(), castShadows: false });
        names.push(JSON.stringify(node.getExtension<AreaLight>(AreaLight.EXTENSION_NAME)?.getRecord()));
        names.push(JSON.stringify(node.getExtension<LightRecord>(LightRecord.EXTENSION_NAME)?.getRecord()));
    }
    // @ts-expect-error there is no such accessor
    lighting?.getProbeAccessor('colours');
    return names;
}

export function make(document: Document): (NodeLighting | LightRecord | MaterialSwitches | MixedLighting)[] {
    document.createExtension(HalflightTextureKtx2);
    document.createExtension(AreaLights).createAreaLight();
    return [
        document.createExtension(HalflightMixedLighting).createMixedLighting(),
        document.createExtension(HalflightNode).createNodeLighting(),
        document.createExtension(HalflightLight).createLightRecord(),
        document.createExtension(HalflightMaterial).createMaterialSwitches(),
    ];
}

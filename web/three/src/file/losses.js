// What a tool dropped of a bake, by what the baker wrote down: docs/format.md, "At the bake".

/** Whether each primitive of a node's mesh has TEXCOORD_n. */
export function hasSet(json, node, n) {
    return (json.meshes?.[node.mesh]?.primitives ?? []).every((primitive) => primitive.attributes?.[`TEXCOORD_${n}`] !== undefined);
}

const nodesWith = (json, test) => (json.nodes ?? []).filter((node) => test(node, node.extensions ?? {}));

/** @param {any} json @returns {string[]} parts, in words */
export function lossesOf(json) {
    const root = json.extensions.HALFLIGHT_mixed_lighting;
    const atBake = root.atBake ?? {};
    const lightmapped = nodesWith(json, (_, e) => e.HALFLIGHT_node?.lightmap);
    const withoutSet = lightmapped.filter((node) => !hasSet(json, node, node.extensions.HALFLIGHT_node.lightmap.texCoord ?? 1));
    const lights = nodesWith(json, (_, e) => ['mixed', 'baked'].includes(e.HALFLIGHT_light?.baking?.bakeType));
    const lost = [];
    const count = (then, now, what) => {
        if (then > now) lost.push(`${then - now} of ${then} ${what}`);
    };
    count(atBake.lightmappedNodes, lightmapped.length, "objects' places in the lightmap");
    count(atBake.staticNodes, nodesWith(json, (_, e) => e.HALFLIGHT_node?.static).length, 'static objects');
    count(atBake.bakedLights, lights.length, 'baked lights');
    if (withoutSet.length > 0)
        lost.push(`the lightmap coordinates of objects ${withoutSet.map((node) => `"${node.name ?? json.nodes.indexOf(node)}"`).join(', ')}: probes light them`);
    const members = (atBake.members ?? []).filter((path) => path.split('/').reduce((value, step) => value?.[step], root) === undefined);
    for (const path of members) lost.push(`its ${path}`);
    const masked = lights.some((node) => node.extensions.HALFLIGHT_light.baking.occlusionMaskChannel >= 0);
    if (members.length === 0 && root.mode === 'shadowmask' && masked && root.lightmaps?.length > 0 && !(root.shadowmasks?.length > 0)) lost.push('its shadowmasks');
    return lost;
}

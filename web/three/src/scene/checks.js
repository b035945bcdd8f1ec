// What an application did to a baked file that its bake does not follow: a sentence for each, while it is so.
/** @param {import('./scene.js').HalflightScene} scene @param {Set<any>} lights that are drawn or hidden below the top */
export function checkFrame(scene, lights) {
    checkInstances(scene);
    for (const object of scene.objects) {
        checkMaterials(scene, object);
        if (scene.mode !== 'realtime' && object.fromFile && object.isStatic) checkPlace(scene, object);
    }
    if (scene.mode === 'realtime') return;
    for (const state of scene.lights) {
        if (!lights.has(state.light)) continue;
        const moved = state.moved();
        if (moved) scene.say(moved);
        const changed = state.changed();
        if (changed) scene.say(changed);
    }
}

function checkInstances(scene) {
    for (const { object, uniform } of scene.members.instances.values())
        if (!uniform)
            scene.say(`"${object.name || 'the scene of the file'}" is scaled by axis or sheared: its baked light fits no such shape, so give it one scale for all axes`);
}

function checkMaterials(scene, object) {
    for (const { material } of object.meshes) {
        if (Array.isArray(material)) for (const own of material) checkMaterial(scene, object, own);
        else checkMaterial(scene, object, material);
    }
}

function checkMaterial(scene, object, material) {
    if (!material || scene.backend.shows(material) || material.isMeshBasicMaterial) return;
    if (!material.isMeshStandardMaterial)
        scene.say(`material "${material.name}" of "${object.name}" is a ${material.type}: only MeshStandardMaterial and MeshPhysicalMaterial show the bake`);
    else
        scene.say(`"${object.name}" got another material, "${material.name}", which does not show the bake: give it before the first update(), or change the file's own`);
}

function checkPlace(scene, object) {
    if (object.strayed)
        scene.say(`static object "${object.name}" moved since its bake: its baked light and shadows stay as they were; make it dynamic or bake again`);
}

// The types of @halflight/aframe, as a page would use them: compiled by types.mjs, never run.
import type { HalflightModelComponent, HalflightModelData, HalflightModelLoaded } from '@halflight/aframe';

export function watch(entity: HTMLElement & { components: Record<string, unknown> }): void {
    const component = entity.components['halflight-model'] as HalflightModelComponent;
    const data: HalflightModelData = component.data;
    entity.addEventListener('model-loaded', (event) => {
        const { halflight, gltf, model } = (event as CustomEvent<HalflightModelLoaded>).detail;
        if (halflight) halflight.mode = data.mode || halflight.modes[0]!;
        console.log(gltf.cameras.length, model.name, component.halflight === halflight);
        // @ts-expect-error it has a type: there is no such method
        halflight?.draw();
    });
}

// <HalflightModel url="baked.glb" mode="shadowmask" position={[0, 1, 0]} />: each has objects of its own.
import { useThree } from '@react-three/fiber';
import { createContext, createElement, useEffect, useLayoutEffect, useMemo } from 'react';
import { clone } from 'three/addons/utils/SkeletonUtils.js';

import { freeObjects } from './life.js';
import { useHalflight } from './use_halflight.js';

/** The bake of the model above: null where its file is not baked, undefined where there is no model. */
export const Bake = createContext(undefined);

/** @param {import('../types/index.js').HalflightModelProps} props */
export function HalflightModel({ url, options, mode, shadowDistance, shadowFadeRange, debugView, children, ...props }) {
    const [gltf, halflight] = useHalflight(url, options);
    const objects = useMemo(() => clone(gltf.scene), [gltf]);
    const invalidate = useThree((state) => state.invalidate);
    useEffect(() => () => freeObjects(objects, false), [objects]);
    useLayoutEffect(() => {
        if (!halflight) return;
        const settings = Object.entries({ mode, shadowDistance, shadowFadeRange, debugView });
        for (const [name, value] of settings) if (value !== undefined) halflight[name] = value;
        invalidate();
    }, [halflight, mode, shadowDistance, shadowFadeRange, debugView, invalidate]);
    const model = createElement('group', props, createElement('primitive', { object: objects }), children);
    return createElement(Bake.Provider, { value: halflight }, model);
}

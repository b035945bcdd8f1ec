// useBakedObject(ref): the bake's probes light an object of the application.
import { useThree } from '@react-three/fiber';
import { useContext, useLayoutEffect } from 'react';

import { Bake } from './model.js';

const NO_BAKE =
    'useBakedObject() has no bake: call it below a <HalflightModel>, or pass the halflight of useHalflight()';

/** @param {{current: any}} ref @param {any} [own] bake of useHalflight(); that of the model above where absent */
export function useBakedObject(ref, own) {
    const above = useContext(Bake);
    const halflight = own === undefined ? above : own;
    const invalidate = useThree((state) => state.invalidate);
    if (halflight === undefined) throw new Error(NO_BAKE);
    useLayoutEffect(() => {
        const object = ref.current;
        if (!halflight || !object) return undefined;
        halflight.add(object);
        invalidate();
        return () => {
            halflight.remove(object);
            invalidate();
        };
    }, [ref, halflight, invalidate]);
}

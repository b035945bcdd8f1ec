// Baked files in react-three-fiber.
export { useBakedObject } from './baked_object.js';
export { HalflightModel } from './model.js';
export { useHalflight } from './use_halflight.js';

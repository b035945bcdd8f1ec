import type { Extension } from '@gltf-transform/core';

declare const config: { extensions: (typeof Extension)[] };
export default config;

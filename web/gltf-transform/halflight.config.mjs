// gltf-transform optimize IN OUT --config node_modules/@halflight/gltf-transform/halflight.config.mjs
import { ALL_EXTENSIONS } from '@gltf-transform/extensions';
import { HALFLIGHT_EXTENSIONS } from './src/index.js';

export default { extensions: [...ALL_EXTENSIONS, ...HALFLIGHT_EXTENSIONS] };

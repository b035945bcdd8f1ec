// The plug-in for WebGPURenderer: import this in place of '@halflight/three', with three.js's WebGPU build as 'three'.
import { useBackend } from './scene/scene.js';
import { WebGPUBackend } from './webgpu/backend.js';

useBackend('isWebGPURenderer', WebGPUBackend);
export { HalflightPlugin } from './plugin.js';
export { HalflightScene } from './scene/scene.js';
export { MODES, VIEWS } from './scene/modes.js';
export { RELEASES } from './releases.js';

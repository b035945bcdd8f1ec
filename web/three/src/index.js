// The plug-in for WebGLRenderer.
import { useBackend } from './scene/scene.js';
import { WebGLBackend } from './webgl/backend.js';

useBackend('isWebGLRenderer', WebGLBackend);
export { HalflightPlugin } from './plugin.js';
export { HalflightScene } from './scene/scene.js';
export { MODES, VIEWS } from './scene/modes.js';
export { RELEASES } from './releases.js';

export { HalflightPlugin } from './plugin.js';
export { HalflightScene } from './scene/scene.js';
export { MODES, VIEWS } from './scene/modes.js';
export { RELEASES } from './releases.js';

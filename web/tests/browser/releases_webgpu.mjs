import { compareReleases } from '../releases.mjs';

compareReleases('webgpu');

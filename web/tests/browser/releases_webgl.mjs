import { compareReleases } from '../releases.mjs';

compareReleases('webgl');

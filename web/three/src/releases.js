// Which releases of three.js the patches fit.
import { REVISION } from 'three';

export const RELEASES = ['183', '184', '185', '186', '187'];

/** Throws one sentence where three.js is a release whose shaders this program was not tested with. */
export function checkRelease() {
    const revision = REVISION.replace(/\D.*$/, '');
    if (RELEASES.includes(revision)) return;
    throw new Error(
        `Halflight works with three.js 0.${RELEASES[0]} to 0.${RELEASES.at(-1)}; this page has 0.${revision}, whose shaders may differ`
    );
}

// Each example as it stands in web/examples, built, against the program's picture of the courtyard.
import assert from 'node:assert/strict';
import { copyFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { studio } from '../browser/studio.mjs';
import { comparePage, makeWorkspace, pictureOf, runIn, SIZE } from './workspace.mjs';

let made = null;

function workspace() {
    if (made) return made;
    studio.bake('courtyard', 'courtyard', '--lightmap-size', '256');
    const folder = makeWorkspace('examples');
    runIn(folder, 'vite', 'build');
    const { reference } = pictureOf('courtyard', SIZE, '--mode', 'shadowmask', '--exposure', '2');
    made = { folder, reference };
    return made;
}

/** Sentences of the frameworks about themselves. */
const OWN = /THREE.Clock|Clock: This module has been deprecated|A-Frame Version|super-three/;

for (const [name, path] of [['react', 'dist/react'], ['threlte', 'dist/threlte'], ['tres', 'dist/tres'], ['aframe', 'aframe']]) {
    test(`examples: ${name}`, async () => {
        const { folder, reference } = workspace();
        copyFileSync(studio.pathOf('courtyard'), join(folder, path, 'courtyard-baked.glb'));
        // A-Frame's button for headsets would be in the picture.
        const served = path.startsWith('dist') ? [join(folder, 'dist'), `${name}/index.html`] : [join(folder, path), 'index.html?ui=false'];
        const trouble = await comparePage(...served, `example, ${name}`, reference);
        assert.deepEqual(trouble.filter((sentence) => !OWN.test(sentence)), []);
    });
}

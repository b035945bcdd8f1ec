// Puts the viewer into one static folder that needs no network: node scripts/build_viewer.mjs OUT [BAKED.glb]
import { cpSync, existsSync, mkdirSync, readFileSync } from 'node:fs';
import { dirname, join, relative } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const [out, showcase] = process.argv.slice(2);
if (!out) {
    console.error('usage: node scripts/build_viewer.mjs OUT [BAKED.glb]');
    process.exit(2);
}
const three = join(web, 'node_modules/three');
if (!existsSync(three)) {
    console.error('build_viewer.mjs: no packages found: run npm install in web/');
    process.exit(1);
}

/** A module and those that it imports by a relative path. */
function copyModule(path, seen) {
    if (seen.has(path)) return;
    seen.add(path);
    const target = join(out, 'lib/three', relative(three, path));
    mkdirSync(dirname(target), { recursive: true });
    cpSync(path, target);
    for (const match of readFileSync(path, 'utf8').matchAll(/(?:from|import)\s*['"](\.[^'"]+)['"]/g)) copyModule(join(dirname(path), match[1]), seen);
}

mkdirSync(out, { recursive: true });
for (const file of ['index.html', 'viewer.css', 'viewer.js', 'flight.js', 'link.js', 'panel.js']) cpSync(join(web, 'viewer', file), join(out, file));
cpSync(join(web, 'three/src'), join(out, 'lib/halflight'), { recursive: true });
cpSync(join(three, 'LICENSE'), join(out, 'lib/three-LICENSE'));
const addons = ['loaders/GLTFLoader.js', 'controls/OrbitControls.js', 'libs/meshopt_decoder.module.js', 'libs/ktx-parse.module.js', 'libs/zstddec.module.js'];
const seen = new Set();
for (const file of ['build/three.module.js', ...addons.map((name) => `examples/jsm/${name}`)]) copyModule(join(three, file), seen);
if (showcase) cpSync(showcase, join(out, 'courtyard-baked.glb'));

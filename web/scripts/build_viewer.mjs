// Puts the viewer into one static folder that needs no network: node scripts/build_viewer.mjs OUT [BAKED.glb]
import { cpSync, existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const [out, showcase] = process.argv.slice(2);
if (!out) {
    console.error('usage: node scripts/build_viewer.mjs OUT [BAKED.glb]');
    process.exit(2);
}
if (!existsSync(join(web, 'node_modules/esbuild'))) {
    console.error('build_viewer.mjs: no packages found: run npm install in web/');
    process.exit(1);
}
const { build } = await import('esbuild');

mkdirSync(out, { recursive: true });
await build({
    entryPoints: [join(web, 'viewer/viewer.js'), join(web, 'viewer/viewer.css')],
    outdir: out,
    bundle: true,
    minify: true,
    format: 'esm',
    target: 'es2022',
    legalComments: 'none', // all licences are in one file
    logLevel: 'warning',
});
cpSync(join(web, 'viewer/index.html'), join(out, 'index.html'));
const licences = [
    ['Halflight', 'three/LICENSE'],
    ['three.js', 'node_modules/three/LICENSE'],
    ['ktx-parse and zstddec', 'node_modules/ktx-parse/LICENSE'],
];
const texts = licences.map(([name, path]) => `${name}\n\n${readFileSync(join(web, path), 'utf8')}`);
const decoder = readFileSync(join(web, 'node_modules/three/examples/jsm/libs/meshopt_decoder.module.js'), 'utf8').match(
    /^(\/\/.*\n)+/
)[0];
writeFileSync(join(out, 'LICENSES.txt'), [...texts, decoder.replaceAll(/^\/\/ /gm, '')].join('\n\n'));
if (showcase) cpSync(showcase, join(out, 'courtyard-baked.glb'));

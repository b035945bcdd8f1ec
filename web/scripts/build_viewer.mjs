// Puts the viewer into one static folder that needs no network:
//
//   node scripts/build_viewer.mjs OUT [BAKED.glb] [--no-baker]
//
// The baker goes with it where scripts/build-wasm.sh has built it; --no-baker leaves it out.
import { cpSync, existsSync, mkdirSync, readdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const web = join(dirname(fileURLToPath(import.meta.url)), '..');
const words = process.argv.slice(2);
const [out, showcase] = words.filter((word) => word !== '--no-baker');
const baker = join(web, 'bake');
const hasBaker = !words.includes('--no-baker') && existsSync(join(baker, 'wasm/halflight.wasm'));
if (!out) {
    console.error('usage: node scripts/build_viewer.mjs OUT [BAKED.glb] [--no-baker]');
    process.exit(2);
}
if (!existsSync(join(web, 'node_modules/esbuild'))) {
    console.error('build_viewer.mjs: no packages found: run npm install in web/');
    process.exit(1);
}
const { build } = await import('esbuild');

mkdirSync(out, { recursive: true });
const bundle = (names, outdir, options) =>
    build({
        entryPoints: names,
        outdir,
        bundle: true,
        minify: true,
        format: 'esm',
        target: 'es2022',
        legalComments: 'none', // all licences are in one file
        logLevel: 'warning',
        ...options,
    });
await bundle([join(web, 'viewer/viewer.js'), join(web, 'viewer/viewer.css')], out, {
    define: { HAS_BAKER: String(hasBaker) },
});
const page = readFileSync(join(web, 'viewer/index.html'), 'utf8');
writeFileSync(join(out, 'index.html'), hasBaker ? page : page.replace(/^.*isolate\.js.*\n/m, ''));
rmSync(join(out, 'bake'), { recursive: true, force: true }); // of an earlier run
rmSync(join(out, 'isolate.js'), { force: true });
if (hasBaker) {
    const programs = ['src/index.js', 'src/program_web.js'].map((name) => join(baker, name));
    await bundle(programs, join(out, 'bake/src'), { external: ['../wasm/*'] });
    cpSync(join(baker, 'wasm'), join(out, 'bake/wasm'), { recursive: true });
    cpSync(join(baker, 'src/isolate.js'), join(out, 'isolate.js'));
}
const licences = [
    ['Halflight', 'three/LICENSE'],
    ['three.js', 'node_modules/three/LICENSE'],
    ['ktx-parse and zstddec', 'node_modules/ktx-parse/LICENSE'],
];
const texts = licences.map(([name, path]) => `${name}\n\n${readFileSync(join(web, path), 'utf8')}`);
const decoder = readFileSync(join(web, 'node_modules/three/examples/jsm/libs/meshopt_decoder.module.js'), 'utf8').match(
    /^(\/\/.*\n)+/
)[0];
const linked = hasBaker ? readdirSync(join(baker, 'licenses')).sort() : [];
const ofBaker = linked.map(
    (name) => `The baker: ${name.replace(/\.txt$/, '')}\n\n${readFileSync(join(baker, 'licenses', name), 'utf8')}`
);
writeFileSync(join(out, 'LICENSES.txt'), [...texts, decoder.replaceAll(/^\/\/ /gm, ''), ...ofBaker].join('\n\n'));
if (showcase) cpSync(showcase, join(out, 'courtyard-baked.glb'));

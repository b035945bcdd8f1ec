// Runs tools on a baked file and looks at what is left of its bake.
//
//   node test/keeps_bake.mjs HALFLIGHT FILE.glb [CAMERA]
//
// HALFLIGHT is the program's path; a FILE that is not baked is baked first. Prints a table for docs/format.md; exits with 1
// when a command that should keep the bake does not, and with 77 where the npm packages are not installed.
import { execFileSync } from 'node:child_process';
import { existsSync, mkdtempSync, realpathSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const [halflight, file, camera] = process.argv.slice(2);
const config = join(dirname(fileURLToPath(import.meta.url)), '..', 'halflight.config.mjs');
/** Mean difference of levels (of 255) up to which a picture counts as the same: positions and textures lose bits. */
const SAME = 1.5;

function binary(name) {
    for (let folder = dirname(fileURLToPath(import.meta.url)); ; folder = dirname(folder)) {
        const file = join(folder, 'node_modules', '.bin', name);
        if (existsSync(file)) return realpathSync(file);
        if (folder === dirname(folder)) return null;
    }
}

const transform = binary('gltf-transform');
const gltfpack = binary('gltfpack');
if (!halflight || !file) {
    console.error('usage: node keeps_bake.mjs HALFLIGHT FILE.glb [CAMERA]');
    process.exit(2);
}
if (!transform) {
    console.log('skipped: the npm package @gltf-transform/cli is not installed (npm install in web)');
    process.exit(77);
}

const folder = mkdtempSync(join(tmpdir(), 'keeps_bake_'));
const run = (file, args) => execFileSync(file, args, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'pipe'], maxBuffer: 1 << 28 });
let baked = file;
if (!JSON.parse(run(halflight, ['info', '--json', file])).baked) {
    baked = join(folder, 'baked.glb');
    // Under a picture of 8 x 4 texels, so that there is one to keep.
    const texels = Buffer.from(Array.from({ length: 32 }, (_, i) => [90 + 5 * i, 120, 250 - 5 * i, 129]).flat());
    writeFileSync(join(folder, 'sky.hdr'), Buffer.concat([Buffer.from('#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n'), texels]));
    writeFileSync(join(folder, 'sky.toml'), '[sky]\nimage = "sky.hdr"\n');
    run(halflight, ['bake', file, '-o', baked, '--quality', 'preview', '--settings', join(folder, 'sky.toml')]);
}
const picture = (file, name) => {
    const png = join(folder, `${name}.png`);
    run(halflight, ['render', file, '-o', png, '--size', '480x270', ...(camera ? ['--camera', camera] : [])]);
    return png;
};
const difference = (a, b) => {
    const sharp = createRequire(transform)('sharp');
    return Promise.all([a, b].map((file) => sharp(file).removeAlpha().raw().toBuffer())).then(([x, y]) => {
        let sum = 0;
        for (let i = 0; i < x.length; ++i) sum += Math.abs(x[i] - y[i]);
        return sum / x.length;
    });
};

const withConfig = (command, ...options) => (out) =>
    run(process.execPath, [transform, command, baked, out, ...options, '--config', config]);
const commands = {
    'gltf-transform optimize': [withConfig('optimize'), true],
    'gltf-transform optimize --texture-compress webp': [withConfig('optimize', '--texture-compress', 'webp'), true],
    'gltf-transform prune': [withConfig('prune'), true],
    'gltf-transform dedup': [withConfig('dedup'), true],
    'gltf-transform webp': [withConfig('webp'), true],
    'gltf-transform meshopt': [withConfig('meshopt'), true],
    'gltf-transform draco': [withConfig('draco'), true],
    'gltf-transform optimize, without the config': [
        (out) => run(process.execPath, [transform, 'optimize', baked, out]),
        false,
    ],
    'gltfpack -kn -km -ke -kv -noq': [
        (out) => run(process.execPath, [gltfpack, '-i', baked, '-o', out, '-kn', '-km', '-ke', '-kv', '-noq']),
        false,
    ],
    'halflight optimize': [(out) => run(halflight, ['optimize', baked, out]), true],
};

let failed = false;
try {
    const reference = picture(baked, 'reference');
    console.log(`| command | MB | kept | picture differs by (of 255) | what \`halflight info\` says |`);
    console.log('|---|---|---|---|---|');
    console.log(`| (the baked file) | ${(statSync(baked).size / 1e6).toFixed(2)} | | | |`);
    for (const [name, [command, keeps]] of Object.entries(commands)) {
        if (name.startsWith('gltfpack') && !gltfpack) continue;
        const out = join(folder, 'out.glb');
        rmSync(out, { force: true });
        command(out);
        if (!existsSync(out)) throw new Error(`${name} wrote no file`);
        const info = JSON.parse(run(halflight, ['info', '--json', out]));
        const off = await difference(reference, picture(out, 'out'));
        const stale = info.warnings.filter((warning) => warning.startsWith('is stale'));
        const kept = info.baked && info.lost.length === 0 && stale.length === 0 && off <= SAME;
        if (kept !== keeps) failed = true;
        const said = [...info.lost.map((lost) => `lost: ${lost}`), ...stale].join('; ');
        const size = (statSync(out).size / 1e6).toFixed(2);
        console.log(`| \`${name}\` | ${size} | ${kept ? 'yes' : 'no'} | ${off.toFixed(2)} | ${said} |`);
    }
} finally {
    if (process.env.KEEP) console.error(folder);
    else rmSync(folder, { recursive: true, force: true });
}
process.exit(failed ? 1 : 0);

// Draws docs/images/chapel.webp: the chapel in four moods, by the weights of its light groups alone, and its fire.
//
//   scripts/make_chapel.py
//   halflight bake assets/chapel.glb -o chapel.glb --texels-per-meter 10
//   node scripts/make_chapel_movie.mjs HALFLIGHT chapel.glb [OUT.webp] [--keep DIR]
//
// Each frame is a picture of `HALFLIGHT render --group …`, all at one exposure. --keep writes the frames as PNG too. It needs
// npm install in web/. scripts/measure_chapel.py measures the same moods (MOODS in chapel_moods.json).
import { execFileSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
const [WIDTH, HEIGHT] = [640, 360];
const MILLISECONDS = 110; // of a frame
const HOLD = 7; // frames of a mood
const FADE = 4; // frames to the next
const { exposure, camera, moods } = JSON.parse(readFileSync(join(here, 'chapel_moods.json')));

const positional = process.argv.slice(2).filter((a, i, all) => a !== '--keep' && all[i - 1] !== '--keep');
const keep = process.argv.includes('--keep') ? process.argv[process.argv.indexOf('--keep') + 1] : null;
const [program, baked, out = join(here, '../docs/images/chapel.webp')] = positional;
if (!baked) {
    console.error('usage: node scripts/make_chapel_movie.mjs HALFLIGHT BAKED.glb [OUT.webp] [--keep DIR]');
    process.exit(2);
}

/** Brightness of the fire in frame i of n: waves that fit into the movie, so that it has no beginning. */
function flicker(i, n) {
    const wave = (times, phase) => Math.sin((2 * Math.PI * times * i) / n + phase);
    return 1 + 0.12 * wave(9, 0.3) + 0.1 * wave(14, 1.9) + 0.07 * wave(19, 4.0);
}

/** Weights of frame i: a mood, or the way to the next. */
function weightsOf(i, n) {
    const names = Object.keys(moods);
    const mood = Math.floor(i / (HOLD + FADE));
    const share = Math.max(0, (i % (HOLD + FADE)) - HOLD + 1) / (FADE + 1);
    const [from, to] = [moods[names[mood]], moods[names[(mood + 1) % names.length]]];
    return Object.keys(from).map((group) => {
        const scale = group === 'fire' ? flicker(i, n) : 1;
        const weight = from[group].map((w, c) => scale * (w + share * (to[group][c] - w)));
        return `${group}=${weight.map((w) => w.toFixed(5)).join(',')}`;
    });
}

const folder = keep ?? mkdtempSync(join(tmpdir(), 'halflight-chapel-'));
mkdirSync(folder, { recursive: true });
const count = Object.keys(moods).length * (HOLD + FADE);
const sharp = createRequire(join(here, '../web/package.json'))('sharp');
const raw = [];
for (let i = 0; i < count; ++i) {
    const file = join(folder, `frame${String(i).padStart(2, '0')}.png`);
    const groups = weightsOf(i, count).flatMap((weight) => ['--group', weight]);
    const options = ['--camera', camera, '--exposure', String(exposure), '--size', `${WIDTH}x${HEIGHT}`, '--samples', '4', '--quiet'];
    execFileSync(program, ['render', baked, '-o', file, ...options, ...groups]);
    raw.push(await sharp(file).removeAlpha().raw().toBuffer());
}
if (!keep) rmSync(folder, { recursive: true });
const stacked = sharp(Buffer.concat(raw), { limitInputPixels: false, raw: { width: WIDTH, height: HEIGHT * count, channels: 3, pageHeight: HEIGHT } });
const { size } = await stacked.webp({ quality: 70, effort: 5, minSize: true, loop: 0, delay: raw.map(() => MILLISECONDS) }).toFile(out);
console.log(`${out}: ${count} frames, ${(size / 1e6).toFixed(2)} MB`);

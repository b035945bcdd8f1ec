// Nightly: the live demo as scripts/site.sh makes it: bytes of its file, and how soon its page shows a picture.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, readFileSync, rmSync, statSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';

import { findProgram, missing, repository, web } from './harness.mjs';

const reason = missing();
if (reason) {
    console.log(`[  SKIPPED ] web.showcase: ${reason}`);
    process.exit(0);
}
const folder = mkdtempSync(join(tmpdir(), 'halflight-showcase-'));
after(() => rmSync(folder, { recursive: true }));
const run = (command, ...words) => execFileSync(command, words, { encoding: 'utf8', stdio: ['ignore', 'pipe', 'inherit'] });

/** The page without its first picture: it draws the whole one at once, as the page did before it had a first one. */
function withoutFirstPicture(viewer, out) {
    cpSync(viewer, out, { recursive: true });
    const script = readFileSync(join(viewer, 'viewer.js'), 'utf8');
    const [, isWhole] = /dataset\.picture=this\.(#\w+)\?"whole":"first"/.exec(script);
    const parts = script.split(`this.${isWhole}=!1,`);
    assert.equal(parts.length, 2, 'the place where a file begins with its first picture');
    writeFileSync(join(out, 'viewer.js'), parts.join(`this.${isWhole}=!0,`));
}

test('showcase: at most 3 MB at medium, with the options of the live demo', () => {
    run(join(repository, 'scripts/site/bake_showcase.sh'), findProgram(), folder, 'medium');
    const { size } = statSync(join(folder, 'courtyard-baked.glb'));
    console.log(`the showcase at medium: ${(size / 1e6).toFixed(2)} MB`);
    assert.ok(size <= 3e6, `courtyard-baked.glb has ${size} bytes`);
});

test('showcase: the first picture takes at most half the time of a page that draws the whole one at once', () => {
    const [viewer, other] = ['viewer', 'other'].map((name) => join(folder, name));
    run(process.execPath, join(web, 'scripts/build_viewer.mjs'), viewer, join(folder, 'courtyard-baked.glb'), '--no-baker');
    withoutFirstPicture(viewer, other);
    const table = run(process.execPath, join(web, 'bench/first_picture.mjs'), viewer, other);
    console.log(table);
    const ratio = Number(/ratio (\S+)/.exec(table)[1]);
    assert.ok(ratio <= 0.5, `ratio ${ratio}`);
});

// The committed shader text is what the shading headers give.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { existsSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { preprocess, prefixed } from '../scripts/headers.mjs';
import { findProgram, web } from './harness.mjs';

if (!existsSync(join(web, 'node_modules/three'))) {
    console.log('[  SKIPPED ] web.generated: no packages found: run npm install in web/');
    process.exit(0);
}

test('generated files are what the headers give', () => {
    execFileSync(process.execPath, [join(web, 'scripts/generate.mjs'), '--check'], { stdio: 'pipe' });
});

test('options of the packages of WebAssembly are what the program describes', { skip: !findProgram() && 'no halflight program' }, () => {
    execFileSync(process.execPath, [join(web, 'scripts/generate_bake.mjs'), findProgram(), '--check'], { stdio: 'pipe' });
});

test('a changed header changes the text', () => {
    const header = (body) => preprocess(['a.h'], () => `#ifdef __cplusplus\nint c;\n#else\n#endif\nHL_FN float half(float x)\n{\n    return ${body}; // comment\n}\n`);
    assert.equal(prefixed(header('0.5f * x')), 'float hlHalf(float x)\n{\n    return 0.5 * x;\n}\n');
    assert.notEqual(header('0.5f * x'), header('0.25f * x'));
});

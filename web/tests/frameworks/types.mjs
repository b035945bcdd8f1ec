// Declarations of @halflight/react and @halflight/aframe, as packed, in strict TypeScript; and that both need no window where they can.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { web } from '../harness.mjs';
import { makeWorkspace, runIn, unpackInto } from './workspace.mjs';

test('types: every name of @halflight/react and @halflight/aframe in strict TypeScript', () => {
    const folder = makeWorkspace('types');
    unpackInto(folder, 'aframe');
    cpSync(join(web, 'tests/frameworks/types'), join(folder, 'types'), { recursive: true });
    try {
        runIn(folder, 'tsc', '-p', 'types');
    } catch (error) {
        assert.fail(error.stdout);
    }
});

test('types: @halflight/react may be imported where there is no window', () => {
    const folder = makeWorkspace('server');
    const script = "if (typeof window !== 'undefined') throw new Error('a window'); const all = await import('@halflight/react'); console.log(Object.keys(all).sort().join())";
    const printed = execFileSync(process.execPath, ['--preserve-symlinks', '--input-type=module', '-e', script], { cwd: folder, encoding: 'utf8' });
    assert.equal(printed.trim(), 'HalflightModel,useBakedObject,useHalflight');
});

// Pages and apps made by the commands of docs/web.md, with our packages as npm packs them: they show the courtyard.
import assert from 'node:assert/strict';
import { execSync, spawnSync } from 'node:child_process';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';

import { repository } from '../harness.mjs';
import { studio } from '../browser/studio.mjs';
import { comparePage, packageOf, pictureOf, SIZE } from './workspace.mjs';

const text = readFileSync(join(repository, 'docs/web.md'), 'utf8');
let reachable = null;

/** Skips a test with a sentence where npm's registry cannot be reached. */
function skipOffline(t) {
    const view = ['view', 'create-vite', 'version', '--fetch-retries=0', '--fetch-timeout=20000'];
    reachable ??= spawnSync('npm', view, { encoding: 'utf8', timeout: 60000 }).status === 0;
    if (reachable) return false;
    console.log('[  SKIPPED ] web.frameworks_create: npm or its registry cannot be reached');
    t.skip('npm or its registry cannot be reached');
    return true;
}

/** The block of a language below a heading. */
function blockOf(heading, language) {
    const section = text.slice(text.indexOf(`\n## ${heading}\n`));
    return section.match(new RegExp(`^\`\`\`${language}\\n([\\s\\S]*?)^\`\`\``, 'm'))[1];
}

/** Runs the commands of a section in an empty folder, with our packages as packed. @returns {string} the folder */
function runCommands(heading, name) {
    const folder = join(studio.files, name);
    mkdirSync(folder, { recursive: true });
    const commands = blockOf(heading, 'bash').replaceAll(/@halflight\/(\w+)/g, (_, own) => packageOf(own));
    const env = { ...process.env, npm_config_yes: 'true' };
    execSync(`set -e\n${commands}`, { cwd: folder, shell: '/bin/bash', stdio: ['ignore', 'pipe', 'pipe'], timeout: 300000, env });
    return folder;
}

/** @returns {string} the folder of an app that the commands of a section make */
function create(heading, name) {
    assert.match(blockOf(heading, 'bash'), /^npm create vite@latest app -- --template \w+$/m);
    return join(runCommands(heading, name), 'app');
}

/** Fails where a page shows another picture of the courtyard than the program, or says something. */
async function checkPage(folder, path, label) {
    const { reference } = pictureOf('courtyard', SIZE, '--mode', 'shadowmask', '--exposure', '2');
    const trouble = await comparePage(folder, path, label, reference);
    assert.deepEqual(trouble.filter((sentence) => !/THREE.Clock|Clock: This module|A-Frame Version|super-three/.test(sentence)), []);
}

/** Builds, serves and compares. */
async function check(app, label) {
    studio.bake('courtyard', 'courtyard', '--lightmap-size', '256');
    copyFileSync(studio.pathOf('courtyard'), join(app, 'public/courtyard-baked.glb'));
    execSync('npm run build', { cwd: app, stdio: ['ignore', 'pipe', 'pipe'], timeout: 300000 });
    await checkPage(join(app, 'dist'), 'index.html', label);
}

test('an app by npm create vite: plain JavaScript', async (t) => {
    if (skipOffline(t)) return;
    const app = create('A page', 'plain');
    rmSync(join(app, 'src'), { recursive: true });
    writeFileSync(join(app, 'main.js'), blockOf('A page', 'js'));
    writeFileSync(join(app, 'index.html'), blockOf('A page', 'html').replace(/<script type="importmap">[\s\S]*?<\/script>\n/, ''));
    await check(app, 'npm create vite, plain');
});

test('an app by npm create vite: React', async (t) => {
    if (skipOffline(t)) return;
    const app = create('React', 'react-app');
    writeFileSync(join(app, 'src/App.jsx'), blockOf('React', 'jsx'));
    await check(app, 'npm create vite, React');
});

test('a page by the commands for A-Frame', async (t) => {
    if (skipOffline(t)) return;
    const folder = runCommands('A-Frame', 'aframe-page');
    studio.bake('courtyard', 'courtyard', '--lightmap-size', '256');
    copyFileSync(studio.pathOf('courtyard'), join(folder, 'courtyard-baked.glb'));
    writeFileSync(join(folder, 'index.html'), blockOf('A-Frame', 'html'));
    await checkPage(folder, 'index.html?ui=false', 'A-Frame, by its commands'); // no button for headsets in the picture
});

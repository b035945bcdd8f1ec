// Nightly: the plug-in where three.js is used: React, A-Frame, threlte, tres, and apps by the documented commands.
import { missing } from './harness.mjs';
import { missingExamples } from './frameworks/workspace.mjs';

const parts = (process.env.HALFLIGHT_WEB_PARTS ?? 'pages,aframe,react,types,create').split(',');
const reason = missing() ?? (parts.every((part) => part === 'create') ? null : missingExamples());
if (reason) {
    console.log(`[  SKIPPED ] web.frameworks: ${reason}`);
    process.exit(0);
}
for (const part of parts) await import(`./frameworks/${part}.mjs`);

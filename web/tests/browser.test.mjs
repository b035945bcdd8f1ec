// All tests that need a browser: Chromium, its pages, bakes and the program's pictures are shared within a process.
import { missing } from './harness.mjs';

const reason = missing();
if (reason) {
    console.log(`[  SKIPPED ] web.browser: ${reason}`);
    process.exit(0);
}
const parts = (process.env.HALFLIGHT_WEB_PARTS ?? 'law,conformance,conformance_webgpu,groups,groups_sky,groups_turn,groups_life,surfaces,places,bones,sentences,broken,life,units,eyes,files,grid,tone,pictures,documents,glass,reflections,sky,area,export,webgpu,viewer_opens,viewer,viewer_use').split(',');
for (const part of parts) await import(`./browser/${part}.mjs`);

// Nightly: the packages @halflight/cli and @halflight/bake, as scripts/build-wasm.sh made them, installed by npm.
import { missing } from './harness.mjs';
import { missingPackages } from './wasm/workspace.mjs';

const parts = (process.env.HALFLIGHT_WEB_PARTS ?? 'command,function,systems,speed,browser,page').split(',');
const reason = missingPackages() ?? (parts.some((part) => ['browser', 'page'].includes(part)) ? missing() : null);
if (reason) {
    console.log(`[  SKIPPED ] web.wasm: ${reason}`);
    process.exit(0);
}
for (const part of parts) await import(`./wasm/${part}.mjs`);

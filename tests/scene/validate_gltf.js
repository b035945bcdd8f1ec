// Runs the Khronos glTF validator (npm "gltf-validator") on files and prints a JSON object: per file its errors and the
// codes of its warnings. Exit code 1: a file has errors; 3: the module cannot be found.
//   node validate_gltf.js FILE…      (NODE_PATH or HALFLIGHT_NODE_MODULES: the folder that holds gltf-validator)
'use strict';
const fs = require('fs');
const path = require('path');

function load() {
    const folders = [process.env.HALFLIGHT_NODE_MODULES, ...(process.env.NODE_PATH || '').split(path.delimiter)];
    for (const folder of folders) {
        if (!folder) continue;
        try { return require(path.resolve(folder, 'gltf-validator')); } catch (e) { /* the next one */ }
    }
    try { return require('gltf-validator'); } catch (e) { return null; }
}

async function main() {
    const validator = load();
    if (!validator) {
        console.error('gltf-validator is not installed (set NODE_PATH or HALFLIGHT_NODE_MODULES)');
        process.exit(3);
    }
    const report = {};
    let failed = false;
    for (const file of process.argv.slice(2)) {
        const folder = path.dirname(file);
        const result = await validator.validateBytes(new Uint8Array(fs.readFileSync(file)), {
            uri: path.basename(file),
            maxIssues: 1000,
            externalResourceFunction: (uri) =>
                fs.promises.readFile(path.resolve(folder, decodeURIComponent(uri))).then((b) => new Uint8Array(b)),
        });
        const messages = result.issues.messages;
        const errors = messages.filter((m) => m.severity === 0).map((m) => `${m.code} ${m.pointer || ''}: ${m.message}`);
        const warnings = {};
        for (const m of messages) if (m.severity === 1) warnings[m.code] = (warnings[m.code] || 0) + 1;
        report[path.basename(file)] = { numErrors: result.issues.numErrors, errors, warnings };
        failed = failed || result.issues.numErrors > 0;
    }
    console.log(JSON.stringify(report, null, 1));
    process.exit(failed ? 1 : 0);
}
main().catch((e) => { console.error(String(e)); process.exit(2); });

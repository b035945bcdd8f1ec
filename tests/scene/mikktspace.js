// Tangents of triangle soups by MikkTSpace (npm "mikktspace"). Each argument is a file of floats: for each corner position
// (3), normal (3) and texture coordinate (2); beside it, with ".tangents" appended, come four floats for each corner, as
// the package gives them (before glTF's change of sign). Exit code 3: the module cannot be found.
'use strict';
const fs = require('fs');
const path = require('path');

function load() {
    const folders = [process.env.HALFLIGHT_NODE_MODULES, ...(process.env.NODE_PATH || '').split(path.delimiter)];
    for (const folder of folders) {
        if (!folder) continue;
        try { return require(path.resolve(folder, 'mikktspace')); } catch (e) { /* the next one */ }
    }
    try { return require('mikktspace'); } catch (e) { return null; }
}

const mikktspace = load();
if (!mikktspace) {
    console.error('mikktspace is not installed (set NODE_PATH or HALFLIGHT_NODE_MODULES)');
    process.exit(3);
}
for (const file of process.argv.slice(2)) {
    const bytes = fs.readFileSync(file);
    const numbers = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
    const count = numbers.length / 8;
    const positions = new Float32Array(3 * count);
    const normals = new Float32Array(3 * count);
    const uvs = new Float32Array(2 * count);
    for (let i = 0; i < count; ++i) {
        positions.set(numbers.subarray(8 * i, 8 * i + 3), 3 * i);
        normals.set(numbers.subarray(8 * i + 3, 8 * i + 6), 3 * i);
        uvs.set(numbers.subarray(8 * i + 6, 8 * i + 8), 2 * i);
    }
    const tangents = mikktspace.generateTangents(positions, normals, uvs);
    fs.writeFileSync(file + '.tangents', Buffer.from(tangents.buffer, tangents.byteOffset, tangents.byteLength));
}

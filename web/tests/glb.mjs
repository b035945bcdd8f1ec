// Binary glTF files: JSON and buffer apart and together.
import { readFileSync, writeFileSync } from 'node:fs';

export function readGlb(path) {
    const bytes = readFileSync(path);
    const length = bytes.readUInt32LE(12);
    return { json: JSON.parse(bytes.subarray(20, 20 + length)), buffer: bytes.subarray(28 + length) };
}

export function writeGlb(path, { json, buffer }) {
    const text = Buffer.from(JSON.stringify(json));
    const padded = Buffer.concat([text, Buffer.alloc((4 - (text.length % 4)) % 4, ' ')]);
    const head = (...numbers) => Buffer.from(Uint32Array.from(numbers).buffer);
    const size = 12 + 8 + padded.length + 8 + buffer.length;
    writeFileSync(path, Buffer.concat([head(0x46546c67, 2, size, padded.length, 0x4e4f534a), padded, head(buffer.length, 0x004e4942), buffer]));
}

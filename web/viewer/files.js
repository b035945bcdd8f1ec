// Where files come from, and how they become scenes. An error is a sentence for the user.
import { LoaderUtils, LoadingManager } from 'three';
import { HalflightPlugin } from '@halflight/three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

import { drawPlain } from './plain.js';

/**
 * @typedef {object} Source a file and what lies beside it
 * @property {string} name
 * @property {string} base of the addresses of files beside it
 * @property {(uri: string) => File | undefined} find a file beside it that has no address
 * @property {(progress?: (bytes: number) => void) => Promise<ArrayBuffer>} read
 * @property {(uri: string) => Promise<ArrayBuffer | null>} readBeside a file that it names, null where there is none
 */

const isInside = (uri) => /^(data|blob):/.test(uri);
const nameOf = (path) => path.split('/').pop();

function decoded(uri) {
    try {
        return decodeURIComponent(uri);
    } catch {
        return uri;
    }
}

/** @param {string} address @returns {Source} */
export function sourceOfAddress(address) {
    const url = URL.canParse(address, location.href) ? new URL(address, location.href) : null;
    const name = decoded(nameOf(url?.pathname ?? '') || address);
    const read = async (progress = () => {}) => {
        if (!url) throw new Error(`"${address}" is not an address`);
        const response = await fetch(url).catch(() => null);
        if (!response)
            throw new Error(
                `${name} cannot be read from ${url.host}: it is not reachable, or lets no other page read it (CORS)`
            );
        if (response.status === 404) throw new Error(`${name} was not found on ${url.host}`);
        if (!response.ok) throw new Error(`${name} cannot be read: ${url.host} answers with status ${response.status}`);
        return readAll(response, progress).catch(() => {
            throw new Error(`${name} cannot be read: the connection to ${url.host} broke off`);
        });
    };
    const base = LoaderUtils.extractUrlBase(url?.href ?? '');
    const readBeside = async (uri) => {
        const response = await fetch(new URL(uri, base)).catch(() => null);
        return response?.ok ? response.arrayBuffer() : null;
    };
    return { name, base, find: () => undefined, read, readBeside };
}

async function readAll(response, progress) {
    const parts = [];
    let size = 0;
    for (const reader = response.body.getReader(); ;) {
        const { done, value } = await reader.read();
        if (done) return new Blob(parts).arrayBuffer();
        parts.push(value);
        progress((size += value.length));
    }
}

/**
 * Files of a drop or a choice, with their paths in it: one is glTF, the others are its buffers and pictures.
 * @param {{path: string, file: File}[]} files @returns {Source | null}
 */
export function sourceOfFiles(files) {
    const depth = ({ path }) => path.split('/').length;
    const scenes = files.filter(({ path }) => /\.gl(b|tf)$/i.test(path)).sort((a, b) => depth(a) - depth(b));
    const main = scenes[0] ?? files[0];
    if (!main) return null;
    const byPath = new Map(files.map(({ path, file }) => [path, file]));
    const byName = new Map(files.map(({ file }) => [file.name, file]));
    const find = (uri) => {
        const steps = main.path.split('/').slice(0, -1);
        for (const step of decoded(uri).split('/')) {
            if (step === '..') steps.pop();
            else if (step !== '.') steps.push(step);
        }
        return byPath.get(steps.join('/')) ?? byName.get(nameOf(decoded(uri))); // chosen files have no folders
    };
    return {
        name: main.file.name,
        base: '',
        find,
        read: () => main.file.arrayBuffer(),
        readBeside: async (uri) => (await find(uri)?.arrayBuffer()) ?? null,
    };
}

/** All files of a drop, those in its folders too. @param {DataTransfer} transfer */
export async function droppedFiles(transfer) {
    const entries = [...transfer.items].map((item) => item.webkitGetAsEntry?.()); // at once: later the list is empty
    const plain = [...transfer.files];
    if (!entries.some((entry) => entry?.isDirectory)) return plain.map((file) => ({ path: file.name, file }));
    const files = [];
    const visit = async (entry) => {
        if (entry?.isFile) {
            const file = await new Promise((resolve, reject) => entry.file(resolve, reject));
            files.push({ path: entry.fullPath.slice(1), file });
        } else if (entry) {
            const reader = entry.createReader();
            const next = () => new Promise((resolve, reject) => reader.readEntries(resolve, reject));
            for (let some = await next(); some.length > 0; some = await next())
                for (const child of some) await visit(child);
        }
    };
    for (const entry of entries) await visit(entry);
    return files;
}

/** Files of an input. @param {FileList} list */
export function chosenFiles(list) {
    return [...list].map((file) => ({ path: file.webkitRelativePath || file.name, file }));
}

/** The document of a glTF file. @param {ArrayBuffer} bytes */
function documentOf(bytes) {
    const isBinary = new TextDecoder().decode(bytes.slice(0, 4)) === 'glTF';
    const text = isBinary ? bytes.slice(20, 20 + new DataView(bytes).getUint32(12, true)) : bytes;
    return JSON.parse(new TextDecoder().decode(text));
}

/** What a bake takes: the file, and the files that it names, by their paths. @param {Source} source */
export async function contentsOf(source) {
    const bytes = await source.read();
    const files = {};
    try {
        const { buffers = [], images = [], scenes = [] } = documentOf(bytes);
        const skies = scenes.map(({ extras }) => ({ uri: extras?.halflight_sky_image }));
        for (const { uri } of [...buffers, ...images, ...skies]) {
            const data = uri && !isInside(uri) ? await source.readBeside(uri) : null;
            if (data) files[decoded(uri)] = new Uint8Array(data);
        }
    } catch {
        // the baker says what is wrong
    }
    return { bytes: new Uint8Array(bytes), files };
}

function isGltf(bytes) {
    const head = new TextDecoder().decode(bytes.slice(0, 4));
    if (head === 'glTF') return true;
    try {
        return JSON.parse(new TextDecoder().decode(bytes)).asset !== undefined;
    } catch {
        return false;
    }
}

/** Why a file cannot be shown. @param {Error} error of the loader @param {string[]} missing @param {Source} source */
function reasonOf(error, missing, { name, base }, json) {
    if (missing.length > 0) return `${missing.join(', ')} is missing${base ? '' : `: drop it together with ${name}`}`;
    if (json.extensionsUsed?.includes('KHR_draco_mesh_compression'))
        return 'its meshes are compressed by Draco, which this page shows after a bake';
    return error.message;
}

/**
 * What a source holds; an error has `isPlain` where a bake may help.
 * @param {Source} source @param {(bytes: number) => void} progress
 */
export async function load(source, progress) {
    const { name, base, find } = source;
    const bytes = await source.read(progress);
    if (!isGltf(bytes)) throw new Error(`${name} is not a glTF file: .glb or .gltf`);
    const missing = new Set();
    const addresses = new Map();
    const manager = new LoadingManager();
    manager.onError = (url) => isInside(url) || missing.add(nameOf(decoded(url)));
    manager.setURLModifier((url) => {
        if (base || isInside(url)) return url;
        const file = find(url);
        if (!file) missing.add(nameOf(decoded(url)));
        else if (!addresses.has(file)) addresses.set(file, URL.createObjectURL(file));
        return addresses.get(file) ?? 'blob:missing'; // never from the page's own folder
    });
    const loader = new GLTFLoader(manager);
    loader.setMeshoptDecoder(MeshoptDecoder);
    let json = {};
    let isPlain = false;
    loader.register((parser) => {
        json = parser.json;
        isPlain = drawPlain(json);
        return new HalflightPlugin(parser);
    });
    try {
        const gltf = await loader.parseAsync(bytes, base);
        const { halflight } = gltf.userData;
        if (isPlain) {
            halflight.mode = 'realtime';
            Object.defineProperty(halflight, 'modes', { value: ['realtime'] });
        }
        return { gltf, halflight, name, isPlain, source, bytes: bytes.byteLength, missing: [...missing] };
    } catch (error) {
        const reason = reasonOf(error, [...missing], source, json);
        throw Object.assign(new Error(`${name} cannot be shown: ${reason}`), {
            isPlain: isPlain && missing.size === 0,
        });
    } finally {
        for (const address of addresses.values()) URL.revokeObjectURL(address);
    }
}

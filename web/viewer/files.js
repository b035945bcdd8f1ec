// Where files come from, and how they become scenes. An error is a sentence for the user.
import { LoaderUtils, LoadingManager } from 'three';
import { HalflightPlugin } from '@halflight/three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { MeshoptDecoder } from 'three/addons/libs/meshopt_decoder.module.js';

/**
 * @typedef {object} Source a file and what lies beside it
 * @property {string} name
 * @property {string} base of the addresses of files beside it
 * @property {Map<string, File>} beside by name, of files that have no address
 * @property {(progress: (bytes: number) => void) => Promise<ArrayBuffer>} read
 */

/** @param {string} address @returns {Source} */
export function sourceOfAddress(address) {
    const url = URL.canParse(address, location.href) ? new URL(address, location.href) : null;
    const name = decodeURIComponent(url?.pathname.split('/').pop() || address);
    const read = async (progress) => {
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
    return { name, base: LoaderUtils.extractUrlBase(url?.href ?? ''), beside: new Map(), read };
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
 * Files of a drop or a choice: one is glTF, the others are its buffers and pictures.
 * @param {File[]} files @returns {Source | null}
 */
export function sourceOfFiles(files) {
    const main = files.find(({ name }) => /\.gl(b|tf)$/i.test(name)) ?? files[0];
    if (!main) return null;
    return {
        name: main.name,
        base: '',
        beside: new Map(files.map((file) => [file.name, file])),
        read: () => main.arrayBuffer(),
    };
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

const isInside = (url) => /^(data|blob):/.test(url);

/** What a source holds. @param {Source} source @param {(bytes: number) => void} progress */
export async function load(source, progress) {
    const { name, base, beside } = source;
    const bytes = await source.read(progress);
    if (!isGltf(bytes)) throw new Error(`${name} is not a glTF file: .glb or .gltf`);
    const missing = new Set();
    const addresses = new Map();
    const manager = new LoadingManager();
    const nameOf = (url) => decodeURIComponent(url.split('/').pop());
    manager.onError = (url) => isInside(url) || missing.add(nameOf(url));
    manager.setURLModifier((url) => {
        if (base || isInside(url)) return url;
        const file = beside.get(nameOf(url));
        if (!file) missing.add(nameOf(url));
        else if (!addresses.has(file)) addresses.set(file, URL.createObjectURL(file));
        return addresses.get(file) ?? 'blob:missing'; // never from the page's own folder
    });
    const loader = new GLTFLoader(manager);
    loader.setMeshoptDecoder(MeshoptDecoder);
    loader.register((parser) => new HalflightPlugin(parser));
    try {
        const gltf = await loader.parseAsync(bytes, base);
        const halflight = gltf.userData.halflight;
        if (!halflight) throw new Error('it is not baked: "halflight bake" makes a baked file of it');
        return { gltf, halflight, name, bytes: bytes.byteLength, missing: [...missing] };
    } catch (error) {
        const lacks =
            missing.size > 0
                ? `${[...missing].join(', ')} is missing${base ? '' : `: drop it together with ${name}`}`
                : error.message;
        throw new Error(`${name} cannot be shown: ${lacks}`);
    } finally {
        for (const address of addresses.values()) URL.revokeObjectURL(address);
    }
}

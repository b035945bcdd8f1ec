// Pages of the bake as one array texture.
import { ClampToEdgeWrapping, DataArrayTexture, LinearFilter, NoColorSpace, RGBAFormat, RGBFormat, UnsignedByteType, UnsignedInt5999Type } from 'three';

export const FORMATS = { rgb9e5: { format: RGBFormat, type: UnsignedInt5999Type }, rgba8: { format: RGBAFormat, type: UnsignedByteType } };

const WHITE = { width: 1, height: 1, data: new Uint8Array(4).fill(255) };

/** @param {(import('../file/read.js').Pixels | null)[]} pages of one size, null for white ones @param {any} format one of FORMATS */
export function arrayTexture(pages, format) {
    const first = pages.find(Boolean) ?? WHITE;
    const { width, height } = first;
    const texels = first.data.length;
    const data = new first.data.constructor(texels * pages.length);
    pages.forEach((page, i) => (page ? data.set(page.data, i * texels) : data.fill(255, i * texels, (i + 1) * texels)));
    const texture = new DataArrayTexture(data, width, height, pages.length);
    Object.assign(texture, { ...format, minFilter: LinearFilter, magFilter: LinearFilter, colorSpace: NoColorSpace });
    texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
    texture.generateMipmaps = false;
    texture.needsUpdate = true;
    return texture;
}

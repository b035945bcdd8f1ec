// Pages of the bake as one array texture.
import { ClampToEdgeWrapping, DataArrayTexture, LinearFilter, NoColorSpace, RGBAFormat, RGBFormat, UnsignedByteType, UnsignedInt5999Type } from 'three';

export const FORMATS = { rgb9e5: { format: RGBFormat, type: UnsignedInt5999Type }, rgba8: { format: RGBAFormat, type: UnsignedByteType } };

/** @param {import('../file/read.js').Pixels[]} pages of one size @param {any} format one of FORMATS */
export function arrayTexture(pages, format) {
    const { width, height } = pages[0];
    const texels = pages[0].data.length;
    const data = new pages[0].data.constructor(texels * pages.length);
    pages.forEach((page, i) => data.set(page.data, i * texels));
    const texture = new DataArrayTexture(data, width, height, pages.length);
    Object.assign(texture, { ...format, minFilter: LinearFilter, magFilter: LinearFilter, colorSpace: NoColorSpace });
    texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
    texture.generateMipmaps = false;
    texture.needsUpdate = true;
    return texture;
}

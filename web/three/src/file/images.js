// The bake's pictures as texels. Their values are data: nothing may multiply by alpha or convert colours.
import { DataUtils } from 'three';
import { read as readKtx2 } from 'three/addons/libs/ktx-parse.module.js';
import { ZSTDDecoder } from 'three/addons/libs/zstddec.module.js';

const RGB9E5 = 123; // VK_FORMAT_E5B9G9R9_UFLOAT_PACK32
const HALF = 97; // VK_FORMAT_R16G16B16A16_SFLOAT
const ZSTANDARD = 2;

/** KTX2 of more texels is refused before it is decompressed. */
const MOST_TEXELS = 2 ** 28;

/** @param {Uint8Array} bytes */
export async function readRgb9e5(bytes) {
    const file = parse(bytes);
    if (!(file.pixelWidth > 0 && file.pixelHeight > 0 && file.pixelWidth * file.pixelHeight <= MOST_TEXELS)) throw new Error('the KTX2 image is not readable: its size is out of range');
    const isHalf = file.vkFormat === HALF;
    if (!isHalf && file.vkFormat !== RGB9E5) throw new Error(`its KTX2 format ${file.vkFormat} is neither RGB9E5 nor RGBA16F`);
    let texels = file.levels[0].levelData;
    const size = file.pixelWidth * file.pixelHeight * (isHalf ? 8 : 4);
    if (file.supercompressionScheme === ZSTANDARD) {
        const decoder = new ZSTDDecoder();
        await decoder.init();
        texels = decoder.decode(texels, size);
    } else if (file.supercompressionScheme !== 0) {
        throw new Error(`its KTX2 supercompression ${file.supercompressionScheme} is not Zstandard`);
    }
    if (texels.byteLength !== size) throw new Error(`the KTX2 image is not readable: it has ${texels.byteLength} bytes of texels instead of ${size}`);
    const buffer = texels.slice().buffer;
    const data = isHalf ? rgb9e5OfHalf(new Uint16Array(buffer)) : new Uint32Array(buffer);
    return { width: file.pixelWidth, height: file.pixelHeight, data };
}

function parse(bytes) {
    try {
        return readKtx2(bytes);
    } catch {
        throw new Error('the KTX2 image is not readable: it is too short, or damaged');
    }
}

function rgb9e5OfHalf(half) {
    const value = (i) => DataUtils.fromHalfFloat(half[i]);
    return Uint32Array.from({ length: half.length / 4 }, (_, i) => packRgb9e5(value(4 * i), value(4 * i + 1), value(4 * i + 2)));
}

/** @param {Uint8Array} bytes @param {string} mimeType */
export async function decodeImage(bytes, mimeType) {
    let bitmap;
    try {
        bitmap = await createImageBitmap(new Blob([bytes], { type: mimeType }), {
            premultiplyAlpha: 'none',
            colorSpaceConversion: 'none',
        });
    } catch (error) {
        throw new Error(`the browser cannot decode this ${mimeType}: ${error}`);
    }
    const pixels = pixelsOf(bitmap);
    bitmap.close();
    return pixels;
}

/**
 * A lightmap of 8 bits a channel as RGB9E5: filters need linear light.
 * @param {Uint8Array} bytes @param {string} mimeType @param {{scale: number, exponent: number}} curve
 */
export async function readByCurve(bytes, mimeType, curve) {
    const { width, height, data } = await decodeImage(bytes, mimeType);
    const values = Float32Array.from({ length: 256 }, (_, c) => curve.scale * (c / 255) ** curve.exponent);
    const texels = new Uint32Array(width * height);
    for (let i = 0; i < texels.length; ++i)
        texels[i] = packRgb9e5(values[data[4 * i]], values[data[4 * i + 1]], values[data[4 * i + 2]]);
    return { width, height, data: texels };
}

/** Channel 0, 1 or 2 of a texel. */
export function unpackRgb9e5(texel, channel) {
    return ((texel >>> (9 * channel)) & 511) * 2 ** ((texel >>> 27) - 24);
}

export function packRgb9e5(r, g, b) {
    const brightest = Math.max(r, g, b);
    if (!(brightest > 0)) return 0;
    let exponent = Math.max(-16, Math.floor(Math.log2(brightest))) + 1;
    if (Math.round(brightest / 2 ** (exponent - 9)) > 511) ++exponent;
    const mantissa = (x) => Math.min(511, Math.round(x / 2 ** (exponent - 9)));
    return (mantissa(r) | (mantissa(g) << 9) | (mantissa(b) << 18) | ((exponent + 15) << 27)) >>> 0;
}

let context = null;

function contextOf() {
    context ??= new OffscreenCanvas(1, 1).getContext('webgl2');
    if (!context) throw new Error('the bake\'s pictures cannot be read: the browser has no WebGL 2');
    return context;
}

/** Whether the browser draws into half floats. */
export function hasFloatTargets() {
    const gl = contextOf();
    return ['EXT_color_buffer_float', 'EXT_color_buffer_half_float'].some((name) => gl.getExtension(name) !== null);
}

/** A 2D canvas would multiply by alpha, so WebGL reads the texels back. @param {ImageBitmap} bitmap */
function pixelsOf(bitmap) {
    const gl = contextOf();
    const { width, height } = bitmap;
    const texture = gl.createTexture();
    const framebuffer = gl.createFramebuffer();
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.pixelStorei(gl.UNPACK_PREMULTIPLY_ALPHA_WEBGL, false);
    gl.pixelStorei(gl.UNPACK_COLORSPACE_CONVERSION_WEBGL, gl.NONE);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA8, gl.RGBA, gl.UNSIGNED_BYTE, bitmap);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, texture, 0);
    const data = new Uint8Array(width * height * 4);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    gl.deleteFramebuffer(framebuffer);
    gl.deleteTexture(texture);
    return { width, height, data };
}

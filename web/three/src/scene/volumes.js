// Proxy volumes: probe light resampled on a regular grid about an object. As ProxyVolume in
// include/halflight/render/probes.h; all volumes share one 3D texture, whose depth holds eight slabs,
// and one more for each mask layer beyond the first.
import { Box3, ClampToEdgeWrapping, Data3DTexture, DataUtils, Frustum, HalfFloatType, LinearFilter, Matrix4, RGBAFormat, Vector3 } from 'three';

import { LIGHT_OF_SLABS, SLABS_OF_LIGHT, TEXELS_A_FRAME, VolumeLight } from './volume_light.js';

/** @param {number} channels of all mask layers */
export const slabsOf = (channels) => 7 + channels / 4;
const MAX_RESOLUTION = 64;
const MAX_AUTOMATIC_TEXELS = 2 ** 18;
const MAX_TEXELS = 2 ** 21;
const LAYER = 256;
const THINNEST = 1e-3;

const texelsOf = (resolution) => resolution[0] * resolution[1] * resolution[2];

/** The matrix that takes [0, 1]^3 to a box of an object's space, in bake space. @param {Box3} box @param {Matrix4} bakeFromObject */
function bakeFromUnitBox(box, bakeFromObject) {
    const center = box.getCenter(new Vector3());
    const size = box.getSize(new Vector3());
    const largest = Math.max(size.x, size.y, size.z);
    const thin = largest > 0 ? THINNEST * largest : THINNEST;
    size.set(Math.max(size.x, thin), Math.max(size.y, thin), Math.max(size.z, thin));
    const world = unitBox(bakeFromObject, center, size);
    const columns = [0, 1, 2].map((axis) => new Vector3().setFromMatrixColumn(world, axis));
    const longest = Math.max(...columns.map((c) => c.length()));
    if (Math.abs(world.determinant()) > 1e-12 * longest ** 3) return world;
    // The transform flattens the object: the box in the world about what is left.
    const flattened = new Vector3();
    for (const c of columns) flattened.add(new Vector3(Math.abs(c.x), Math.abs(c.y), Math.abs(c.z)));
    flattened.max(new Vector3().setScalar(THINNEST * Math.max(flattened.x, flattened.y, flattened.z) || THINNEST));
    return unitBox(new Matrix4(), new Vector3(0.5, 0.5, 0.5).applyMatrix4(world), flattened);
}

function unitBox(matrix, center, size) {
    const low = center.clone().addScaledVector(size, -0.5);
    return matrix.clone().multiply(new Matrix4().makeTranslation(low.x, low.y, low.z)).scale(size);
}

/** @param {Matrix4} world @param {number[]} wish 0 = by the distance of probes @param {number[]} spacing */
function resolutionOf(world, wish, spacing) {
    return [0, 1, 2].map((axis) => {
        if (wish[axis] > 0) return Math.min(wish[axis], MAX_RESOLUTION);
        const side = new Vector3().setFromMatrixColumn(world, axis);
        const crossed = Math.abs(side.x) / spacing[0] + Math.abs(side.y) / spacing[1] + Math.abs(side.z) / spacing[2];
        return Math.min(Math.max(Math.ceil(crossed - 1e-4) + 1, 2), 32);
    });
}

/**
 * Which objects have a volume, and how finely each is sampled.
 * @param {import('./objects.js').BakedObject[]} objects @param {import('../probes/field.js').ProbeField} field
 */
export function planVolumes(objects, field) {
    if (field.empty) return [];
    const asked = [];
    const automatic = [];
    for (const object of objects) {
        if (object.lightmapped || object.box.isEmpty()) continue;
        if (object.probes === 'volume') {
            const group = object.instances > 1;
            const box = group ? object.bakeBox() : object.box;
            const world = group ? new Matrix4() : object.bakeFromObject(0);
            asked.push({ object, instance: group ? -1 : 0, resolution: resolutionOf(bakeFromUnitBox(box, world), object.probeResolution, field.spacing) });
        } else if (object.probes === 'automatic' && object.isStatic) {
            for (let i = 0; i < object.instances; ++i) {
                const world = bakeFromUnitBox(object.box, object.bakeFromObject(i));
                if (Math.max(...resolutionOf(world, [0, 0, 0], field.spacing)) <= 2) continue; // shorter than probes are apart
                automatic.push({ object, instance: i, resolution: resolutionOf(world, object.probeResolution, field.spacing) });
            }
        }
    }
    for (let most = MAX_RESOLUTION; most > 1; most /= 2) {
        for (const v of asked) v.resolution = v.resolution.map((n) => Math.min(n, most));
        if (asked.reduce((sum, v) => sum + texelsOf(v.resolution), 0) <= MAX_TEXELS) break;
    }
    automatic.sort((a, b) => texelsOf(b.resolution) - texelsOf(a.resolution));
    let texels = 0;
    for (const v of automatic) {
        if (texels + texelsOf(v.resolution) > MAX_AUTOMATIC_TEXELS) continue;
        texels += texelsOf(v.resolution);
        asked.push(v);
    }
    return asked;
}

export class ProxyVolumes {
    /** @param {ReturnType<typeof planVolumes>} plan @param {import('./table.js').ObjectTable} table */
    constructor(plan, field, table) {
        this.field = field;
        this.table = table;
        this.volumes = plan.map((v) => ({ ...v, offset: [0, 0, 0], row: table.allocate(1) }));
        this.slabs = slabsOf(field.channels);
        this.size = this.pack();
        const [x, y, z] = this.size;
        const texture = new Data3DTexture(new Uint16Array(4 * x * y * z * this.slabs), x, y, z * this.slabs);
        texture.format = RGBAFormat;
        texture.type = HalfFloatType;
        texture.minFilter = texture.magFilter = LinearFilter;
        texture.wrapS = texture.wrapT = texture.wrapR = ClampToEdgeWrapping;
        texture.unpackAlignment = 1;
        this.texture = texture;
        for (const v of this.volumes) this.fill(v);
    }

    /** Boxes in rows (x), rows in layers (y), layers along z. */
    pack() {
        const order = [...this.volumes].sort((a, b) => b.resolution[2] - a.resolution[2] || b.resolution[1] - a.resolution[1]);
        let at = [0, 0, 0];
        let thickness = [0, 0];
        const size = [1, 1, 1];
        for (const v of order) {
            const box = v.resolution;
            if (at[0] + box[0] > LAYER) [at, thickness] = [[0, at[1] + thickness[0], at[2]], [0, thickness[1]]];
            if (at[1] + box[1] > LAYER) [at, thickness] = [[0, 0, at[2] + thickness[1]], [0, 0]];
            v.offset = [...at];
            for (let axis = 0; axis < 3; ++axis) size[axis] = Math.max(size[axis], at[axis] + box[axis]);
            thickness = [Math.max(thickness[0], box[1]), Math.max(thickness[1], box[2])];
            at[0] += box[0];
        }
        return size;
    }

    /** Samples the probes where the volume's object is now. */
    fill(v) {
        const group = v.instance < 0;
        const box = group ? v.object.bakeBox() : v.object.box;
        const world = bakeFromUnitBox(box, group ? new Matrix4() : v.object.bakeFromObject(v.instance));
        const n = v.resolution;
        const { field } = this;
        const samples = [];
        const place = new Vector3();
        if (field.groups.length > 0) v.light ??= new VolumeLight(texelsOf(n));
        for (let z = 0; z < n[2]; ++z)
            for (let y = 0; y < n[1]; ++y)
                for (let x = 0; x < n[0]; ++x) {
                    const at = [x, y, z].map((i, axis) => (n[axis] < 2 ? 0.5 : i / (n[axis] - 1)));
                    samples.push(field.sample(place.fromArray(at).applyMatrix4(world).toArray()));
                    v.light?.keep(samples.length - 1, field.place);
                }
        Object.assign(v, { world, version: field.version });
        if (v.light) v.light.isRunning = false;
        const largest = samples.reduce((m, s) => s.radiance.reduce((k, x) => Math.max(k, Math.abs(x)), m), 0);
        const factor = largest > 0 ? 2 ** (Math.ceil(Math.log2(largest)) - 15) : 1;
        samples.forEach((sample, i) => this.store(v, i, sample, factor));
        this.texture.needsUpdate = true;
        this.writeRow(v, world, factor);
    }

    store(v, i, sample, factor) {
        const attenuation = [...sample.occlusion].map((o) => o * factor);
        const slabs = new Map(SLABS_OF_LIGHT.map((slab, k) => [slab, LIGHT_OF_SLABS.slice(4 * k, 4 * k + 4).map((n) => sample.radiance[n] ?? 0)]));
        slabs.set(3, attenuation.slice(0, 4));
        for (let c = 4; c < attenuation.length; c += 4) slabs.set(7 + c / 4, attenuation.slice(c, c + 4));
        for (const [slab, texel] of slabs) {
            const at = this.at(v, i, slab);
            for (let k = 0; k < 4; ++k) this.texture.image.data[at + k] = DataUtils.toHalfFloat(texel[k] / factor);
        }
    }

    /** Where texel i of a volume begins in a slab. */
    at(v, i, slab) {
        const [nx, ny] = v.resolution;
        const [x, y, z] = [v.offset[0] + (i % nx), v.offset[1] + (Math.floor(i / nx) % ny), v.offset[2] + Math.floor(i / (nx * ny))];
        return 4 * (((z + slab * this.size[2]) * this.size[1] + y) * this.size[0] + x);
    }

    /**
     * Gives volumes the light of weights that changed since: some texels, those of volumes in view first.
     * @param {any} camera @returns {boolean} whether all volumes have them
     */
    relight(camera) {
        const { field } = this;
        const stale = this.volumes.filter((v) => v.light && (v.version !== field.version || v.light.isRunning));
        if (stale.length === 0) return true;
        const frustum = new Frustum().setFromProjectionMatrix(new Matrix4().multiplyMatrices(camera.projectionMatrix, camera.matrixWorldInverse));
        const isInView = ({ object }) => frustum.intersectsBox(object.bakeBox().applyMatrix4(object.instance.worldFromBake));
        const seen = new Map(stale.map((v) => [v, Number(isInView(v))]));
        stale.sort((a, b) => Number(b.light.isRunning) - Number(a.light.isRunning) || seen.get(b) - seen.get(a) || a.version - b.version);
        let left = TEXELS_A_FRAME;
        for (const v of stale) {
            if (!v.light.isRunning) {
                v.light.begin(field);
                v.version = field.version;
            }
            left -= v.light.go(field, left);
            if (!v.light.isRunning) this.commit(v);
            if (left <= 0) break;
        }
        return stale.every((v) => v.version === field.version && !v.light.isRunning);
    }

    commit(v) {
        const { halves, factor, texels } = v.light;
        const [row] = v.resolution;
        for (const [k, slab] of SLABS_OF_LIGHT.entries())
            for (let i = 0; i < texels; i += row) this.texture.image.data.set(halves.subarray(4 * (k * texels + i), 4 * (k * texels + i + row)), this.at(v, i, slab));
        this.texture.needsUpdate = true;
        this.writeRow(v, v.world, factor);
    }

    writeRow(v, world, factor) {
        const n = v.resolution;
        const textureSize = [this.size[0], this.size[1], this.size[2] * this.slabs];
        // Box coordinate 0 is at the first texel's centre, 1 at the last one's; a single texel stands for all.
        const scale = n.map((count, axis) => (count < 2 ? 1 : count - 1) / textureSize[axis]);
        const shift = n.map((count, axis) => (v.offset[axis] + (count < 2 ? 0 : 0.5)) / textureSize[axis]);
        const matrix = new Matrix4().makeTranslation(shift[0], shift[1], shift[2]).scale(new Vector3().fromArray(scale)).multiply(world.clone().invert());
        for (let column = 0; column < 4; ++column) this.table.set(v.row, column, matrix.elements.slice(4 * column, 4 * column + 4));
        this.table.set(v.row, 4, [...n.map((_, axis) => (v.offset[axis] + 0.5) / textureSize[axis]), factor]);
        this.table.set(v.row, 5, [...n.map((count, axis) => (v.offset[axis] + count - 0.5) / textureSize[axis]), 0]);
    }

    dispose() {
        this.texture.dispose();
    }
}

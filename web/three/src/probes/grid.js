// The bake's probes as three.js's own LightProbeGrid: resampled, so that it needs neither validity nor tetrahedra.
import { Box3, ClampToEdgeWrapping, Data3DTexture, DataUtils, HalfFloatType, LinearFilter, RGBAFormat, Vector3 } from 'three';

const PADDING = 1; // slices of the texture before and after each of its parts
const PARTS = 7; // 27 floats in texels of four
const MOST = 64; // probes along an axis
const LARGEST_HALF = 65504;

/** Whether a class puts probes at the centres of cells, as from three.js 0.187 on, or at their corners. */
function probesAtCentres(Grid) {
    const grid = new Grid(1, 1, 1, 2, 1, 1);
    const first = grid.getProbePosition(0, 0, 0, new Vector3()).x;
    grid.dispose?.();
    return first > -0.4;
}

/**
 * @param {import('./field.js').ProbeField} field @param {any} Grid LightProbeGrid or LightProbeGridWebGL of three.js's addons
 * @param {Box3} box @param {number[] | undefined} resolution probes along each axis
 * @returns {{grid: any, clipped: boolean}}
 */
export function makeLightProbeGrid(field, Grid, box, resolution) {
    const size = box.getSize(new Vector3()).toArray();
    const count = size.map((s, axis) => {
        const wish = resolution?.[axis] ?? (Number.isFinite(field.spacing[axis]) ? Math.ceil(s / field.spacing[axis] - 1e-4) + 1 : 1);
        return Math.min(Math.max(Math.round(wish), 1), MOST);
    });
    const centres = probesAtCentres(Grid);
    const extent = size.map((s, axis) => Math.max(centres && count[axis] > 1 ? (s * count[axis]) / (count[axis] - 1) : s, 1e-3));
    const grid = new Grid(...extent, ...count);
    box.getCenter(grid.position);
    grid.updateBoundingBox();
    grid.updateMatrixWorld();
    grid.texture?.dispose();
    const { texture, clipped } = textureOf(field, grid, count);
    grid.texture = texture;
    return { grid, clipped };
}

function textureOf(field, grid, [nx, ny, nz]) {
    const slices = nz + 2 * PADDING;
    const data = new Uint16Array(4 * nx * ny * PARTS * slices);
    const place = new Vector3();
    let clipped = false;
    for (let z = 0; z < nz; ++z)
        for (let y = 0; y < ny; ++y)
            for (let x = 0; x < nx; ++x) {
                const { radiance } = field.sample(grid.getProbePosition(x, y, z, place).toArray());
                const halves = Array.from({ length: 4 * PARTS }, (_, i) => {
                    const value = radiance[i] ?? 0;
                    if (Math.abs(value) > LARGEST_HALF) clipped = true;
                    return DataUtils.toHalfFloat(Math.min(Math.max(value, -LARGEST_HALF), LARGEST_HALF));
                });
                const rows = [z + PADDING, ...(z === 0 ? [0] : []), ...(z === nz - 1 ? [slices - 1] : [])];
                for (let part = 0; part < PARTS; ++part)
                    for (const row of rows) data.set(halves.slice(4 * part, 4 * part + 4), 4 * (((part * slices + row) * ny + y) * nx + x));
            }
    const texture = new Data3DTexture(data, nx, ny, PARTS * slices);
    Object.assign(texture, { format: RGBAFormat, type: HalfFloatType, minFilter: LinearFilter, magFilter: LinearFilter, unpackAlignment: 1 });
    texture.wrapS = texture.wrapT = texture.wrapR = ClampToEdgeWrapping;
    texture.needsUpdate = true;
    return { texture, clipped };
}

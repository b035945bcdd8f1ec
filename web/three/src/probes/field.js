// Light and occlusion at a point, interpolated between the bake's probes: linear in each Delaunay tetrahedron (Cupisz
// 2012); outside their convex hull the value at the hull's nearest point. As ProbeInterpolator in
// include/halflight/render/probes.h. A file without cells, as older bakes wrote for probes in a plane, gives the nearest
// probe's.
import { shBasis, shIrradianceWeight } from '../generated/shading.js';
import { composedSky } from '../groups/sky.js';
import { skyCoefficients } from '../scene/sky_picture.js';
import { cellsFit } from './cells.js';
import { removeRinging } from './ringing.js';
import { CellSearch, NearestProbe, Place } from './search.js';
import { sightWeight } from './sight.js';

const FLAT = 1e-5;

/** @typedef {{radiance: Float64Array, occlusion: Float64Array}} ProbeSample nine RGB coefficients, all channels */

/** The open sky as a probe meets it; nothing occluded. @returns {ProbeSample} */
export function skyProbe(sky, channels = 4) {
    const occlusion = new Float64Array(channels).fill(1);
    if (sky.picture) return { radiance: skyCoefficients(sky.picture), occlusion };
    const up = { x: 0, y: 1, z: 0 };
    const down = { x: 0, y: -1, z: 0 };
    const radiance = new Float64Array(27);
    for (let c = 0; c < 3; ++c) {
        radiance[c] = sky.horizon[c] * 4 * Math.PI * shBasis(0, up);
        for (let i = 0; i < 9; ++i) {
            radiance[3 * i + c] += (sky.zenith[c] - sky.horizon[c]) * shIrradianceWeight(i, up);
            radiance[3 * i + c] += (sky.ground[c] - sky.horizon[c]) * shIrradianceWeight(i, down);
        }
    }
    return { radiance, occlusion };
}

export class ProbeField {
    /**
     * @param {import('../file/read.js').ProbeData | null} probes @param {any} sky @param {number} [channels] of all mask layers
     * @param {import('../file/groups.js').GroupData[]} [groups] whose light `probes` lack
     */
    constructor(probes, sky, channels = 4, groups = []) {
        this.channels = channels;
        this.savedSky = sky;
        this.savedProbe = skyProbe(sky, channels);
        /** The open sky at the weights: its colours, a picture's factor, and light as a probe meets it. */
        this.sky = null;
        this.probes = probes;
        this.spacing = [Infinity, Infinity, Infinity];
        /** @type {number[]} valid probes */
        this.sources = [];
        this.place = new Place();
        /** @type {CellSearch | NearestProbe | null} */
        this.search = null;
        /** Whether the file has cells that fit its probes. */
        this.cellsOfFile = false;
        this.groups = groups;
        /** Light of the probes: of those that were needed since the weights changed, by `stamps`. */
        this.radiance = probes?.radiance;
        this.stamps = null;
        this.version = 0;
        if (groups.length > 0 && probes) {
            this.radiance = probes.radiance.slice();
            this.stamps = new Uint32Array(probes.count);
        }
        this.setWeights(groups.map(({ weight }) => weight));
        if (!probes) return;
        for (let i = 0; i < probes.count; ++i) if (probes.valid[i]) this.sources.push(i);
        if (this.sources.length > 0) this.build();
    }

    /** @returns {ProbeSample} to be written to */
    newSample() {
        return { radiance: new Float64Array(27), occlusion: new Float64Array(this.channels) };
    }

    /** @param {number[][]} weights of the groups */
    setWeights(weights) {
        const { gradient, factor } = composedSky(this.savedSky, this.groups, weights);
        const radiance = this.savedSky.picture ? this.savedProbe.radiance.map((x, i) => x * factor[i % 3]) : skyProbe(gradient).radiance;
        this.sky = { gradient, factor, radiance };
        this.version += 1;
        /** The groups that give light. */
        this.shining = this.groups.flatMap(({ radiance }, g) => (Math.max(...weights[g]) > 0 ? [{ radiance, weight: weights[g] }] : []));
    }

    /** At least the largest coefficient of any probe at the weights. */
    bound() {
        const largest = (list) => list.reduce((most, x) => Math.max(most, Math.abs(x)), 0);
        this.peaks ??= new Map([this.probes, ...this.groups].map((source) => [source.radiance, largest(source.radiance)]));
        return this.shining.reduce((sum, { radiance, weight }) => sum + Math.max(...weight) * this.peaks.get(radiance), this.peaks.get(this.probes.radiance));
    }

    /** Adds the light of a probe up at the weights, where that was not done yet. */
    compose(probe) {
        if (this.stamps === null || this.stamps[probe] === this.version) return;
        this.stamps[probe] = this.version;
        for (let i = 27 * probe; i < 27 * probe + 27; ++i) {
            let sum = this.probes.radiance[i];
            for (const { radiance, weight } of this.shining) sum += weight[i % 3] * radiance[i];
            this.radiance[i] = sum;
        }
    }

    get empty() {
        return this.sources.length === 0;
    }

    build() {
        const size = this.extent();
        const largest = Math.max(...size);
        this.spacing = this.meanSpacing(size, size.map((s) => !(s > (this.probes.grid ? 0 : FLAT * largest))));
        const { cells, positions } = this.probes;
        this.cellsOfFile = cells !== null && cellsFit(cells, positions);
        this.search = this.cellsOfFile ? new CellSearch(cells, positions) : new NearestProbe(this.sources, positions);
    }

    /** Extent of the valid probes along each axis. */
    extent() {
        const low = [Infinity, Infinity, Infinity];
        const high = [-Infinity, -Infinity, -Infinity];
        for (const source of this.sources) {
            for (let axis = 0; axis < 3; ++axis) {
                const x = this.probes.positions[3 * source + axis];
                low[axis] = Math.min(low[axis], x);
                high[axis] = Math.max(high[axis], x);
            }
        }
        return high.map((x, axis) => x - low[axis]);
    }

    meanSpacing(size, flat) {
        const grid = this.probes.grid;
        if (grid) return grid.spacing.map((s, axis) => (grid.size[axis] > 1 ? s : Infinity));
        const extended = size.filter((_, axis) => !flat[axis]);
        if (extended.length === 0) return [Infinity, Infinity, Infinity];
        const perAxis = Math.max(this.sources.length ** (1 / extended.length) - 1, 1);
        const spacing = extended.reduce((a, b) => a * b, 1) ** (1 / extended.length) / perAxis;
        return flat.map((f) => (f ? Infinity : spacing));
    }

    /** Shares of a place's probes, each times how well its probe sees the point that the shares are those of. @returns {number} their sum */
    see({ probes, weights, count }) {
        const { positions, sight } = this.probes;
        let sum = 0;
        for (let k = 0; k < count; ++k) sum += weights[k];
        if (!sight || count === 1) return sum;
        let x = 0, y = 0, z = 0;
        for (let k = 0; k < count; ++k) {
            const at = 3 * probes[k];
            x += (weights[k] / sum) * positions[at];
            y += (weights[k] / sum) * positions[at + 1];
            z += (weights[k] / sum) * positions[at + 2];
        }
        let seen = 0;
        for (let k = 0; k < count; ++k) {
            const at = 3 * probes[k];
            if (weights[k] > 0) weights[k] *= sightWeight(sight, probes[k], x - positions[at], y - positions[at + 1], z - positions[at + 2]);
            seen += weights[k];
        }
        return seen;
    }

    /**
     * @param {ArrayLike<number>} p in bake space @param {Place} [place] where the search begins, and ends
     * @param {ProbeSample} [sum] to write to @returns {ProbeSample}
     */
    sample(p, place = this.place, sum = this.newSample()) {
        if (this.empty) {
            sum.radiance.set(this.sky.radiance);
            sum.occlusion.set(this.savedProbe.occlusion);
            removeRinging(sum.radiance);
            return sum;
        }
        this.search.find(p, place);
        const total = this.see(place);
        for (let k = 0; k < place.count; ++k) place.weights[k] /= total;
        return this.mix(place.probes, place.weights, 0, place.count, sum);
    }

    /** Light of probes by their shares, from `first` on. @param {ArrayLike<number>} probes @param {ArrayLike<number>} weights @param {ProbeSample} sum to write to */
    mix(probes, weights, first, count, sum) {
        const { channels } = this;
        const { occlusion } = this.probes;
        sum.radiance.fill(0);
        sum.occlusion.fill(0);
        for (let k = first; k < first + count; ++k) {
            const w = weights[k];
            const probe = probes[k];
            this.compose(probe);
            for (let i = 0; i < 27; ++i) sum.radiance[i] += w * this.radiance[27 * probe + i];
            for (let c = 0; c < channels; ++c) sum.occlusion[c] += w * occlusion[channels * probe + c];
        }
        removeRinging(sum.radiance); // after interpolation: the sum may ring less than each probe
        return sum;
    }
}

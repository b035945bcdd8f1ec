// Lights that turn: weights of the groups of their directions, as include/halflight/scene/turning_lights.h has them.
import { Matrix4, Vector3 } from 'three';

/** As in src/scene/model/turning_lights.cpp, which says what they are. */
const COST = 0.02;
const LEAST_WEIGHT = 1e-6;
const SINGULAR = 1e-9;

/** From here on the weights say that a light was turned, radians. */
const TURNED = 1e-5;

const costOf = (direction, target) => COST * direction.reduce((sum, x, c) => sum + (x - target[c]) ** 2, 0);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const determinant = ([a, b, c]) => a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);

/** The minimum over the weights of some directions, of either sign; null where they are not independent. */
function stationary(directions, chosen, target) {
    const gram = [0, 1, 2].map((i) => [0, 1, 2].map((j) => (i < chosen.length && j < chosen.length ? dot(directions[chosen[i]], directions[chosen[j]]) : Number(i === j))));
    const right = [0, 1, 2].map((i) => (i < chosen.length ? dot(directions[chosen[i]], target) - costOf(directions[chosen[i]], target) : 0));
    const whole = determinant(gram);
    if (Math.abs(whole) < SINGULAR) return null;
    return chosen.map((_, i) => determinant(gram.map((row, r) => row.map((x, c) => (c === i ? right[r] : x)))) / whole);
}

function objective(directions, chosen, weights, target) {
    const off = [0, 1, 2].map((c) => chosen.reduce((sum, d, i) => sum + weights[i] * directions[d][c], -target[c]));
    return 0.5 * dot(off, off) + chosen.reduce((sum, d, i) => sum + costOf(directions[d], target) * weights[i], 0);
}

/** Sets of one to three of `count` numbers, ascending. */
function* choices(count, chosen = []) {
    for (let i = chosen.length > 0 ? chosen[chosen.length - 1] + 1 : 0; i < count; ++i) {
        const next = [...chosen, i];
        yield next;
        if (next.length < 3) yield* choices(count, next);
    }
}

/**
 * @param {number[][]} directions unit vectors, of the bake @param {number[]} target the light's, of length 1
 * @returns {number[]} by direction
 */
export function weightsOfDirections(directions, target) {
    let best = { value: Infinity, chosen: [], weights: [] };
    for (const chosen of choices(directions.length)) {
        const weights = stationary(directions, chosen, target);
        if (!weights || weights.some((w) => w < 0)) continue;
        const value = objective(directions, chosen, weights, target);
        if (value < best.value) best = { value, chosen, weights };
    }
    const all = directions.map(() => 0);
    best.chosen.forEach((d, i) => (all[d] = best.weights[i]));
    const nearest = directions.reduce((least, d, i) => (dot(d, target) > dot(directions[least], target) ? i : least), 0);
    all[nearest] = Math.max(all[nearest], LEAST_WEIGHT);
    return all;
}

const from = new Vector3();
const to = new Vector3();

/** Along which a light of three.js shines, in the space of its file's bake. @param {any} light @param {Matrix4} bakeFromWorld */
function directionOf(light, bakeFromWorld) {
    for (const object of [light, light.target]) object.updateWorldMatrix(true, false);
    to.setFromMatrixPosition(light.target.matrixWorld).applyMatrix4(bakeFromWorld);
    from.setFromMatrixPosition(light.matrixWorld).applyMatrix4(bakeFromWorld);
    return to.sub(from).normalize().toArray();
}

/** The shares that the directions of one light have in its weight. */
export class Turning {
    /** @param {import('../scene/lights.js').BakedLight} light @param {{weight: number[]}[]} groups of the file */
    constructor(light, groups) {
        const { group, directions } = light.data.turns;
        this.light = light;
        this.first = group;
        this.directions = directions;
        const m = light.data.worldFromLight;
        this.direction = new Vector3(-m[8], -m[9], -m[10]).normalize().toArray();
        this.shares = weightsOfDirections(directions, this.direction);
        const sum = this.shares.reduce((all, share) => all + share, 0);
        const own = groups.slice(group, group + directions.length);
        /** Its colour times intensity over its white light, as the file saves it. */
        this.weight = [0, 1, 2].map((c) => own.reduce((all, { weight }) => all + weight[c], 0) / sum);
        this.name = own[0].name.replace(/\.1$/, '');
    }

    /** Takes the light's direction. @returns {boolean} whether it was turned since */
    turn() {
        const { light, instance } = this.light;
        const now = directionOf(light, instance.bakeFromWorld);
        if (now.some(Number.isNaN) || Math.hypot(...now.map((x, c) => x - this.direction[c])) < TURNED) return false;
        this.direction = now;
        this.shares = weightsOfDirections(this.directions, now);
        return true;
    }

    /** Degrees to the nearest direction of the bake. */
    away() {
        const most = Math.max(...this.directions.map((d) => dot(d, this.direction)));
        return (Math.acos(Math.min(most, 1)) * 180) / Math.PI;
    }
}

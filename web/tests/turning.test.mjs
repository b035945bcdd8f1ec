// S34. Weights of the directions of a light that turns, as the plug-in has them: closed forms, and what holds for any direction.
import assert from 'node:assert/strict';
import test from 'node:test';

import { weightsOfDirections } from '../three/src/groups/turning.js';

const radians = (degrees) => (degrees * Math.PI) / 180;

/** The sun at an hour angle of a day, along which it shines. */
function sunlight(hour, declination = 10, latitude = 50) {
    const [h, d, l] = [hour, declination, latitude].map(radians);
    return [
        Math.cos(d) * Math.sin(h),
        -Math.sin(l) * Math.sin(d) - Math.cos(l) * Math.cos(d) * Math.cos(h),
        -Math.sin(l) * Math.cos(d) * Math.cos(h) + Math.cos(l) * Math.sin(d),
    ];
}

const hours = [-75, -60, -45, -30, -15, 0, 15, 30, 45, 60, 75];
const sumOf = (list) => list.reduce((sum, x) => sum + x, 0);

test('turning S34: a direction of the bake is itself, and the middle between two has half of each over the cosine', () => {
    const day = hours.map((hour) => sunlight(hour, 0));
    for (const [k, hour] of hours.entries())
        weightsOfDirections(day, sunlight(hour, 0)).forEach((w, i) => assert.ok(Math.abs(w - Number(i === k)) < 1e-4, `${k} ${i} ${w}`));
    const weights = weightsOfDirections(day, sunlight(7.5, 0));
    for (const i of [5, 6]) assert.ok(Math.abs(weights[i] - 0.5 / Math.cos(radians(7.5))) < 1e-3);
});

test('turning S34: weights of a day are continuous, at least 0, and add up to the direction', () => {
    for (const declination of [-23.4, 0, 10, 23.4]) {
        const day = hours.map((hour) => sunlight(hour, declination));
        let before = weightsOfDirections(day, day[0]);
        for (let hour = -75; hour < 75; hour += 0.25) {
            const target = sunlight(hour, declination);
            const weights = weightsOfDirections(day, target);
            assert.ok(Math.min(...weights) >= 0);
            const off = [0, 1, 2].map((c) => sumOf(weights.map((w, i) => w * day[i][c])) - target[c]);
            assert.ok(Math.hypot(...off) < 0.006, `${declination} ${hour}`);
            assert.ok(Math.max(...weights.map((w, i) => Math.abs(w - before[i]))) < 0.025, `${declination} ${hour}`);
            before = weights;
        }
    }
});

test('turning S34: beyond all directions light fades by the cosine', () => {
    const [east, up] = [[-0.5, -Math.sqrt(0.75), 0], [0, -1, 0]];
    assert.ok(Math.abs(weightsOfDirections([east, up], [Math.sqrt(0.75), -0.5, 0])[1] - 0.5) < 0.06);
    assert.ok(sumOf(weightsOfDirections([east, up], [0, 1, 0])) < 1e-5);
    assert.ok(sumOf(weightsOfDirections([east, up], [0, 1, 0])) > 0);
});

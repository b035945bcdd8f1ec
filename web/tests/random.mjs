/** Numbers below n, the same in each run. */
export function randomizer(seed) {
    let state = seed;
    return (n) => {
        state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
        return (state / 2 ** 32) * n;
    };
}

// Automatic exposure, by the rule of the program's automaticExposure().

const BURNT = 4; // radiance, times the exposure's factor, that is shown as 253 of 255
const PART_BURNT = 1 / 50; // of the pixels may be brighter
const MOST_STOPS = 2; // that highlights make a picture darker

/** EV in which a picture is as bright as middle grey on average. @param {Float32Array} radiance RGBA */
export function automaticExposure(radiance) {
    const peaks = [];
    let sum = 0;
    let count = 0;
    for (let i = 0; i < radiance.length; i += 4) {
        const [r, g, b] = radiance.subarray(i, i + 3);
        const peak = Math.max(r, g, b);
        if (!Number.isFinite(peak)) continue;
        peaks.push(peak);
        const luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        if (!(luminance > 1e-6)) continue; // no sky, no light
        sum += Math.log2(luminance);
        ++count;
    }
    if (count === 0) return 0;
    const average = sum / count - Math.log2(0.18);
    const brightest = peaks.sort((a, b) => b - a)[Math.floor(peaks.length * PART_BURNT)];
    return Math.min(Math.max(Math.log2(brightest / BURNT), average), average + MOST_STOPS);
}

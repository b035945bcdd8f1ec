// Animations of KHR_animation_pointer that change light, which three.js's loader leaves out: weights of light groups, colour and
// intensity of lights, visibility of nodes.
import { AnimationClip, BooleanKeyframeTrack, ColorKeyframeTrack, InterpolateDiscrete, InterpolateLinear, NumberKeyframeTrack, Object3D, VectorKeyframeTrack } from 'three';

const WEIGHT = /^\/extensions\/HALFLIGHT_mixed_lighting\/groups\/(\d+)\/weight$/;
const LIGHT = /^\/extensions\/KHR_lights_punctual\/lights\/(\d+)\/(intensity|color)$/;
const VISIBLE = /^\/nodes\/(\d+)\/extensions\/KHR_node_visibility\/visible$/;

/** What tracks of weights name: clones of the file have one too, of the same groups. */
class GroupWeights extends Object3D {
    /** @param {string} [file] mark of the file */
    constructor(file = '') {
        super();
        this.name = `halflight_groups_${file}`;
        /** @type {any[]} */
        this.groups = [];
    }

    /** For clone(). @param {GroupWeights} source @param {boolean} [recursive] */
    copy(source, recursive) {
        super.copy(source, recursive);
        this.groups = source.groups;
        return this;
    }
}

const nameOf = (object) => object.name || object.uuid;

/**
 * Names of the properties that a pointer drives, and the kind of their tracks; null where it drives no light.
 * @param {string} pointer @param {any} json @param {Map<number, any>} nodes objects by node @param {{light: any, node: number}[]} lights
 * @param {() => any} weights the object of the groups' weights
 */
function targetOf(pointer, json, nodes, lights, weights) {
    const [, index, property] = WEIGHT.exec(pointer) ?? LIGHT.exec(pointer) ?? VISIBLE.exec(pointer) ?? [];
    if (index === undefined) return null;
    if (WEIGHT.test(pointer)) return { names: weights().groups[index] ? [`${weights().name}.groups[${index}].weight`] : [], Track: VectorKeyframeTrack, size: 3 };
    if (VISIBLE.test(pointer)) return { names: nodes.has(Number(index)) ? [`${nameOf(nodes.get(Number(index)))}.visible`] : [], Track: BooleanKeyframeTrack, size: 1 };
    const own = lights.filter(({ node }) => json.nodes[node].extensions?.KHR_lights_punctual?.light === Number(index));
    return { names: own.map(({ light }) => `${nameOf(light)}.${property}`), Track: property === 'color' ? ColorKeyframeTrack : NumberKeyframeTrack, size: property === 'color' ? 3 : 1 };
}

function makeTrack(parser, { Track, size }, name, input, output, interpolation) {
    const isSpline = interpolation === 'CUBICSPLINE';
    const count = input.array.length * (isSpline ? 3 : 1);
    if (output.itemSize !== size || output.count !== count) throw new Error(`has ${output.count} values of ${output.itemSize} numbers for ${count} of ${size}`);
    const values = Track === BooleanKeyframeTrack ? [...output.array].map(Boolean) : Float32Array.from(output.array);
    const track = Track === BooleanKeyframeTrack ? new Track(name, input.array, values) : new Track(name, input.array, values, interpolation === 'STEP' ? InterpolateDiscrete : InterpolateLinear);
    if (isSpline) parser._createCubicSplineTrackInterpolant(track);
    return track;
}

/**
 * Adds tracks to the clips of a loaded file. @param {any} gltf @param {any} parser of GLTFLoader
 * @param {import('./scene.js').HalflightScene} halflight @param {Map<number, any>} nodes objects by node @param {{light: any, node: number}[]} lights
 * @param {(index: number) => Promise<{array: Float64Array, itemSize: number, count: number}>} accessor
 */
export async function playPointers(gltf, parser, halflight, nodes, lights, accessor) {
    const { json } = parser;
    let weights = null;
    const ofGroups = () => {
        if (weights) return weights;
        weights = Object.assign(new GroupWeights(halflight.file), { groups: halflight.groups.list });
        gltf.scene.add(weights);
        return weights;
    };
    for (const [i, { channels, samplers, name: title = `animation ${i}` }] of (json.animations ?? []).entries()) {
        const clip = gltf.animations[i];
        for (const { target, sampler } of channels) {
            const pointer = target.extensions?.KHR_animation_pointer?.pointer;
            const driven = pointer === undefined || !(clip instanceof AnimationClip) ? null : targetOf(pointer, json, nodes, lights, ofGroups);
            if (!driven) continue;
            const { input, output, interpolation } = samplers[sampler];
            const [times, values] = await Promise.all([accessor(input), accessor(output)]);
            try {
                if (driven.names.length === 0) throw new Error('refers to what the file lacks');
                for (const name of driven.names.filter((own) => !clip.tracks.some((track) => track.name === own)))
                    clip.tracks.push(makeTrack(parser, driven, name, times, values, interpolation));
            } catch (error) {
                halflight.keep(`animation "${title}" does not play ${pointer}: it ${error.message}`);
            }
        }
        clip?.resetDuration?.();
    }
}

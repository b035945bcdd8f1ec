// What modes and debug views show, in a sentence each, and the colours of the views.

export const MODE_SENTENCES = {
    realtime: 'Direct light and its shadows are realtime. No light bounces.',
    'baked-indirect': 'Direct light and its shadows are realtime. Bounced light is baked.',
    shadowmask: 'Shadows of static objects are baked, those of moving objects are realtime.',
    'distance-shadowmask': 'Shadows are realtime up to the shadow distance and baked beyond it.',
    subtractive: 'Light and shadows are baked. The main light has realtime shadows of moving objects.',
};

const CHANNELS = ['red', 'green', 'blue', 'half as bright'];
const CHANNEL_COLORS = ['#f00', '#0f0', '#00f', '#808080'];

/** The lights of each channel, with the colour in which the shadowmask view shows them. */
function channels(halflight) {
    return CHANNELS.map((word, channel) => {
        const names = halflight.lights.filter(({ data }) => data.channel === channel).map(({ name }) => name);
        if (names.length === 0) return null;
        const text =
            channel < 3 ? `${word} where lit: ${names.join(', ')}` : `${word} where in shadow: ${names.join(', ')}`;
        return [CHANNEL_COLORS[channel], text];
    }).filter(Boolean);
}

/** Views that show values from 0 to 1 as they are; the others show light, exposed and tone mapped. */
export const VALUE_VIEWS = ['shadowmask', 'fade', 'overlap'];

/** By view: a sentence, and a list of colours with what they mean. */
const LEGENDS = {
    lit: () => ['', []],
    shadowmask: (halflight) => ['Baked shadows of each mask channel. White is lit by all lights.', channels(halflight)],
    lightmap: () => [
        'Irradiance of the lightmap, as a white wall would show it. Objects without a lightmap are black.',
        [],
    ],
    probes: () => ['Light of the probes on every surface.', []],
    fade: () => [
        'Where realtime shadows end.',
        [
            ['#000', 'within the shadow distance'],
            ['#fff', 'beyond it'],
        ],
    ],
    overlap: () => [
        'Lights with a mask channel, or for which none was left.',
        [
            ['#000', 'none'],
            ['#00f', '1'],
            ['#0f0', '2'],
            ['#ff0', '3'],
            ['#f00', '4'],
            ['#fff', 'more: some have no mask'],
        ],
    ],
};

/** @returns {[string, [string, string][]]} a sentence, and colours with their meaning */
export const legendOf = (halflight) => LEGENDS[halflight.debugView](halflight);

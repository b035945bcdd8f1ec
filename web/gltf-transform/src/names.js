// Names of docs/format.md.
export const MIXED_LIGHTING = 'HALFLIGHT_mixed_lighting';
export const NODE = 'HALFLIGHT_node';
export const LIGHT = 'HALFLIGHT_light';
export const MATERIAL = 'HALFLIGHT_material';
export const AREA_LIGHTS = 'EXT_lights_area';
export const TEXTURE_KTX2 = 'HALFLIGHT_texture_ktx2';

/** Members of the root extension that list one picture per lightmap page. */
export const PICTURE_LISTS = ['lightmaps', 'lightmapDirections', 'shadowmasks'];
/** Those of them that a light group has too. */
export const GROUP_LISTS = ['lightmaps', 'lightmapDirections'];
/** Key of the sky's picture among those of the bake. */
export const SKY_PICTURE = 'sky';
/** Key of the reflection probes' picture. */
export const REFLECTION_PICTURE = 'reflectionProbes';
/** Members of `probes` that are accessors. */
export const PROBE_ACCESSORS = ['positions', 'radiance', 'occlusion', 'occlusion1', 'occlusion2', 'occlusion3', 'valid', 'tetrahedra', 'neighbors', 'sightRanges', 'sight'];

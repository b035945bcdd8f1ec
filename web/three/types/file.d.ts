export interface Pixels {
    width: number;
    height: number;
    data: Uint32Array | Uint8Array;
}

export interface NodeData {
    isStatic: boolean;
    castShadows: boolean;
    receiveShadows: boolean;
    lightmap: { page: number; scale: number[]; offset: number[]; texCoord: number; perInstance: boolean } | null;
    probes: 'automatic' | 'single' | 'volume';
    probeResolution: number[];
}

export interface LightData {
    castShadows: boolean;
    shadowStrength: number;
    shadowBias: { depth?: number; slope?: number; normal?: number };
    isBaked: boolean;
    bakeType: 'realtime' | 'mixed' | 'baked';
    /** -1 none */
    channel: number;
    /** Its mask has a colour: three channels, of which `channel` is the first. */
    coloredMask: boolean;
    reason: string;
    worldFromLight: number[];
    reach: number;
    outerCone: number;
    /** Index among the light groups, -1 none. */
    group: number;
    /** Colour times intensity at the weight 1. */
    white: number[];
    /** Of a light that turns: the first direction's group, and unit vectors along which it shone in the bake. */
    turns?: { group: number; directions: number[][] };
}

/** Light by itself, at the weight 1. */
export interface GroupData {
    name: string;
    /** That the file saves, by channel. */
    weight: number[];
    /** Lux of the brightest channel of a texel. */
    peak: number;
    /** Whether the sky is a member. */
    sky: boolean;
    unitLux: number;
    /** RGB9E5 texels; null is a page without light. */
    lightmaps: (Pixels | null)[];
    /** RGBA8 texels; none where no page has them. */
    directions: (Pixels | null)[];
    /** Nine RGB coefficients for each probe. */
    radiance: Float32Array;
    /** Lower limit of subtractive shadows, lux. */
    shadowColor: number[];
    /** Null where the bake's picture has the group at its saved weight. */
    reflections: ReflectionPicture | null;
}

/** Reflection probes' tiles of a width, RGB9E5 with a unit in cd/m2, one below the other. */
export interface ReflectionPicture {
    picture: Pixels;
    unitNits: number;
    size: number;
}

export interface ProbeData {
    count: number;
    /** World. */
    positions: Float32Array;
    /** Nine RGB coefficients for each probe. */
    radiance: Float32Array;
    /** Four channels for each probe. */
    occlusion: Float32Array;
    valid: Uint8Array;
    grid: { origin: number[]; spacing: number[]; size: number[] } | null;
    /** Tetrahedra: four indices of probes and of neighbours for each; null in files of older bakes, where probes lie in one plane. */
    cells: { vertices: Uint32Array; neighbors: Uint32Array } | null;
}

export interface BakedData {
    version: number;
    mode: 'baked-indirect' | 'shadowmask' | 'subtractive';
    unitLux: number;
    /** RGB9E5 texels. */
    lightmaps: Pixels[];
    /** RGBA8 texels. */
    directions: Pixels[];
    /** RGBA8 texels. */
    masks: Pixels[];
    maskChannels: { rangeTexels: number; penumbraTexels: number }[];
    probes: ProbeData | null;
    /** cd/m2. The picture, where there is one, is RGB9E5 with a unit, turned about +Y; the colours are the gradient nearest to it. */
    sky: { zenith: number[]; horizon: number[]; ground: number[]; picture?: { pixels: Pixels; unitNits: number; rotation: number } };
    /** World space. */
    reflections: (ReflectionPicture & { probes: { position: number[]; box: number[]; fade: number }[] }) | null;
    /** Lower limit of subtractive shadows, lux; of the rest where groups have their own. */
    shadowColor: number[];
    /** Light groups, whose light lightmaps, directions and probes lack. */
    groups: GroupData[];
    /** What a tool dropped of the bake. */
    lost: string[];
    nodes: Map<number, NodeData>;
    lights: Map<number, LightData>;
    /** white: emission at the weight 1 of its light group, cd/m2. */
    materials: Map<number, { castShadows: boolean; receiveShadows: boolean; group: number; white: number[] }>;
    bytes: { lightmaps: number; masks: number; directions: number; probes: number; sky: number; reflections: number; groups: number };
}

export interface Source {
    json: unknown;
    accessor(index: number): Promise<{ array: ArrayLike<number>; itemSize: number; count: number }>;
    bufferView(index: number): Promise<ArrayBuffer | Uint8Array>;
    /** Bytes of a URI relative to the document, or of a data URI. */
    file(uri: string): Promise<ArrayBuffer | Uint8Array>;
}

export function isBaked(json: unknown): boolean;
export function readBaked(source: Source): Promise<BakedData>;
/** Pages of a state of a bake with light groups: weights by channel in the groups' order, the saved ones where absent. */
export function composeLight(data: BakedData, weights?: number[][]): { unitLux: number; lightmaps: Pixels[]; directions: Pixels[] };
/** The reflection probes' picture of such a state; null where the file has none. */
export function composeReflections(data: BakedData, weights?: number[][]): ReflectionPicture | null;

// Area lights of EXT_lights_area, which three.js's loader does not read: objects of the scene that the plug-in draws.
import { Color, Object3D, Vector3 } from 'three';

export const AREA_LIGHTS = 'EXT_lights_area';

/** A rectangle or disk in its XY plane that shines along -Z. Colour, intensity, size and range may change. */
export class AreaLight extends Object3D {
    /** @param {any} json of the extension @param {number} range metres, 0 = unlimited */
    constructor(json = {}, range = 0) {
        super();
        this.isHalflightAreaLight = true;
        this.name = json.name ?? '';
        this.isDisk = json.type === 'disk';
        this.color = new Color().setRGB(...(json.color ?? [1, 1, 1]));
        /** Radiance of its surface, cd/m2. */
        this.intensity = json.intensity ?? 1000;
        this.height = json.size ?? 1;
        /** In units of the node, as height. Of a disk both are the diameter. */
        this.width = this.isDisk ? this.height : this.height * (json.rect?.aspect ?? 1);
        /** Metres of the file from its middle at which its light ends; 0 = unlimited. */
        this.range = range;
        this.castShadow = false; // three.js draws no map of it: its realtime shadows are left out
    }

    /** For clone(). @param {AreaLight} source @param {boolean} [recursive] */
    copy(source, recursive) {
        super.copy(source, recursive);
        for (const key of ['isDisk', 'intensity', 'height', 'width', 'range']) this[key] = source[key];
        this.color.copy(source.color);
        return this;
    }

    /** From the middle to the edges along its X and Y, in the world: sizes take the largest scale of the node. */
    halfSides() {
        const axes = [0, 1, 2].map((i) => new Vector3().setFromMatrixColumn(this.matrixWorld, i));
        const scale = Math.max(...axes.map((axis) => axis.length()));
        return [axes[0].normalize().multiplyScalar((scale * this.width) / 2), axes[1].normalize().multiplyScalar((scale * this.height) / 2)];
    }

    /** Square metres. */
    area() {
        const [x, y] = this.halfSides();
        return (this.isDisk ? Math.PI : 4) * x.length() * y.length();
    }
}

/** The area light of a node, added to its object, or null. @param {any} root @param {any} json of the file @param {number} node */
export function areaLightOf(root, json, node) {
    const { extensions } = json.nodes[node];
    const light = json.extensions?.[AREA_LIGHTS]?.lights?.[extensions?.[AREA_LIGHTS]?.light];
    if (!light || extensions.KHR_lights_punctual) return null;
    const object = new AreaLight(light, extensions.HALFLIGHT_light?.range ?? 0);
    root.add(object);
    object.updateWorldMatrix(true, false);
    return object;
}

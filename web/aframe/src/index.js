// <a-entity halflight-model="src: baked.glb; mode: shadowmask"></a-entity>
import AFRAME from 'aframe';
import { Object3D } from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { HalflightPlugin } from '@halflight/three';

import { freeObjects } from './free.js';

if (AFRAME.THREE.Object3D !== Object3D)
    throw new Error(
        "Halflight: A-Frame has a three.js of its own: map 'aframe' to its module build and 'three' to its super-three"
    );

/** Systems tick after all components: controls have moved the camera. */
AFRAME.registerSystem('halflight-model', {
    init() {
        this.models = new Set();
    },
    tick() {
        const { renderer, camera } = this.el;
        if (camera) for (const { halflight } of this.models) halflight?.update(renderer, camera);
    },
});

AFRAME.registerComponent('halflight-model', {
    schema: {
        src: { type: 'model' },
        mode: { default: '' },
        shadowDistance: { default: 60 },
        shadowFadeRange: { default: 1 },
        debugView: { default: 'lit' },
        sky: { default: true },
    },

    init() {
        const { systems } = this.el.sceneEl;
        /** null until a baked file is loaded */
        this.halflight = null;
        this.gltf = null;
        this.system.models.add(this);
        // What A-Frame's own components do for lights and shadows.
        systems.light.registerLight(this.el);
        systems.shadow.setShadowMapEnabled(true);
    },

    update(before) {
        const { src, sky } = this.data;
        if (src !== before.src || sky !== before.sky) this.load(src);
        else this.set();
    },

    /** @param {string} src */
    async load(src) {
        this.unload();
        if (!src) return;
        const loading = (this.loading = {});
        try {
            const loader = await this.makeLoader();
            const gltf = await loader.loadAsync(src);
            if (this.loading !== loading) return freeObjects(gltf);
            this.gltf = gltf;
            this.halflight = gltf.userData.halflight;
            gltf.scene.animations = gltf.animations;
            this.set();
            this.el.setObject3D('mesh', gltf.scene);
            const { scene: model } = gltf;
            this.el.emit('model-loaded', { format: 'gltf', model, gltf, halflight: this.halflight });
        } catch (error) {
            if (this.loading !== loading) return;
            console.error(`Halflight: ${src}: ${error.message}`);
            this.el.emit('model-error', { format: 'gltf', src, error });
        }
    },

    /** With the decoders that A-Frame's own gltf-model has. */
    async makeLoader() {
        const decoders = this.el.sceneEl.systems['gltf-model'];
        const loader = new GLTFLoader();
        loader.register((parser) => new HalflightPlugin(parser, { sky: this.data.sky }));
        if (decoders.getDRACOLoader()) loader.setDRACOLoader(decoders.getDRACOLoader());
        if (decoders.getKTX2Loader()) loader.setKTX2Loader(decoders.getKTX2Loader());
        if (decoders.getMeshoptDecoder()) loader.setMeshoptDecoder(await decoders.getMeshoptDecoder());
        return loader;
    },

    set() {
        const { mode, shadowDistance, shadowFadeRange, debugView } = this.data;
        if (!this.halflight) return;
        Object.assign(this.halflight, { shadowDistance, shadowFadeRange, debugView, mode: mode || this.halflight.data.mode });
    },

    unload() {
        this.loading = null;
        if (!this.gltf) return;
        this.el.removeObject3D('mesh');
        freeObjects(this.gltf);
        this.gltf = this.halflight = null;
    },

    remove() {
        this.unload();
        this.system.models.delete(this);
    },
});

// Draws frames: one for all changes before it, and none while nothing changes. The first picture of a file has half the
// resolution and no realtime shadow maps, so that few shaders are compiled. The whole picture follows.
import * as THREE from 'three';
import { OutputPass } from 'three/addons/postprocessing/OutputPass.js';
import { FullScreenQuad } from 'three/addons/postprocessing/Pass.js';

import { automaticExposure } from './exposure.js';
import { VALUE_VIEWS } from './views.js';

const SAMPLES = 4; // of a pixel of the whole picture
const MEASURED = [160, 90]; // pixels that the exposure is measured in

export class Stage {
    #requested = false;
    #isWhole = false;
    #shaderTrouble = null;
    #isMeasured = false;
    #finishing = null;

    /**
     * @param {HTMLCanvasElement} canvas
     * @param {{beforeFrame: (time: number) => void, afterFrame: (seconds: number) => void,
     *     failed: (error: Error) => void}} events
     */
    constructor(canvas, events) {
        this.canvas = canvas;
        this.events = events;
        this.renderer = new THREE.WebGLRenderer({ canvas, antialias: false }); // the radiance is
        this.radiance = new THREE.WebGLRenderTarget(1, 1, { type: THREE.HalfFloatType });
        this.output = Object.assign(new OutputPass(), { renderToScreen: true });
        this.measured = new THREE.WebGLRenderTarget(...MEASURED, { type: THREE.HalfFloatType, depthBuffer: false });
        this.small = new FullScreenQuad(new THREE.MeshBasicMaterial({ map: this.radiance.texture, toneMapped: false }));
        this.renderer.debug.onShaderError = (gl, program) =>
            (this.#shaderTrouble ??= gl.getProgramInfoLog(program)?.trim() || 'no reason given');
        this.camera = new THREE.PerspectiveCamera(52, 1, 0.05, 1000);
        /** @typedef {{gltf: any, halflight: any, scene?: THREE.Scene}} Shown a file; the stage gives it a scene */
        /** @type {Shown | null} */
        this.shown = null;
        /** @type {Shown | null} What the file was before its bake, shown left of the divider. */
        this.before = null;
        /** Where the divider is, as a part of the width. */
        this.split = 0.5;
        /** EV, as `render --exposure` has it. */
        this.exposure = 0;
        /** Whether the exposure follows from the picture: of a file that opens, or after `exposeAutomatically()`. */
        this.isAutomatic = true;
        new ResizeObserver(() => this.resize()).observe(canvas);
        canvas.addEventListener('webglcontextlost', () => (this.#finishing = null));
        canvas.addEventListener('webglcontextrestored', () => this.redraw());
    }

    /** @param {number} ev */
    expose(ev) {
        this.exposure = ev;
        this.isAutomatic = false;
    }

    exposeAutomatically() {
        this.isAutomatic = true;
        this.#isMeasured = false;
    }

    /** Shows a file in place of the last ones. @param {Shown | null} file @param {Shown | null} [before] its bake */
    show(file, before = null) {
        const last = new Set([this.shown, this.before]);
        this.shown = this.before = null;
        for (const { gltf, halflight } of [...last].filter((old) => old && old !== before)) {
            gltf.scene.removeFromParent();
            halflight.dispose();
            freeScene(gltf.scene);
        }
        this.#isWhole = false;
        this.#shaderTrouble = null;
        this.exposeAutomatically();
        if (!file) {
            this.renderer.setRenderTarget(null);
            this.renderer.clear();
            return;
        }
        const { near, far } = depthRange(file.halflight.bounds);
        Object.assign(this.camera, { near, far });
        this.camera.updateProjectionMatrix();
        file.scene = new THREE.Scene().add(file.gltf.scene);
        this.shown = file;
        this.before = before;
        this.#setQuality();
        this.redraw();
    }

    #setQuality() {
        const whole = Math.min(devicePixelRatio, 2);
        this.renderer.shadowMap.enabled = this.#isWhole;
        this.renderer.setPixelRatio(this.#isWhole ? whole : whole / 2);
        this.radiance.dispose();
        this.radiance.samples = this.#isWhole ? SAMPLES : 0;
        this.#fitRadiance();
        document.body.dataset.picture = this.#isWhole ? 'whole' : 'first';
    }

    #fitRadiance() {
        const { x, y } = this.renderer.getDrawingBufferSize(new THREE.Vector2());
        this.radiance.setSize(x, y);
    }

    resize() {
        const { clientWidth, clientHeight } = this.canvas;
        if (clientWidth === 0 || clientHeight === 0) return;
        this.renderer.setSize(clientWidth, clientHeight, false);
        this.#fitRadiance();
        this.camera.aspect = clientWidth / clientHeight;
        this.camera.updateProjectionMatrix();
        if (this.shown) this.#draw(performance.now()); // now: the canvas is empty
    }

    redraw() {
        if (this.#requested) return;
        this.#requested = true;
        requestAnimationFrame((time) => {
            this.#requested = false;
            this.#draw(time);
        });
    }

    #draw(time) {
        if (!this.shown || this.renderer.getContext().isContextLost()) return;
        this.events.beforeFrame(time);
        const start = performance.now();
        try {
            this.#render();
            if (this.#shaderTrouble) throw new Error(`the graphics driver refuses its shaders: ${this.#shaderTrouble}`);
        } catch (error) {
            this.show(null);
            this.events.failed(error);
            return;
        }
        this.events.afterFrame((performance.now() - start) / 1000);
        document.body.dataset.frames = String(Number(document.body.dataset.frames ?? 0) + 1);
        if (!this.#isWhole) this.#finish(this.shown);
    }

    /** Radiance first, so that its exposure is known before it is shown. */
    #render() {
        const { renderer, radiance, shown, before } = this;
        const { debugView } = shown.halflight;
        const middle = before ? Math.round(this.split * radiance.width) : 0;
        if (before) follow(before.halflight, shown.halflight);
        if (middle > 0) this.#renderPart(before, 0, middle);
        if (middle < radiance.width) this.#renderPart(shown, middle, radiance.width);
        if (this.isAutomatic && !this.#isMeasured && debugView === 'lit') this.#measure();
        renderer.setRenderTarget(null);
        const isLight = !VALUE_VIEWS.includes(debugView);
        renderer.toneMapping = isLight ? THREE.NeutralToneMapping : THREE.NoToneMapping; // the program's
        renderer.outputColorSpace = isLight ? THREE.SRGBColorSpace : THREE.LinearSRGBColorSpace; // values as they are
        renderer.toneMappingExposure = 2 ** -this.exposure;
        this.output.render(renderer, null, radiance);
    }

    /** Draws a file between two columns of the radiance. */
    #renderPart(file, left, right) {
        const { renderer, radiance, camera } = this;
        radiance.scissor.set(left, 0, right - left, radiance.height);
        radiance.scissorTest = true;
        file.halflight.update(renderer, camera);
        renderer.setRenderTarget(radiance);
        renderer.render(file.scene, camera);
        this.drawn = { ...renderer.info.render };
    }

    #measure() {
        const { renderer, measured } = this;
        renderer.setRenderTarget(measured);
        this.small.render(renderer);
        const halves = new Uint16Array(4 * measured.width * measured.height);
        renderer.readRenderTargetPixels(measured, 0, 0, measured.width, measured.height, halves);
        this.exposure = automaticExposure(Float32Array.from(halves, THREE.DataUtils.fromHalfFloat));
        this.#isMeasured = true;
    }

    /** Makes the shaders of the whole picture while the quick one is shown, then draws it. */
    async #finish(file) {
        if (this.#finishing === file) return;
        this.#finishing = file;
        await new Promise((resolve) => setTimeout(resolve)); // the quick picture is presented first
        if (this.shown !== file) return;
        try {
            this.renderer.shadowMap.enabled = true;
            file.halflight.update(this.renderer, this.camera);
            this.renderer.setRenderTarget(this.radiance); // no tone mapping in them
            const compiled = this.renderer.compileAsync(file.scene, this.camera);
            this.renderer.setRenderTarget(null);
            this.renderer.shadowMap.enabled = false;
            await compiled;
        } catch {
            // the whole picture says why
        }
        if (this.shown !== file) return;
        this.#isWhole = true;
        this.#finishing = null;
        this.#isMeasured = false; // realtime shadows make it darker
        this.#setQuality();
        this.#draw(performance.now());
    }
}

/** Planes that hold the scene, and all of it from about outside. @param {THREE.Box3} bounds */
function depthRange(bounds) {
    const size = Math.max(bounds.getSize(new THREE.Vector3()).length(), 0.1);
    return { near: Math.min(0.05, size / 200), far: Math.max(1000, 20 * size) };
}

/** What was chosen for a file holds for what it was before its bake: nodes of both, and so lights, have one order. */
function follow(before, shown) {
    const { debugView, shadowDistance, shadowFadeRange } = shown;
    Object.assign(before, { debugView, shadowDistance, shadowFadeRange });
    before.lights.forEach(({ light }, i) => {
        if (!shown.lights[i]) return;
        light.intensity = shown.lights[i].light.intensity;
        light.color.copy(shown.lights[i].light.color);
    });
}

function freeScene(root) {
    root.traverse((object) => {
        object.geometry?.dispose();
        for (const material of [object.material ?? []].flat()) {
            for (const value of Object.values(material)) if (value?.isTexture) value.dispose();
            material.dispose();
        }
    });
}

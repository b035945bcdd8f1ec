// The divider between what a file was before its bake and the baked file: a slider that lies over the picture.
const element = (id) => document.getElementById(id);
const THUMB = 44; // pixels, as in viewer.css

export class Divider {
    /** @param {(part: number) => void} moved to a part of the picture's width */
    constructor(moved) {
        this.moved = moved;
        this.slider = element('split');
        this.slider.addEventListener('input', () => this.#follow());
        new ResizeObserver(() => this.#follow()).observe(element('beside'));
    }

    #follow() {
        const width = element('beside').clientWidth;
        if (width === 0) return;
        const place = THUMB / 2 + (this.slider.value / 100) * (width - THUMB); // the middle of the thumb
        element('beside').style.setProperty('--place', `${place}px`);
        this.moved({ 0: 0, 100: 1 }[this.slider.value] ?? place / width); // at its ends one of both alone is shown
    }

    /** At first it is in the middle of what the panel leaves of the picture. @param {boolean} isShown */
    show(isShown) {
        if (isShown && element('beside').hidden) {
            const { left, right, top } = element('picture').getBoundingClientRect();
            const panel = element('panel').getBoundingClientRect();
            const free = panel.top < top + 40 && panel.right < right - THUMB ? Math.max(panel.right, left) : left;
            this.slider.value = String((100 * ((free + right) / 2 - left - THUMB / 2)) / (right - left - THUMB));
        }
        element('beside').hidden = !isShown;
        if (isShown) this.#follow();
    }
}

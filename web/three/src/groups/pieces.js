// A sum that the processor makes piece by piece: a step of a generator a frame. A change meanwhile waits for the sum's end.
export class Pieces {
    /** @param {() => Generator<void, any>} begin the sum at the weights of now; of version 0 it is there */
    constructor(begin) {
        this.begin = begin;
        this.version = 0;
        this.steps = null;
    }

    /** Does a step towards a version of the weights. @param {number} version @returns {any} the sum where it is whole by this step, null otherwise */
    next(version) {
        if (!this.steps) {
            if (this.version === version) return null;
            this.version = version;
            this.steps = this.begin();
        }
        const { done, value } = this.steps.next();
        if (!done) return null;
        this.steps = null;
        return value;
    }

    /** @param {number} version */
    has(version) {
        return this.steps === null && this.version === version;
    }
}

// Sentences about what is left out, guessed or shows in part: on the console once each, and in a set while they hold.
export class Warnings {
    #said = new Set();
    #kept = new Set();
    #now = new Set();

    constructor() {
        /** @type {Set<string>} sentences whose cause is there */
        this.sentences = new Set();
    }

    /** A cause that a frame found: `begin()` of a later frame takes it back. @param {string} sentence */
    say(sentence) {
        this.#now.add(sentence);
        this.#show(sentence);
    }

    /** A cause that stays. @param {string} sentence */
    keep(sentence) {
        this.#kept.add(sentence);
        this.#show(sentence);
    }

    #show(sentence) {
        this.sentences.add(sentence);
        if (this.#said.has(sentence)) return;
        this.#said.add(sentence);
        console.warn(`Halflight: ${sentence}`);
    }

    begin() {
        this.#now.clear();
    }

    end() {
        for (const sentence of this.sentences) if (!this.#now.has(sentence) && !this.#kept.has(sentence)) this.sentences.delete(sentence);
    }
}

/** Throws one sentence unless `value` is a number from `least` to `most`. */
export function checkNumber(name, value, unit, least = 0, most = Number.MAX_VALUE) {
    if (typeof value === 'number' && value >= least && value <= most) return value;
    const range = most === Number.MAX_VALUE ? `from ${least} on` : `from ${least} to ${most}`;
    throw new Error(`${name} is ${typeof value === 'string' ? `"${value}"` : value}: it is a number${unit} ${range}`);
}

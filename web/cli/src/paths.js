// Between the user's paths and the program's, which knows '/' alone. Folders of the machine are used in place.
//
//   Linux, macOS   /home/me/a.glb      /home/me/a.glb, since each folder in '/' is mounted under its own name
//                  /a.glb              /.root/a.glb
//   Windows        C:\me\a.glb         /C:/me/a.glb
//                  \\server\share\a    /server/share/a
//                  out\a.glb           out/a.glb
import { existsSync, readdirSync, realpathSync, statSync } from 'node:fs';
import { posix, win32 } from 'node:path';

import { COMMANDS } from './options.js';

/** The program has its own. */
const ITS_OWN = ['dev', 'proc', 'sys'];
const ROOT = '/.root';

function topFolders() {
    return readdirSync('/').filter((name) => {
        try {
            return !ITS_OWN.includes(name) && statSync(`/${name}`).isDirectory();
        } catch {
            return false; // a link that leads nowhere
        }
    });
}

/** Paths of one run. `mounts`: what lies where for the program; `folder`: where it starts. */
export class Paths {
    constructor({ windows = process.platform === 'win32', folder = process.cwd(), tops = windows ? [] : topFolders() } = {}) {
        this.windows = windows;
        this.userFolder = folder;
        this.mounts = new Map(tops.map((name) => [`/${name}`, realpathSync(`/${name}`)]));
        this.tops = new Set(tops);
        /** What messages say of a path: [of the program, of the user]. */
        this.shown = new Map();
        this.folder = this.#absolute(folder);
    }

    #absolute(path) {
        if (this.windows) {
            const { root } = win32.parse(path);
            const at = `/${root.replaceAll('\\', '/').replace(/^\/+|\/+$/g, '')}`.replace(/^\/[a-z]:/, (drive) => drive.toUpperCase());
            this.mounts.set(at, root);
            this.shown.set(`${at}/`, root);
            return posix.join(at, path.slice(root.length).replaceAll('\\', '/'));
        }
        const [, top, rest] = path.match(/^\/([^/]*)(.*)$/);
        if (rest || this.tops.has(top)) return path;
        this.mounts.set(ROOT, '/');
        this.shown.set(`${ROOT}/`, '/');
        return posix.join(ROOT, top);
    }

    /** The program's name of a path of the user. */
    toProgram(path) {
        if (path === '') return path;
        let name = path;
        if (this.windows) {
            // Programs write long paths as \\?\C:\a and \\?\UNC\server\share\a.
            const plain = path.replace(/^\\\\\?\\(UNC\\)?/i, (_, isShare) => (isShare ? '\\\\' : ''));
            const anchored = win32.isAbsolute(plain) || /^[A-Za-z]:/.test(plain);
            name = anchored ? this.#absolute(win32.resolve(this.userFolder, plain)) : plain.replaceAll('\\', '/');
        } else {
            const whole = posix.resolve(this.userFolder, path);
            if (posix.dirname(whole) === '/' && (posix.isAbsolute(path) || this.userFolder !== '/')) {
                const absolute = this.#absolute(whole);
                if (absolute !== whole) name = absolute;
            }
        }
        if (name !== path) this.shown.set(name, path);
        return name;
    }

    /** A drive or share of Windows that is named and not there; without it the program would write into nothing. */
    missingDrive() {
        return this.windows ? [...this.mounts.values()].find((root) => !existsSync(root)) : undefined;
    }

    /** The command line with the program's names. */
    argumentsOf(words) {
        const table = COMMANDS[words[0]];
        if (!table) return words;
        let positional = false;
        let next = null; // what the word before says of this one
        return words.map((word, i) => {
            if (i === 0) return word;
            if (next) {
                const isPath = next === 'path';
                next = null;
                return isPath ? this.toProgram(word) : word;
            }
            if (positional || !/^-./.test(word)) return this.toProgram(word);
            if (word === '--') {
                positional = true;
                return word;
            }
            const [, name, value] = word.match(/^(--[^=]+=|-[^-])(.+)$/s) ?? [null, null, null];
            if (name) return table.paths.includes(name.replace('=', '')) ? name + this.toProgram(value) : word;
            if (!table.flags.includes(word)) next = table.paths.includes(word) ? 'path' : 'value';
            return word;
        });
    }

    /** A message in the user's names, the longest first. */
    static show(text, shown) {
        const pairs = [...shown].sort(([a], [b]) => b.length - a.length);
        return pairs.reduce((result, [program, user]) => result.replaceAll(program, () => user), text);
    }
}

// Reads the shading headers (include/halflight/shading/language.h says how they are written) as GLSL and as JavaScript.
import { dirname, join } from 'node:path';

/** The headers as GLSL ES 3.00 without comments and directives, each included file once, includes first. */
export function preprocess(paths, read) {
    const seen = new Set();
    const lines = [];
    const include = (path) => {
        if (seen.has(path)) return;
        seen.add(path);
        const skipping = []; // one entry for each open conditional: whether its current branch is skipped
        for (const line of read(path).split('\n')) {
            const directive = /^\s*#\s*(\w+)\s*(.*)$/.exec(line);
            if (!directive) {
                if (!skipping.includes(true)) lines.push(line);
                continue;
            }
            const [, word, rest] = directive;
            if (word === 'ifdef') skipping.push(rest.startsWith('__cplusplus'));
            else if (word === 'ifndef') skipping.push(false); // include guards
            else if (word === 'else') skipping.push(!skipping.pop());
            else if (word === 'endif') skipping.pop();
            else if (word === 'include' && !skipping.includes(true)) include(join(dirname(path), rest.slice(1, -1)));
        }
    };
    paths.forEach(include);
    return lines
        .map((line) => line.replace(/\s*\/\/.*$/, ''))
        .join('\n')
        .replace(/\bHL_FN\s+/g, '')
        .replace(/\bHL_CONST\b/g, 'const')
        .replace(/\bHL_INOUT\((\w+)\)/g, 'inout $1')
        .replace(/\bHL_NAMESPACE_(BEGIN|END)\b\n?/g, '')
        .replace(/(\d(?:\.\d*)?(?:e[-+]?\d+)?)f\b/g, '$1')
        .replace(/\n{2,}/g, '\n')
        .trim()
        .concat('\n');
}

/**
 * The text as three.js's transpiler reads it. Literals become float(…): its output calls methods on them, and a sign before
 * a plain number would apply to the result. Structs are left out; no TSL function uses one.
 */
export function tslSource(glsl) {
    return glsl
        .replace(/^struct (\w+) \{[\s\S]*?^\};\n(?:\1 \w+\([\s\S]*?^\}\n)?/gm, '')
        .replace(/(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?)/g, 'float($1)');
}

const typeNames = 'void|bool|int|uint|float|vec2|vec3|vec4';

/** Names that the text defines: functions, constants, structs. */
function definedNames(text) {
    const names = new Set();
    for (const match of text.matchAll(/^(?:\w+) (\w+)\(/gm)) names.add(match[1]);
    for (const match of text.matchAll(/^const \w+ (\w+) =/gm)) names.add(match[1]);
    for (const match of text.matchAll(/^struct (\w+)/gm)) names.add(match[1]);
    return names;
}

/** The text with `hl` before every name it defines, so that none meets a name of three.js. */
export function prefixed(text) {
    const names = definedNames(text);
    return text.replace(/(?<!\.)\b[A-Za-z_]\w*\b/g, (word) => {
        if (!names.has(word)) return word;
        const stem = /^k[A-Z]/.test(word) ? word.slice(1) : word;
        return (/^[A-Z]/.test(word) ? 'Hl' : 'hl') + stem[0].toUpperCase() + stem.slice(1);
    });
}

/** Functions as {type, name, parameters: [{type, name}], body}. */
export function functionsOf(text) {
    const functions = [];
    for (const match of text.matchAll(/^(\w+) (\w+)\(([^)]*)\)\n\{\n([\s\S]*?)^\}/gm)) {
        const parameters = match[3].split(',').map((parameter) => {
            const [type, name] = parameter.trim().split(/\s+/);
            return { type, name };
        });
        functions.push({ type: match[1], name: match[2], parameters, body: match[4] });
    }
    return functions;
}

const scalar = new Set(['bool', 'int', 'float']);
const mathNames = { abs: 'abs', acos: 'acos', cos: 'cos', exp2: null, floor: 'floor', max: 'max', min: 'min', pow: 'pow', sin: 'sin', sqrt: 'sqrt' };

/**
 * Constants, and the functions that JavaScript can run as they stand: scalar results, scalar arguments or vectors of
 * which only components are read.
 */
export function javascriptOf(functions, text) {
    const chosen = functions.filter((f) => scalar.has(f.type) && runsInJavaScript(f, functions));
    const constants = [...text.matchAll(/^const (?:int|float) (\w+) = (.*);$/gm)];
    const lines = constants.map((match) => `export const ${match[1]} = ${match[2]};`);
    lines.push('const mix = (a, b, t) => a * (1 - t) + b * t;', 'const clamp = (x, a, b) => Math.min(Math.max(x, a), b);');
    const seen = new Set();
    for (const f of chosen) {
        if (seen.has(f.name)) continue; // overloads for vectors come after those for numbers
        seen.add(f.name);
        const parameters = f.parameters.map((p) => `@param {${typeOf(p.type)}} ${p.name}`).join(' ');
        const body = f.body
            .replace(new RegExp(`\\b(?:${typeNames}) (\\w+) =`, 'g'), 'const $1 =')
            .replace(/\b([a-z]\w*)\(/g, (call, name) => (mathNames[name] ? `Math.${mathNames[name]}(` : call));
        lines.push(`/** ${parameters} @returns {${typeOf(f.type)}} */`);
        lines.push(`export function ${f.name}(${f.parameters.map((p) => p.name).join(', ')}) {\n${body}}`);
    }
    return lines.join('\n') + '\n';
}

function typeOf(type) {
    if (type === 'bool') return 'boolean';
    return scalar.has(type) ? 'number' : '{x: number, y: number, z: number}';
}

/** Whether all that a function calls is a scalar function, Math's, or one of its own kind. */
function runsInJavaScript(f, functions) {
    if (f.parameters.some((p) => !scalar.has(p.type) && p.type !== 'vec3')) return false;
    const vectors = f.parameters.filter((p) => !scalar.has(p.type)).map((p) => p.name);
    if (vectors.some((name) => new RegExp(`\\b${name}\\b(?!\\.[xyz]\\b)`).test(f.body.replace(/\w+\(i, \w+\)/g, ''))))
        return false;
    if (/\bvec\d|\bdot\(|\bnormalize\(/.test(f.body)) return false;
    return [...f.body.matchAll(/\b([a-z]\w*)\(/g)].every(([, name]) => {
        if (['if', 'return', 'mix', 'clamp'].includes(name) || mathNames[name]) return true;
        const callee = functions.find((g) => g.name === name);
        return callee !== undefined && callee !== f && scalar.has(callee.type) && runsInJavaScript(callee, functions);
    });
}

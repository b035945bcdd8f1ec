// Paths of the command by npm, for systems that are not this one.
import assert from 'node:assert/strict';
import { test } from 'node:test';

import { Paths } from '../cli/src/paths.js';

const onWindows = () => new Paths({ windows: true, folder: 'C:\\Users\\Zoë Ö\\scenes' });
const onLinux = (folder = '/home/zoë') => new Paths({ windows: false, folder, tops: ['home', 'tmp'] });

test('Windows: only / reaches the program, and messages show what was typed', () => {
    const paths = onWindows();
    const words = paths.argumentsOf(['bake', 'D:\\my rooms\\a.glb', '-o', 'out\\a.glb', '--cache=c:\\cache', '--only', 'a\\b', '--settings', '\\\\server\\share\\s.toml']);
    assert.deepEqual(words, ['bake', '/D:/my rooms/a.glb', '-o', 'out/a.glb', '--cache=/C:/cache', '--only', 'a\\b', '--settings', '/server/share/s.toml']);
    assert.equal(paths.folder, '/C:/Users/Zoë Ö/scenes');
    assert.deepEqual([...paths.mounts.keys()].sort(), ['/C:', '/D:', '/server/share']);
    assert.equal(Paths.show('halflight: /D:/my rooms/a.glb: no such file\n', paths.shown), 'halflight: D:\\my rooms\\a.glb: no such file\n');
    assert.equal(Paths.show('out/a.glb and /D:/my rooms/wall.png', paths.shown), 'out\\a.glb and D:\\my rooms/wall.png');
});

test('Windows: drives without a folder, and roots of the current drive', () => {
    const paths = onWindows();
    assert.equal(paths.toProgram('\\a.glb'), '/C:/a.glb');
    assert.equal(paths.toProgram('C:a.glb'), '/C:/Users/Zoë Ö/scenes/a.glb');
    assert.equal(paths.toProgram('..\\a.glb'), '../a.glb');
});

test('elsewhere paths stay, but for files in the root itself', () => {
    const paths = onLinux();
    const words = ['bake', '/home/zoë/a b.glb', '-o', '../out.glb', '--report', '/tmp/r.json'];
    assert.deepEqual(paths.argumentsOf(words), words);
    assert.equal(paths.shown.size, 0);
    assert.equal(paths.toProgram('/scene.glb'), '/.root/scene.glb');
    assert.equal(paths.toProgram('../../scene.glb'), '/.root/scene.glb');
    assert.equal(Paths.show('/.root/scene.glb: no', paths.shown), '../../scene.glb: no');
    assert.equal(onLinux('/').folder, '/.root');
    assert.equal(onLinux('/').toProgram('scene.glb'), 'scene.glb');
});

test('words that are no paths stay', () => {
    const paths = onWindows();
    for (const words of [['--version'], ['render', 'a\\b.glb'], ['bake', '--help']]) assert.deepEqual(paths.argumentsOf(words), words);
    assert.deepEqual(paths.argumentsOf(['info', '--json', 'x\\y.glb']), ['info', '--json', 'x/y.glb']);
    assert.deepEqual(paths.argumentsOf(['bake', '-oout\\a.glb', '--', '-odd\\b.glb']), ['bake', '-oout/a.glb', '--', '-odd/b.glb']);
});

test('Windows: the long form of a path, and drives that are not there', () => {
    const paths = onWindows();
    assert.equal(paths.toProgram('\\\\?\\C:\\a b.glb'), '/C:/a b.glb');
    assert.equal(paths.toProgram('\\\\?\\UNC\\server\\share\\a.glb'), '/server/share/a.glb');
    assert.equal(Paths.show('/C:/a b.glb: no such file', paths.shown), '\\\\?\\C:\\a b.glb: no such file');
    assert.equal(paths.missingDrive(), 'C:\\', 'this system has none');
    assert.equal(onLinux().missingDrive(), undefined);
});

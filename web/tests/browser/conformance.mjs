// The conformance pack by WebGL.
import { testPack } from './pack.mjs';

testPack('webgl');

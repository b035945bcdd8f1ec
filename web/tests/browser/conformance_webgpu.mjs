// Nightly: the conformance pack by WebGPU.
import { testPack } from './pack.mjs';

testPack('webgpu');

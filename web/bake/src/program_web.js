import { run } from './run.js';

self.onmessage = ({ data }) => run(data, (answer, transferred = []) => self.postMessage(answer, transferred));

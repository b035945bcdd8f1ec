import { parentPort } from 'node:worker_threads';

import { run } from './run.js';

parentPort.once('message', (message) => run(message, (answer, transferred) => parentPort.postMessage(answer, transferred)));

// An ONNX network in ONNX Runtime, forward only, by its npm package onnxruntime-node. Speaks as serve() does in
// support/serve.hpp. A pass is timed from here, so that some tenths of a millisecond of JavaScript are in it.
// usage: onnxruntime_worker.mjs MODULES --model FILE --input FILE --size PIXELS --threads COUNT
import { createRequire } from 'node:module';
import { readFileSync, writeFileSync, writeSync } from 'node:fs';
import { createInterface } from 'node:readline';
import { join } from 'node:path';

const [modules, ...words] = process.argv.slice(2);
const options = {};
for (let i = 0; i + 1 < words.length; i += 2) options[words[i].slice(2)] = words[i + 1];
const require = createRequire(join(modules, 'onnxruntime-node', 'package.json'));
const runtime = require('onnxruntime-node');
const version = require('./package.json').version;

// Reads a number of base 128, protobuf's varint. Returns it and where it ends.
function varint(bytes, at) {
  let value = 0;
  for (let factor = 1; ; factor *= 128) {
    value += (bytes[at] & 127) * factor;
    if (bytes[at++] < 128) return [value, at];
  }
}

// The fields of a protobuf message: number, content if it has a length, and all bytes of the field.
function* fields(bytes) {
  for (let at = 0; at < bytes.length;) {
    const begin = at;
    let tag, length;
    [tag, at] = varint(bytes, at);
    let content;
    if (tag % 8 === 2) {
      [length, at] = varint(bytes, at);
      content = bytes.subarray(at, at + length);
      at += length;
    } else if (tag % 8 === 0) {
      [, at] = varint(bytes, at);
    } else {
      at += tag % 8 === 1 ? 8 : 4;
    }
    yield { number: Math.floor(tag / 8), content, bytes: bytes.subarray(begin, at) };
  }
}

// The same model, without weights listed as inputs: that a caller might replace them keeps the runtime from
// folding them, which would be an unfair handicap.
function withoutWeightsAsInputs(model) {
  const name = (message, number) => [...fields(message)].find((f) => f.number === number)?.content.toString();
  const field = (number, content) => {
    const head = [number * 8 + 2];
    let rest = content.length;
    for (; rest > 127; rest = Math.floor(rest / 128)) head.push((rest % 128) + 128);
    return Buffer.concat([Buffer.from([...head, rest]), content]);
  };
  return Buffer.concat([...fields(model)].map((f) => {
    if (f.number !== 7) return f.bytes; // 7: the graph, in which 5 is an initialiser, 11 an input
    const parts = [...fields(f.content)];
    const weights = new Set(parts.filter((p) => p.number === 5).map((p) => name(p.content, 8)));
    return field(7, Buffer.concat(
      parts.filter((p) => p.number !== 11 || !weights.has(name(p.content, 1))).map((p) => p.bytes)));
  }));
}

const session = await runtime.InferenceSession.create(withoutWeightsAsInputs(readFileSync(options.model)), {
  intraOpNumThreads: Number(options.threads),
  interOpNumThreads: 1,
  executionMode: 'sequential',
  graphOptimizationLevel: 'all',
});
const bytes = readFileSync(options.input);
const values = new Float32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength / 4);
const size = Number(options.size);
const feeds = { [session.inputNames[0]]: new runtime.Tensor('float32', values, [1, 3, size, size]) };

let outputs;
const run = async () => { outputs = await session.run(feeds); };
const send = (reply) => writeSync(1, JSON.stringify(reply) + '\n');

async function turn(seconds) {
  await run();
  const times = [];
  for (let used = 0; used < seconds || times.length === 0; used += times[times.length - 1]) {
    const start = process.hrtime.bigint();
    await run();
    times.push(Number(process.hrtime.bigint() - start) * 1e-9);
  }
  const peak = /VmHWM:\s*(\d+)/.exec(readFileSync('/proc/self/status', 'utf8'))[1] / 1024;
  return { seconds: times, peak_memory_mib: peak };
}

function save(path) {
  const parts = session.outputNames.map((name) => outputs[name].data);
  writeFileSync(path, Buffer.concat(parts.map((p) => Buffer.from(p.buffer, p.byteOffset, p.byteLength))));
  return {};
}

await run();
send({ name: `ONNX Runtime ${version}` });
for await (const line of createInterface({ input: process.stdin })) {
  const [verb, ...rest] = line.split(' ');
  if (verb === 'turn') send(await turn(Number(rest[0])));
  else if (verb === 'save') send(save(rest.join(' ')));
  else if (verb === 'memory') send({});
  else throw new Error(`unknown request '${line}'`);
}

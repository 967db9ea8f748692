// web.mjs PAGE FOLDER NATIVE [LIBM]: opens the page by file: in a headless Chromium, and uses it as a person would: clicks,
// keys, files. Compares losses, paint and detections with those of the same requests to the NATIVE program, which has the
// functions of LIBM, and leaves pictures of 1280 and 390 pixels' width in FOLDER.
import {spawn, spawnSync} from 'node:child_process';
import {copyFileSync, existsSync, mkdirSync, readFileSync, writeFileSync} from 'node:fs';
import {pathToFileURL} from 'node:url';

const [page, folder, native, libm] = process.argv.slice(2);
const views = 240, steps = 160, assets = new URL('../../examples/assets/', import.meta.url).pathname;
mkdirSync(folder, {recursive: true});
let failures = 0;
const check = (holds, what) => {
  console.log(`${holds ? 'ok' : 'FAILED'}: ${what}`);
  if (!holds) ++failures;
};

// Chromium's protocol by a pipe: JSON, ended by a byte 0.
const browser = spawn('chromium', ['--headless=new', '--no-sandbox', '--disable-gpu', '--hide-scrollbars', '--no-first-run',
  '--remote-debugging-pipe', `--user-data-dir=${folder}/profile`, 'about:blank'], {stdio: ['ignore', 'ignore', 'ignore', 'pipe', 'pipe']});
const waiting = new Map(), logged = [];
let received = '', calls = 0;
browser.stdio[4].setEncoding('utf8').on('data', text => {
  const messages = (received + text).split('\0');
  received = messages.pop();
  for (const message of messages.map(JSON.parse)) {
    if (message.method === 'Runtime.exceptionThrown') logged.push(JSON.stringify(message.params.exceptionDetails));
    const [resolve, reject] = waiting.get(message.id) || [];
    waiting.delete(message.id);
    if (message.error && reject) reject(new Error(message.error.message));
    else if (resolve) resolve(message.result);
  }
});
const call = (method, params = {}, sessionId = session) => new Promise((resolve, reject) => {
  waiting.set(++calls, [resolve, reject]);
  browser.stdio[3].write(JSON.stringify({id: calls, method, params, sessionId}) + '\0');
});
let session;
const {targetId} = await call('Target.createTarget', {url: 'about:blank'});
({sessionId: session} = await call('Target.attachToTarget', {targetId, flatten: true}));
await Promise.all(['Page', 'Runtime', 'DOM'].map(domain => call(domain + '.enable')));

const value = async expression => (await call('Runtime.evaluate', {expression, returnByValue: true})).result.value;
const until = async (expression, seconds = 120) => {
  for (const end = Date.now() + 1000 * seconds; Date.now() < end; await new Promise(done => setTimeout(done, 50)))
    if (await value(expression)) return true;
  throw new Error(`waited ${seconds} s for ${expression}; the page says: ${await value("document.getElementById('status').textContent")}`);
};
const click = async id => {
  const at = await value(`(() => { const r = document.getElementById('${id}').getBoundingClientRect(); return {x: r.x + r.width / 2, y: r.y + r.height / 2}; })()`);
  for (const type of ['mousePressed', 'mouseReleased']) await call('Input.dispatchMouseEvent', {type, ...at, button: 'left', clickCount: 1});
};
const press = async key => {
  for (const type of ['rawKeyDown', 'keyUp']) await call('Input.dispatchKeyEvent', {type, key, code: key === ' ' ? 'Space' : key});
};
const resize = (width, height) => call('Emulation.setDeviceMetricsOverride', {width, height, deviceScaleFactor: 1, mobile: width < 500});
const photograph = async name => {
  const {data} = await call('Page.captureScreenshot', {captureBeyondViewport: true});
  writeFileSync(`${folder}/${name}.png`, Buffer.from(data, 'base64'));
};
const choose = async files => {
  const {root} = await call('DOM.getDocument');
  const {nodeId} = await call('DOM.querySelector', {nodeId: root.nodeId, selector: '#files'});
  await call('DOM.setFileInputFiles', {nodeId, files});
};
const open = async query => {
  await call('Page.navigate', {url: `${pathToFileURL(page)}?${query}`});
  await until("document.readyState === 'complete'");
};
const isReady = "!document.getElementById('run').disabled";

// The same requests as the page's worker sends.
function nativeRun(environment) {
  const requests = [{do: 'load', car: 'car_sedan.obj', weights: 'detector.weights', config: 'detector.cfg', names: 'detector.names', views, seed: 1}];
  for (let index = 0; index < views; ++index) requests.push({do: 'prepare', index});
  for (let i = 0; i < steps; ++i) requests.push({do: 'step'});
  requests.push({do: 'match'}, {do: 'look', heading: 40, distance: 7.5}, {do: 'digest'});
  for (let panel = 0; panel < 3; ++panel) requests.push({do: 'see', panel});
  for (let index = 0; index < 12; ++index) requests.push({do: 'side', index, distance: 7.5});
  const run = spawnSync(native, {cwd: assets, input: requests.map(request => JSON.stringify(request) + '\n').join(''), encoding: 'utf8',
    env: {...process.env, TAPESTRY_INSTRUCTION_SET: 'portable', TAPESTRY_THREADS: '1', ...environment}, maxBuffer: 1 << 26});
  const answers = run.stdout.trim().split('\n').map(line => JSON.parse(line));
  const failed = answers.find(answer => answer.error);
  if (failed || answers.length !== requests.length) throw new Error(`the native program failed: ${failed ? failed.error : run.stderr}`);
  const sides = name => answers.slice(-12).filter(side => side[name]).length;
  return {losses: answers.slice(1 + views, 1 + views + steps).map(answer => answer.loss), sha256: answers.at(-16).sha256,
    confidences: answers.slice(-15, -12).map(answer => answer.confidence.toFixed(2)), sides: ['plain', 'noise', 'paint'].map(sides)};
}

async function optimise() {
  await resize(1280, 900);
  await open(`views=${views}&steps=${steps}`);
  await until(isReady);
  await click('run');
  await until("document.body.dataset.sides === '12'");
  await photograph('wide');
  check(await value("[...document.querySelectorAll('canvas')].every(c => c.getAttribute('role') === 'img' && c.getAttribute('aria-label'))"),
    'every drawing has words');
  check(await value(`[...document.querySelectorAll('.panels figure:has(.found) canvas')].every(c => parseFloat(c.getContext('2d').font.match(/[0-9.]+px/)) *
    c.clientWidth >= 12.9 * c.width)`), 'the words at boxes have 13 pixels of the page');
  const verdicts = await value("['plain', 'noise', 'paint'].map(id => document.querySelector('#' + id + ' .verdict').textContent.slice(-4))");
  const shown = await value("['plain', 'noise', 'paint'].map(id => document.getElementById('sides-' + id).textContent)");
  return {losses: (await value('document.body.dataset.losses')).trim().split(' ').map(Number), sha256: await value('document.body.dataset.sha256'),
    confidences: verdicts, sides: shown.map(text => Number(text.split(' ')[0])), rate: Number(await value('document.body.dataset.rate'))};
}

function compare(found, expected) {
  const other = found.losses.findIndex((loss, i) => loss !== expected.losses[i]);
  check(found.losses.length === steps && other < 0, `${steps} losses have the bits of the native program` +
    (other < 0 ? '' : `: the ${other + 1}th is ${found.losses[other]}, not ${expected.losses[other]}`));
  check(found.sha256 === expected.sha256, 'the paint has the bits of the native program');
  for (const key of ['confidences', 'sides']) check(`${found[key]}` === `${expected[key]}`, `${key} plain, noise, paint: ${found[key]}; natively ${expected[key]}`);
  check(found.sides[2] < found.sides[0] / 2, 'the paint hides the car from more than half of the sides');
}

async function useKeys() {
  await call('Runtime.evaluate', {expression: 'document.activeElement.blur()'});
  const heading = await value("document.getElementById('heading').value");
  await press('ArrowRight');
  check(Number(await value("document.getElementById('heading').value")) === Number(heading) + 5, 'an arrow turns the car');
  const before = Number(await value('document.body.dataset.step'));
  await press(' ');
  await until(`Number(document.body.dataset.step) > ${before}`);
  check(true, 'space starts');
}

// A picture of 24 bits a pixel, thirds of red, green and blue from left to right.
function thirds(width, height) {
  const bytes = Buffer.alloc(54 + 3 * width * height);  // width is a multiple of 4
  bytes.write('BM');
  for (const [at, number] of [[2, bytes.length], [10, 54], [14, 40], [18, width], [22, height]]) bytes.writeUInt32LE(number, at);
  for (const [at, number] of [[26, 1], [28, 24]]) bytes.writeUInt16LE(number, at);
  for (let i = 0; i < width * height; ++i) bytes[54 + 3 * i + 2 - Math.floor(3 * (i % width) / width)] = 255;
  return bytes;
}

async function takePicture() {
  writeFileSync(folder + '/thirds.bmp', thirds(192, 64));
  await value("document.querySelector('#plain canvas').width = 0");
  await choose([`${folder}/thirds.bmp`]);
  await until("document.querySelector('#plain canvas').width > 0");
  const corners = await value(`(() => {
    const canvas = document.querySelector('#plain canvas'), context = canvas.getContext('2d');
    return [2, canvas.width - 3].map(x => Array.from(context.getImageData(x, 2, 1, 1).data)); })()`);
  check(corners.every(([red, green, blue]) => red < 8 && green > 247 && blue < 8), `of a wide picture the middle is shown: ${corners}`);
}

async function takeOnnx() {
  const onnx = new URL('../../../shared/data/detectors/yolox_nano.onnx', import.meta.url).pathname;
  if (!existsSync(onnx)) return console.log('an ONNX detector: skipped, there is none');
  await open('views=2');
  await until(isReady);
  await choose([onnx]);
  await until("document.getElementById('status').textContent.startsWith('Drawing')");
  await until(isReady);
  await click('run');
  await until("Number(document.body.dataset.step) > 0");
  check(true, 'an ONNX detector is taken, and a paint optimised against it');
}

async function takeFiles() {
  copyFileSync(assets + 'detector.weights', folder + '/other.weights');
  copyFileSync(assets + 'detector.cfg', folder + '/other.cfg');
  writeFileSync(folder + '/broken.obj', 'v 0 0 zero\n');
  writeFileSync(folder + '/huge.cfg', `${readFileSync(assets + 'detector.cfg')}`.replace(/=256/g, '=16384'));
  await choose([`${assets}car_hatchback.obj`, `${assets}car_hatchback.mtl`, `${folder}/other.weights`, `${folder}/other.cfg`]);
  await until("document.getElementById('status').textContent.startsWith('Drawing')");
  await until(isReady);
  check(true, 'another car and a Darknet detector are taken');
  await choose([`${folder}/wide.png`]);
  await until("document.getElementById('status').textContent.startsWith('Drawing')");
  await until(isReady);
  await photograph('picture');
  await takePicture();
  const refused = async (files, part) => {
    await value("document.getElementById('status').classList.remove('failed')");
    await choose(files);
    await until("document.getElementById('status').classList.contains('failed')");
    const text = await value("document.getElementById('status').textContent");
    check(text.includes(part), `refused: ${text}`);
  };
  await refused([`${folder}/broken.obj`], 'broken.obj:1: ');
  await refused([`${folder}/other.weights`, `${folder}/huge.cfg`], 'output too large; expected at most 268435455 elements');
}

try {
  const found = await optimise();
  console.log(`${found.rate} images/s in Chromium, on one thread`);
  check(found.rate >= 25, 'at least 25 images/s');
  compare(found, nativeRun(libm ? {LD_PRELOAD: libm} : {}));
  await resize(390, 844);
  check(await value('document.documentElement.scrollWidth') <= 390, 'nothing is wider than 390 pixels');
  await photograph('narrow');
  await useKeys();
  await takeFiles();
  await takeOnnx();
  check(logged.length === 0, `no exception in the page ${logged}`);
} catch (error) {
  check(false, error.message);
}
browser.kill();
process.exit(failures > 0 ? 1 : 0);

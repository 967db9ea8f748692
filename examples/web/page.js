// The page: shows what the worker computes, and passes on what a user wants.
'use strict';
const $ = id => document.getElementById(id);
const names = ['plain', 'noise', 'paint'], bundled = {car: 'car_sedan.obj', weights: 'detector.weights', config: 'detector.cfg', names: 'detector.names'};
const settings = Object.fromEntries(new URLSearchParams(location.search));
const worker = new Worker(URL.createObjectURL(new Blob([$('worker').textContent], {type: 'text/javascript'})));
let chosen = {...bundled}, picture = null, sound = {chosen, picture}, isRunning = false, isReady = false, extents = null, points = [], levels = {};

const say = (text, isFailure = false) => {
  $('status').textContent = text;
  $('status').classList.toggle('failed', isFailure);
};

function load(files = {}) {
  [isReady, points, levels] = [false, [], {}];
  setRunning(false);
  for (const name of names) $('sides-' + name).textContent = '–';
  $('sides-caption').textContent = 'Found from twelve sides: after a pause';
  const request = {...chosen, ...picture, views: Number(settings.views || 240), seed: Number(settings.seed || 1), steps: Number(settings.steps || 0)};
  worker.postMessage({do: 'load', files, request});
  look();
}

function look() {
  const [heading, distance] = [Number($('heading').value), Number($('distance').value)];
  $('heading-text').textContent = heading + '°';
  $('distance-text').textContent = distance + ' m';
  points = [];  // of another view
  worker.postMessage({do: 'look', heading, distance});
}

function setRunning(running) {
  isRunning = running;
  $('status').ariaLive = running ? 'off' : 'polite';  // which steps would flood
  $('run').textContent = running ? 'Pause' : 'Start';
  $('run').disabled = $('again').disabled = !isReady;
}

function toggle() {
  if (!isReady) return;
  setRunning(!isRunning);
  worker.postMessage({do: isRunning ? 'run' : 'pause'});
}

const colour = name => getComputedStyle(document.documentElement).getPropertyValue('--' + name);

// Lines and words are as large on the page as a reader needs, however small the picture is.
function drawBox(context, scale, pixel, [left, top, width, height, confidence, isCar, name]) {
  context.strokeStyle = context.fillStyle = isCar ? '#28dc3c' : '#ff4f3d';
  context.lineWidth = 2 * pixel;
  context.strokeRect(left * scale, top * scale, width * scale, height * scale);
  const text = name + ' ' + confidence.toFixed(2);
  context.font = `600 ${13 * pixel}px system-ui, sans-serif`;
  const wide = context.measureText(text).width + 8 * pixel;
  const x = Math.max(0, Math.min(left * scale - 1, extents.width * scale - wide));
  const y = Math.max(0, top * scale - 18 * pixel);
  context.fillRect(x, y, wide, 18 * pixel);
  context.fillStyle = '#000';
  context.fillText(text, x + 4 * pixel, y + 13 * pixel);
}

async function drawSeen({panel, step, pixels, found, confidence, boxes}) {
  const name = names[panel], figure = $(name), canvas = figure.querySelector('canvas'), scale = Math.max(1, 512 / extents.width);
  const image = new ImageData(new Uint8ClampedArray(pixels), extents.width, extents.height);
  const bitmap = await createImageBitmap(image);
  canvas.width = extents.width * scale;
  canvas.height = extents.height * scale;
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  for (const box of boxes) drawBox(context, scale, canvas.width / canvas.clientWidth, box);
  const verdict = figure.querySelector('.verdict');
  verdict.classList.toggle('found', found);
  verdict.innerHTML = `<b>${found ? 'found' : 'not found'}</b>, best confidence ${confidence.toFixed(2)}`;
  canvas.setAttribute('aria-label', `${name}: ${found ? 'found' : 'not found'}`);
  if (name === 'paint') points.push([step, confidence]);
  else levels[name] = confidence;
  drawCurve();
}

function drawCurve() {
  const canvas = $('curve'), ratio = devicePixelRatio || 1, [width, height] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = width * ratio;
  canvas.height = height * ratio;
  const context = canvas.getContext('2d');
  context.scale(ratio, ratio);
  context.font = '13px system-ui, sans-serif';
  const last = points.length ? points[points.length - 1][0] : 0, first = points.length ? points[0][0] : 0;
  const end = Math.max(40, last), room = {left: 34, right: 8, top: 8, bottom: 22};
  const x = step => room.left + (width - room.left - room.right) * (step - first) / Math.max(1, end - first);
  const y = value => room.top + (height - room.top - room.bottom) * (1 - value);
  const line = (list, style, dash = [], thick = 2) => {
    context.beginPath();
    for (const [step, value] of list) context.lineTo(x(step), y(value));
    Object.assign(context, {strokeStyle: style, lineWidth: thick});
    context.setLineDash(dash);
    context.stroke();
  };
  context.fillStyle = colour('soft');
  for (const value of [0, 0.25, 0.5, 0.75, 1]) {
    line([[first, value], [end, value]], colour(value === 0.25 ? 'soft' : 'line'), [], 1);
    context.fillText(value.toString(), 2, y(value) + 4);
  }
  context.fillText('step ' + first, room.left, height - 5);
  context.fillText(String(end), width - 8 - context.measureText(String(end)).width, height - 5);
  for (const name of ['plain', 'noise']) {
    if (!(name in levels)) continue;
    line([[first, levels[name]], [end, levels[name]]], colour(name), [6, 4]);
    context.fillStyle = colour(name);
    context.fillText(name, x(end) - (name === 'plain' ? 40 : 90), y(levels[name]) + (levels[name] > 0.9 ? 15 : -5));
  }
  line(points, colour('paint'), [], 2.5);
  if (points.length) context.fillStyle = colour('paint'), context.fillText('paint', Math.min(x(last) + 4, width - 40),
    y(points[points.length - 1][1]) + (points[points.length - 1][1] > 0.9 ? 30 : -6));
}

const heard = {
  ready: () => load(),
  loaded: message => {
    extents = message;
    sound = {chosen, picture};
    say('Drawing views to optimise in …');
  },
  prepared: ({prepared, of}) => {
    say(`Drawing views to optimise in: ${prepared} of ${of}`);
    if (prepared < of) return;
    isReady = true;
    setRunning(false);
    say('Ready.');
    if (settings.start) toggle();
  },
  step: message => {
    say(`Step ${message.step}: ${message.rate.toFixed(0)} images/s, loss ${message.loss.toFixed(3)}`);
    Object.assign(document.body.dataset, {step: message.step, rate: message.rate.toFixed(1), losses: (document.body.dataset.losses || '') + message.loss + ' '});
  },
  seen: drawSeen,
  paused: ({step, sha256}) => {
    setRunning(false);
    document.body.dataset.sha256 = sha256;
    $('sides-caption').textContent = `Found from twelve sides, after step ${step}`;
  },
  sides: ({of, found}) => {
    for (const name of names) $('sides-' + name).textContent = `${found[name]} of ${of}`;
    document.body.dataset.sides = of;
  },
  failed: ({text}) => {
    setRunning(false);
    say(text, true);
    if (isReady) return;
    ({chosen, picture} = sound);
    $('again').disabled = false;
  },
};
worker.onmessage = ({data}) => heard[data.kind](data);
worker.onerror = event => say('The browser cannot run this page: ' + event.message, true);

async function pixelsOf(file) {
  const bitmap = await createImageBitmap(file), {width, height} = extents;
  const canvas = document.createElement('canvas');
  Object.assign(canvas, {width, height});
  const context = canvas.getContext('2d'), scale = Math.max(width / bitmap.width, height / bitmap.height);
  const [wide, high] = [bitmap.width * scale, bitmap.height * scale];  // cut at the edges to the detector's form
  context.drawImage(bitmap, (width - wide) / 2, (height - high) / 2, wide, high);
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

// Files replace the bundled ones of their kind.
async function take(list) {
  const files = {}, endings = {};
  chosen = {...chosen};
  for (const file of list) {
    const ending = file.name.toLowerCase().split('.').pop();
    if (file.type.startsWith('image/')) {
      const image = await pixelsOf(file);
      files.picture = image.data.buffer;
      picture = {picture: 'picture', height: image.height, width: image.width};
    } else {
      files[file.name] = await file.arrayBuffer();
      endings[ending] = file.name;
    }
  }
  if (endings.obj) chosen.car = endings.obj;
  if (endings.onnx) Object.assign(chosen, {weights: endings.onnx, config: '', names: endings.names || ''});
  if (endings.weights) Object.assign(chosen, {weights: endings.weights, config: endings.cfg || '', names: endings.names || ''});
  say('Loading …');
  load(files);
}

$('run').onclick = toggle;
$('again').onclick = () => load();
$('heading').oninput = $('distance').oninput = look;
$('files').onchange = event => take(event.target.files).catch(error => say(error.message, true));
addEventListener('dragover', event => {
  event.preventDefault();
  $('drop').classList.add('over');
});
addEventListener('dragleave', () => $('drop').classList.remove('over'));
addEventListener('drop', event => {
  event.preventDefault();
  $('drop').classList.remove('over');
  take(event.dataTransfer.files).catch(error => say(error.message, true));
});
addEventListener('resize', drawCurve);
addEventListener('keydown', event => {
  if (event.target.matches('button, input')) return;
  const moves = {ArrowLeft: ['heading', -5], ArrowRight: ['heading', 5], ArrowUp: ['distance', -0.5], ArrowDown: ['distance', 0.5]};
  if (event.key === ' ') toggle();
  else if (moves[event.key]) {
    const [id, by] = moves[event.key], turn = id === 'heading' ? 360 : 0;
    $(id).value = turn ? (Number($(id).value) + by + turn) % turn : Number($(id).value) + by;
    look();
  } else return;
  event.preventDefault();
});

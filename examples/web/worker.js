// Runs the C++ side beside the page, which stays responsive: a piece of work at a time, and messages between them.
'use strict';
const panels = ['plain', 'noise', 'paint'];
const stepsBetweenNoises = 10, sides = 12, secondsOfRate = 3;
let core = null, setup = null, prepared = 0, view = {heading: 0, distance: 8}, isRunning = false, step = 0, stopAt = Infinity;
let mustLook = false, mustShow = [], nextSide = sides, found = null, timed = [];

function ask(request) {
  const result = JSON.parse(core.ccall('answer', 'string', ['string'], [JSON.stringify(request)]));
  if (result.error) throw new Error(result.error);
  return result;
}

function load({files, request}) {
  for (const [name, bytes] of Object.entries(files)) core.FS.writeFile(name, new Uint8Array(bytes));
  setup = null;
  const loaded = ask({do: 'load', ...request});
  [setup, prepared, step, stopAt, timed] = [loaded, 0, 0, request.steps || Infinity, []];
  [mustLook, isRunning, nextSide] = [true, false, sides];
  postMessage({kind: 'loaded', ...setup});
}

function show(panel) {
  const seen = ask({do: 'see', panel});
  const begin = core._pixels(panel), size = 4 * setup.width * setup.height;
  postMessage({kind: 'seen', panel, step, pixels: core.HEAPU8.slice(begin, begin + size).buffer, ...seen});
}

function takeStep() {
  const begun = performance.now();
  const taken = ask({do: 'step'});
  const now = performance.now();
  timed = [...timed.filter(piece => now - piece.now < 1000 * secondsOfRate), {now, ms: now - begun, images: taken.images}];
  const total = key => timed.reduce((sum, piece) => sum + piece[key], 0);
  step = taken.step;
  postMessage({kind: 'step', rate: 1000 * total('images') / total('ms'), ...taken});
  mustShow.push(2);
  if (step % stepsBetweenNoises === 0) ask({do: 'match'}), mustShow.push(1);
  if (step >= stopAt) pause();
}

function pause() {
  isRunning = false;
  [nextSide, found] = [0, {plain: 0, noise: 0, paint: 0}];
  postMessage({kind: 'paused', step, ...ask({do: 'digest'})});
}

function lookAtSide() {
  const side = ask({do: 'side', index: nextSide++, distance: view.distance});
  for (const panel of panels) found[panel] += side[panel] ? 1 : 0;
  postMessage({kind: 'sides', of: nextSide, found});
}

// Does what is wanted most. Returns whether more is to be done.
function work() {
  if (!setup) return false;
  if (mustLook) {
    mustLook = false;
    ask({do: 'look', ...view});
    mustShow = [0, 1, 2];
  } else if (mustShow.length > 0) {
    show(mustShow.shift());
  } else if (prepared < setup.views) {
    ask({do: 'prepare', index: prepared++});
    postMessage({kind: 'prepared', prepared, of: setup.views});
  } else if (isRunning) {
    takeStep();
  } else if (nextSide < sides) {
    lookAtSide();
  } else {
    return false;
  }
  return true;
}

let isScheduled = false;
const guarded = body => {
  try {
    return body();
  } catch (error) {
    isRunning = false;
    postMessage({kind: 'failed', text: error.message || String(error)});
    return false;
  }
};
const channel = new MessageChannel();  // unlike a timer, it does not wait 4 ms
const schedule = () => {
  if (!isScheduled) channel.port2.postMessage(isScheduled = true);
};
channel.port1.onmessage = () => {
  isScheduled = false;
  if (guarded(work)) schedule();
};

onmessage = ({data}) => guarded(() => {
  if (data.do === 'load') load(data);
  if (data.do === 'look') [view, mustLook] = [{heading: data.heading, distance: data.distance}, true];
  if (data.do === 'run') [isRunning, nextSide] = [true, sides];
  if (data.do === 'pause' && isRunning) pause();
  schedule();
});

Tapestry().then(made => {
  core = made;
  postMessage({kind: 'ready'});
});

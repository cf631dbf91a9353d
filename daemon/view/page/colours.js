'use strict';
// Colour scales, the same everywhere, with their legends. Both are perceptually even and read by the colour-blind:
// viridis (van der Walt and Smith, 2015) for distance, cividis (Nuñez, Anderton and Renslow, 2018) for everything else.

const viridis = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129], [92, 200, 99],
  [170, 220, 50], [253, 231, 37]];
const cividis = [[0, 32, 77], [0, 51, 111], [57, 72, 107], [87, 92, 109], [112, 113, 115], [138, 135, 121], [166, 157, 117],
  [196, 181, 108], [228, 207, 91], [255, 234, 70]];

/** Colour [r, g, b] of a scale at 0 … 1. */
function scaleColour(scale, share) {
  const at = Math.min(1, Math.max(0, share)) * (scale.length - 1), i = Math.min(scale.length - 2, Math.floor(at));
  return scale[i].map((v, k) => Math.round(v + (at - i) * (scale[i + 1][k] - v)));
}

const cssColour = rgb => `rgb(${rgb.join(',')})`;

/** What returns are coloured by: the scale, the share of a value, and where its legend has numbers. */
const quantities = {
  range: {name: 'distance from the lidar', unit: 'm', scale: viridis, ticks: [2, 5, 10, 20, 50, 80],
    // Near is bright. Logarithmic: what is twice as far differs as much everywhere. The darkest tenth is not used.
    share: r => 1 - 0.9 * Math.min(1, Math.max(0, Math.log(r / 2) / Math.log(40)))},
  height: {name: 'height above ground', unit: 'm', scale: cividis, ticks: [-1, 0, 1, 2, 3, 4, 5, 6],
    share: z => 0.1 + 0.9 * Math.min(1, Math.max(0, (z + 1) / 7))},
  reflectivity: {name: 'reflectivity', unit: '%', scale: cividis, ticks: [0, 5, 20, 50, 100],
    share: v => 0.1 + 0.9 * Math.sqrt(Math.min(1, v / 100))},
  ring: {name: 'ring, from below', unit: '', scale: cividis, ticks: [0, 0.25, 0.5, 0.75, 1], share: v => 0.1 + 0.9 * v},
};

/** 256 colours of a quantity's scale, for a table or a texture. */
function scaleTable(scale) {
  const table = new Uint8Array(4 * 256);
  for (let i = 0; i < 256; ++i) table.set([...scaleColour(scale, i / 255), 255], 4 * i);
  return table;
}

/** A bar with the colours of a quantity and numbers below; `label` makes a number's text. */
function scaleLegend(quantity, label = String) {
  const bar = element('span', {class: 'bar'}), shares = quantity.ticks.map(quantity.share);
  const [low, high] = [Math.min(...shares), Math.max(...shares)], falls = shares[0] > shares.at(-1);
  const stops = Array.from({length: 17}, (_, i) => cssColour(scaleColour(quantity.scale, low + (high - low) * (falls ? 1 - i / 16 : i / 16))));
  bar.style.background = `linear-gradient(to right, ${stops.join(',')})`;
  quantity.ticks.forEach((tick, i) => {
    const number = element('span', {class: 'tick'}, label(tick)), at = (shares[i] - low) / (high - low);
    number.style.left = `${100 * (falls ? 1 - at : at)}%`;
    bar.append(number);
  });
  return element('span', {class: 'scale-legend'}, element('span', {}, quantity.unit ? `${quantity.name}, ${quantity.unit}` : quantity.name), bar);
}

/** Levels and states: symbol and class, so that no meaning is in the colour alone. */
const marks = {good: '✓', warn: '!', bad: '✕', idle: '…'};
const levelClass = {OK: 'good', WARN: 'warn', ERROR: 'bad', STALE: 'bad', TRACKING: 'good', UNSURE: 'warn', LOST: 'bad',
  MONITORING: 'idle', LEARNING: 'idle', SUSPECTED: 'warn', CONFIRMED: 'bad', RECALIBRATED: 'warn', RECALIBRATING: 'bad', UNUSABLE: 'bad'};

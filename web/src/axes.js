// The axes of a panel: uPlot's, with ticks and names as in the printed figures.

import { linearTick, logarithmicTicks } from "./numbers.js";

const letters = '"DejaVu Sans", Verdana, system-ui, sans-serif';
const tickFont = `12px ${letters}`;
const labelFont = `13px ${letters}`;
const ink = "#222222";
const faint = "#e4e4e4";

const measure = document.createElement("canvas").getContext("2d");

function widest(texts) {
  measure.font = tickFont;
  return Math.max(0, ...texts.map((text) => measure.measureText(text ?? "").width));
}

const decades = (low, high) => Math.log10(high / low);

/** Multiples of 1, 2 or 5 times a power of ten, about `count` of them. */
function roundSteps(low, high, count) {
  const rough = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * [1, 2, 5, 10].find((factor) => factor * power >= rough);
  const steps = [];
  for (let i = Math.ceil(low / step); i * step <= high; ++i) steps.push(i * step);
  return steps;
}

/** Every digit of every decade; where less than a decade is shown, round steps. */
function logarithmicSplits(low, high, pixels) {
  if (decades(low, high) < 1) return roundSteps(low, high, Math.max(2, pixels / 90));
  const splits = [];
  for (let n = Math.floor(Math.log10(low)); n <= Math.log10(high); ++n)
    for (let digit = 1; digit < 10; ++digit) {
      const value = Number(`${digit}e${n}`);
      if (value >= low && value <= high) splits.push(value);
    }
  return splits;
}

/** Of those, the ones with a number and a grid line: decades, where they are far apart also 2 and 5. */
function labelledSplits(splits, low, high, pixels, room) {
  const span = decades(low, high);
  if (span < 1) return splits;
  const perDecade = pixels / span;
  const every = Math.max(1, Math.ceil(room / perDecade));
  return splits.map((value) => {
    const exponent = Math.floor(Math.log10(value) + 1e-9);
    const digit = Math.round(value / 10 ** exponent);
    const between = perDecade > 4.5 * room && (digit === 2 || digit === 5);
    return (digit === 1 && exponent % every === 0) || between ? value : null;
  });
}

export function axisOptions(scale, axis) {
  const across = scale === "x";
  const options = {
    scale,
    label: axis.label || null,
    labelFont,
    labelSize: across ? 22 : 24,
    labelGap: 2,
    font: tickFont,
    stroke: ink,
    gap: 4,
    grid: { stroke: faint, width: 1 },
    ticks: { stroke: "#444444", width: 1, size: 5 },
    border: { show: true, stroke: "#444444", width: 1 },
    space: across ? 62 : 34,
  };
  const pixels = (u) => (across ? u.bbox.width : u.bbox.height) / devicePixelRatio;
  if (axis.names.length > 0) {
    options.splits = () => axis.names.map((_, i) => i + 1);
    options.values = () => axis.names;
  } else if (axis.logarithmic) {
    const room = across ? 44 : 24;
    const filter = (u, splits) =>
      labelledSplits(splits, u.scales[scale].min, u.scales[scale].max, pixels(u), room);
    options.splits = (u, _, low, high) => logarithmicSplits(low, high, pixels(u));
    options.filter = options.grid.filter = filter;
    options.values = (u, splits) =>
      logarithmicTicks(splits.map((value) => (value == null ? null : value * 10 ** axis.exponent)));
  } else {
    options.values = (u, splits, _, space, step) => splits.map((value) => linearTick(value, step));
  }
  if (across) options.size = 30;
  else
    options.size = (u, values) =>
      Math.min(Math.max(50, Math.ceil(widest(values ?? [])) + 14), Math.max(60, 0.45 * u.width));
  return options;
}

export { labelFont, letters, tickFont };

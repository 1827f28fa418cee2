// What the curves of a panel look like. Lines and steps are uPlot's own; the rest are paths of ours
// in its hands. Points beyond the view go no further than a canvas can follow.

import uPlot from "uplot";

const farthest = 1e6; // canvas pixels

function pixelsOf(u) {
  const near = (value) => Math.max(-farthest, Math.min(farthest, value));
  return [(x) => near(u.valToPos(x, "x", true)), (y) => near(u.valToPos(y, "y", true))];
}

/** Where stems and areas stand: zero, or the bottom of a logarithmic axis. */
export function footOf(u, axis) {
  return axis.logarithmic ? u.scales.y.min : 0;
}

/** A mix of the colour with white, opaque: what lies on it can be told from it. */
function lightened(colour, share) {
  const part = (at) => Math.round(255 + share * (parseInt(colour.slice(at, at + 2), 16) - 255));
  return `rgb(${part(1)},${part(3)},${part(5)})`;
}

function transparent(colour, share) {
  return colour + Math.round(255 * share).toString(16).padStart(2, "0");
}

/** The polygon cut to a box somewhat larger than the view (Sutherland and Hodgman 1974). */
function clipped(corners, box) {
  const sides = [
    [0, box.left, 1],
    [0, box.right, -1],
    [1, box.top, 1],
    [1, box.bottom, -1],
  ];
  for (const [axis, limit, sign] of sides) {
    const inside = (p) => sign * (p[axis] - limit) >= 0;
    corners = corners.flatMap((to, i) => {
      const from = corners[(i + corners.length - 1) % corners.length];
      if (inside(from) === inside(to)) return inside(to) ? [to] : [];
      const share = (limit - from[axis]) / (to[axis] - from[axis]);
      const cut = [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])];
      return inside(to) ? [cut, to] : [cut];
    });
  }
  return corners;
}

function loopPath(curve) {
  return (u) => {
    const { left, top, width, height } = u.bbox;
    const margin = 100;
    const box = {
      left: left - margin,
      right: left + width + margin,
      top: top - margin,
      bottom: top + height + margin,
    };
    const corners = curve.x
      .map((x, i) => [u.valToPos(x, "x", true), u.valToPos(curve.y[i], "y", true)])
      .filter(([x, y]) => Number.isFinite(x) && Number.isFinite(y));
    const path = new Path2D();
    clipped(corners, box).forEach(([x, y], i) => (i === 0 ? path.moveTo(x, y) : path.lineTo(x, y)));
    path.closePath();
    return { stroke: path, fill: path };
  };
}

/** For curves that go back in x. */
function freeLinePath(curve) {
  return (u) => {
    const [px, py] = pixelsOf(u);
    const path = new Path2D();
    let broken = true;
    curve.x.forEach((x, i) => {
      const y = curve.y[i];
      if (y != null) broken ? path.moveTo(px(x), py(y)) : path.lineTo(px(x), py(y));
      broken = y == null;
    });
    return { stroke: path, fill: null };
  };
}

function pointsPath(curve) {
  return (u) => {
    const [px, py] = pixelsOf(u);
    const radius = 2.5 * devicePixelRatio;
    const path = new Path2D();
    curve.x.forEach((x, i) => {
      if (curve.y[i] == null) return;
      path.moveTo(px(x) + radius, py(curve.y[i]));
      path.arc(px(x), py(curve.y[i]), radius, 0, 2 * Math.PI);
    });
    return { stroke: null, fill: path };
  };
}

function impulsesPath(curve, axis) {
  return (u) => {
    const [px, py] = pixelsOf(u);
    const path = new Path2D();
    curve.x.forEach((x, i) => {
      if (curve.y[i] == null) return;
      path.moveTo(px(x), py(footOf(u, axis)));
      path.lineTo(px(x), py(curve.y[i]));
    });
    return { stroke: path, fill: null };
  };
}

/** Each unbroken run there along the top and back along the bottom. */
function bandPath(curve) {
  return (u) => {
    const [px, py] = pixelsOf(u);
    const path = new Path2D();
    for (let from = 0; from < curve.x.length; ++from) {
      if (curve.y[from] == null) continue;
      let to = from;
      while (to + 1 < curve.x.length && curve.y[to + 1] != null) ++to;
      path.moveTo(px(curve.x[from]), py(curve.y[from]));
      for (let i = from + 1; i <= to; ++i) path.lineTo(px(curve.x[i]), py(curve.y[i]));
      for (let i = to; i >= from; --i) path.lineTo(px(curve.x[i]), py(curve.y_low[i]));
      path.closePath();
      from = to;
    }
    return { stroke: null, fill: path };
  };
}

/** On whole pixels, that neighbours of different colours leave no seam. */
function boxesPath(curve) {
  return (u) => {
    const [px, py] = pixelsOf(u);
    const path = new Path2D();
    curve.x.forEach((x, i) => {
      const left = Math.round(px(x));
      const top = Math.round(py(curve.y[i]));
      const right = Math.round(px(curve.x_high[i]));
      path.rect(left, top, right - left, Math.round(py(curve.y_low[i])) - top);
    });
    return { stroke: null, fill: path };
  };
}

/** uPlot's options for how a curve of the panel is drawn. */
export function curveLook(curve, yAxis) {
  const dashes = (...lengths) => lengths.map((length) => length * devicePixelRatio);
  const line = { stroke: curve.colour, width: 2, fill: null };
  const filled = { stroke: null, width: 0, fill: transparent(curve.colour, 0.18) };
  const straight = curve.sorted ? uPlot.paths.linear() : freeLinePath(curve);
  switch (curve.style) {
    case "dashed":
      return { ...line, dash: dashes(8, 5), paths: straight };
    case "dotted":
      return { ...line, dash: dashes(2, 4), paths: straight };
    case "steps":
      return { ...line, width: 1.5, paths: uPlot.paths.stepped({ align: 1 }) };
    case "points":
      // No stroke, but as wide as the points: so far beyond the frame they are not cut.
      return { stroke: null, width: 6, fill: curve.colour, paths: pointsPath(curve) };
    case "impulses":
      return { ...line, paths: impulsesPath(curve, yAxis) };
    case "area":
      return { ...filled, paths: uPlot.paths.linear(), fillTo: (u) => footOf(u, yAxis) };
    case "band":
      return { ...filled, paths: bandPath(curve) };
    case "boxes":
      return { stroke: null, width: 0, fill: lightened(curve.colour, 0.45), paths: boxesPath(curve) };
    case "disk":
      return { ...line, fill: filled.fill, paths: loopPath(curve) };
    case "circle":
      return { ...line, paths: loopPath(curve) };
    default:
      return { ...line, paths: straight };
  }
}

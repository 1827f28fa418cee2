// Which sample of each curve the pointer means.

const within = 24; // CSS pixels: a lone sample answers up to here

/** Index of the last x that is not above the value; −1 where all are. */
function lastNotAbove(xs, value) {
  let low = -1;
  let high = xs.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (xs[middle] <= value) low = middle;
    else high = middle;
  }
  return low;
}

function nearestAlongX(u, curve, left) {
  const before = lastNotAbove(curve.x, u.posToVal(left, "x"));
  const shown = (i) => i >= 0 && i < curve.x.length && curve.y[i] != null;
  const distance = (i) => Math.abs(u.valToPos(curve.x[i], "x") - left);
  // On a line between two samples one of them answers, however far; a step is its first sample.
  if (shown(before) && shown(before + 1) && curve.style !== "points") {
    if (curve.style === "steps") return before;
    return distance(before) <= distance(before + 1) ? before : before + 1;
  }
  const near = [before, before + 1].filter((i) => shown(i) && distance(i) <= within);
  return near.sort((a, b) => distance(a) - distance(b))[0] ?? null;
}

function nearestInPlane(u, curve, left, top) {
  let best = null;
  let least = within;
  curve.x.forEach((x, i) => {
    if (curve.y[i] == null) return;
    const far = Math.hypot(u.valToPos(x, "x") - left, u.valToPos(curve.y[i], "y") - top);
    if (far < least) [best, least] = [i, far];
  });
  return best;
}

function boxAround(u, curve, left, top) {
  const x = u.posToVal(left, "x");
  const y = u.posToVal(top, "y");
  const at = curve.x.findIndex(
    (low, i) => low <= x && x < curve.x_high[i] && curve.y_low[i] <= y && y < curve.y[i],
  );
  return at < 0 ? null : at;
}

/** Of a band that goes back in x, such as bars one under the other: the nearer end of the piece around the pointer. */
function bandEndAround(u, curve, left, top) {
  const x = u.posToVal(left, "x");
  const y = u.posToVal(top, "y");
  for (let i = 0; i + 1 < curve.x.length; ++i) {
    if (curve.y[i] == null || curve.y[i + 1] == null) continue;
    const share = (x - curve.x[i]) / (curve.x[i + 1] - curve.x[i]);
    const between = (column) => column[i] + share * (column[i + 1] - column[i]);
    if (share >= 0 && share <= 1 && between(curve.y_low) <= y && y <= between(curve.y))
      return share < 0.5 ? i : i + 1;
  }
  return null;
}

/** Index of the curve's sample that the pointer at a place [CSS pixels] means, or null. */
export function sampleAt(u, curve, left, top) {
  if (curve.style === "disk" || curve.style === "circle") return null;
  if (curve.style === "boxes") return boxAround(u, curve, left, top);
  if (curve.sorted) return nearestAlongX(u, curve, left);
  return (curve.style === "band" ? bandEndAround : nearestInPlane)(u, curve, left, top);
}

// What part of a panel is in view.

const finest = 1e-5; // of the whole range

const forward = (value, logarithmic) => (logarithmic ? Math.log(value) : value);
const backward = (value, logarithmic) => (logarithmic ? Math.exp(value) : value);

/** The range scaled about `centre`, a share of it; never finer than the data are. */
function scaledRange([low, high], home, logarithmic, factor, centre) {
  const [a, b] = [forward(low, logarithmic), forward(high, logarithmic)];
  const [homeLow, homeHigh] = home.map((value) => forward(value, logarithmic));
  const whole = homeHigh - homeLow;
  const span = Math.min(whole, Math.max(finest * whole, factor * (b - a)));
  const at = a + centre * (b - a);
  // Not beyond what there is to see.
  const start = Math.min(Math.max(at - centre * span, homeLow), homeHigh - span);
  return [backward(start, logarithmic), backward(start + span, logarithmic)];
}

function fineEnough([low, high], home, logarithmic) {
  const span = (range) => forward(range[1], logarithmic) - forward(range[0], logarithmic);
  return span([low, high]) >= finest * span(home);
}

/** Lengths of a pixel along both axes, in the same unit. */
function unitsPerPixel(u, panel, view) {
  const along = (key, pixels) =>
    ((view[key][1] - view[key][0]) * 10 ** panel[key].exponent) / pixels;
  return { x: along("x", u.bbox.width), y: along("y", u.bbox.height) };
}

/** Whether one unit of x is as long as one of y, where the panel asks for it. */
export function hasAspect(u, panel) {
  if (!panel.equal_aspect) return true;
  const { x, y } = unitsPerPixel(u, panel, currentView(u));
  return Math.abs(x / y - 1) < 0.005;
}

/** The whole panel: as in the printed figure, and with equal scales where the panel has them. */
function homeView(u, panel) {
  return withAspect(u, panel, { x: [panel.x.low, panel.x.high], y: [panel.y.low, panel.y.high] });
}

/** With equal scales, the range that is too short for the frame is widened. */
function withAspect(u, panel, view) {
  const { width, height } = u.bbox;
  if (!panel.equal_aspect || !(width > 0) || !(height > 0)) return view;
  const perPixel = unitsPerPixel(u, panel, view);
  const longest = Math.max(perPixel.x, perPixel.y);
  const widened = ([low, high], factor) => {
    const half = 0.5 * factor * (high - low);
    return [0.5 * (low + high) - half, 0.5 * (low + high) + half];
  };
  return { x: widened(view.x, longest / perPixel.x), y: widened(view.y, longest / perPixel.y) };
}

const currentView = (u) => ({
  x: [u.scales.x.min, u.scales.x.max],
  y: [u.scales.y.min, u.scales.y.max],
});

const differs = ([a, b], [c, d]) => Math.abs(a - c) + Math.abs(b - d) > 1e-9 * Math.abs(d - c);

/** Shows `view`, or without one the whole panel. */
export function show(plot, view = null) {
  const { u, panel } = plot;
  const home = homeView(u, panel);
  const fitted = view == null ? home : withAspect(u, panel, view);
  plot.zoomed = differs(fitted.x, home.x) || differs(fitted.y, home.y);
  u.batch(() => {
    for (const key of ["x", "y"]) u.setScale(key, { min: fitted[key][0], max: fitted[key][1] });
  });
  plot.afterZoom();
}

/** The same after the frame has changed. */
export function showAgain(plot) {
  show(plot, plot.zoomed ? currentView(plot.u) : null);
}

function showWithFellows(plot, view) {
  show(plot, view);
  for (const fellow of plot.fellows) show(fellow, { x: view.x, y: currentView(fellow.u).y });
}

export function showAll(plot) {
  show(plot);
  for (const fellow of plot.fellows)
    show(fellow, { x: homeView(fellow.u, fellow.panel).x, y: currentView(fellow.u).y });
}

/** The rectangle that was dragged; a side that was not dragged stays. */
export function showSelected(plot) {
  const { u, panel } = plot;
  const { left, top, width, height } = u.select;
  u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
  const view = currentView(u);
  if (width < u.over.clientWidth - 1)
    view.x = [u.posToVal(left, "x"), u.posToVal(left + width, "x")];
  if (height < u.over.clientHeight - 1)
    view.y = [u.posToVal(top + height, "y"), u.posToVal(top, "y")];
  const home = homeView(u, panel);
  if (
    fineEnough(view.x, home.x, panel.x.logarithmic) &&
    fineEnough(view.y, home.y, panel.y.logarithmic)
  )
    showWithFellows(plot, view);
}

/** By a factor about the cursor, or about the middle; upwards only where both axes are alike. */
export function showScaled(plot, factor) {
  const { u, panel } = plot;
  const view = currentView(u);
  const home = homeView(u, panel);
  const { left, top } = u.cursor;
  const seen = left >= 0 && top >= 0;
  const centre = { x: seen ? left / u.over.clientWidth : 0.5, y: seen ? 1 - top / u.over.clientHeight : 0.5 };
  const scaled = (key) =>
    scaledRange(view[key], home[key], panel[key].logarithmic, factor, centre[key]);
  showWithFellows(plot, { x: scaled("x"), y: panel.equal_aspect ? scaled("y") : view.y });
}

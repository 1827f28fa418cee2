// One panel of a figure as an interactive plot.

import uPlot from "uplot";
import { axisOptions } from "./axes.js";
import { drawMarkers, drawReferenceLines } from "./annotations.js";
import { sampleAt } from "./hover.js";
import { prettyNumber, prettyQuantity } from "./numbers.js";
import { curveLook } from "./paths.js";
import { hasAspect, show, showAgain, showAll, showScaled, showSelected } from "./zoom.js";

export function element(tag, className, text) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  if (text) node.textContent = text; // never markup: titles are the user's
  return node;
}

/** The curve in units of its axes: divided by their powers of ten, as uPlot works best near one. */
function inAxisUnits(curve, panel, numbers) {
  const scaled = (list, axis) =>
    list == null ? null : numbers[list].map((v) => (v == null ? null : v / 10 ** axis.exponent));
  const x = scaled(curve.x, panel.x);
  const scatter = curve.style === "points"; // of one x there may be many
  return {
    ...curve,
    x,
    y: scaled(curve.y, panel.y),
    y_low: scaled(curve.y_low, panel.y),
    x_high: scaled(curve.x_high, panel.x),
    sorted: x.every((value, i) => i === 0 || (scatter ? value > x[i - 1] : value >= x[i - 1])),
  };
}

function panelInAxisUnits(panel, numbers) {
  for (const axis of [panel.x, panel.y]) {
    // uPlot takes no range shorter than 1e-16.
    if (axis.logarithmic && axis.high < 1e-9) axis.exponent = Math.floor(Math.log10(axis.high));
    axis.low /= 10 ** axis.exponent;
    axis.high /= 10 ** axis.exponent;
  }
  const { x, y } = panel;
  const curves = panel.curves.map((curve) => inAxisUnits(curve, panel, numbers));
  // uPlot wants a curve, even where there are only points and lines.
  const none = { title: "", style: "line", colour: "#000000", x: [x.low], y: [null], sorted: true };
  return {
    ...panel,
    curves: curves.length > 0 ? curves : [none],
    markers: panel.markers.map((m) => ({ ...m, x: m.x / 10 ** x.exponent, y: m.y / 10 ** y.exponent })),
    lines: panel.lines.map((line) => ({
      ...line,
      value: line.value / 10 ** (line.vertical ? x : y).exponent,
    })),
  };
}

/** What a sample says: its y, or its extent; with its x where that is not the one on top. */
function sampleText(panel, curve, i, topX) {
  const inUnits = (axis, value) => value * 10 ** axis.exponent;
  const name = (axis, value) =>
    axis.names[Math.round(value) - 1] ?? prettyQuantity(inUnits(axis, value), axis.unit);
  const span = (axis, low, high) =>
    axis.names[Math.round(0.5 * (low + high)) - 1] ??
    `${prettyNumber(inUnits(axis, low), 4)} … ${prettyQuantity(inUnits(axis, high), axis.unit)}`;
  if (curve.style === "boxes")
    return `${span(panel.x, curve.x[i], curve.x_high[i])}; ${span(panel.y, curve.y_low[i], curve.y[i])}`;
  // A band from edge to edge only marks where something holds.
  const { low, high } = panel.y;
  const reaches = (end, edge) => Math.abs(end - edge) < 1e-5 * (high - low);
  if (curve.style === "band" && reaches(curve.y_low[i], low) && reaches(curve.y[i], high)) return "here";
  const y =
    curve.style === "band" ? span(panel.y, curve.y_low[i], curve.y[i]) : name(panel.y, curve.y[i]);
  return curve.x[i] === topX ? y : `${y} at ${name(panel.x, curve.x[i])}`;
}

/** The sample of a curve in the legend: a piece of its line, or of what it fills. */
function legendMarkers(panel) {
  const curve = (i) => panel.curves[i - 1];
  return {
    width: (u, i) => (u.series[i].stroke(u, i) == null ? 0 : 2),
    stroke: (u, i) => curve(i).colour,
    dash: (u, i) => ({ dashed: "dashed", dotted: "dotted" })[curve(i).style] ?? "solid",
    fill: (u, i) => u.series[i].fill(u, i) ?? "transparent",
  };
}

export class PanelPlot {
  /** `group` names the x axis: panels of the same one move together. */
  constructor(panel, numbers, height, group) {
    this.panel = panelInAxisUnits(panel, numbers);
    this.height = height;
    this.group = group;
    this.fellows = []; // the others of the group
    this.samples = []; // for each series, which one the pointer means
    this.topX = null;
    this.corrections = 0;
    this.node = element("div", "panel");
  }

  /** Draws into this.node, which is on the page by then: its width counts. */
  start() {
    const head = element("div", "panel-head");
    head.append(element("div", "panel-title", this.panel.title), this.makeButtons());
    this.readout = element("div", "readout", "\u00a0");
    const canvas = element("div", "canvas");
    this.node.append(head, canvas, this.readout);
    this.u = new uPlot(this.options(), this.data(), canvas);
    this.node.plot = this.u;
    this.makeAccessible();
    new ResizeObserver(() => this.fit()).observe(this.node);
    this.node.append(canvas.querySelector(".u-legend"));
  }

  data() {
    return [null, ...this.panel.curves.map((curve) => [curve.x, curve.y])];
  }

  measured() {
    const width = Math.floor(this.node.clientWidth);
    // On a phone as high as a little less than wide.
    return { width, height: Math.round(Math.min(this.height, Math.max(230, 0.8 * width))) };
  }

  fit() {
    const { width, height } = this.measured();
    if (width === 0 || (width === this.u.width && height === this.u.height)) return; // in print
    this.u.setSize({ width, height });
    showAgain(this);
  }

  /** New numbers at an axis may need more room and so change the frame, a few times at most. */
  keepAspect() {
    if (hasAspect(this.u, this.panel)) this.corrections = 0;
    else if (++this.corrections <= 4) queueMicrotask(() => showAgain(this));
  }

  options() {
    const { panel } = this;
    const scale = (key) => ({
      time: false,
      auto: false,
      distr: panel[key].logarithmic ? 3 : 1,
      log: 10,
      // Asked for at the start and when a curve is hidden, which moves nothing.
      range: (u) => {
        const { min, max } = u.scales[key];
        return min == null ? [panel[key].low, panel[key].high] : [min, max];
      },
    });
    return {
      ...this.measured(),
      mode: 2, // every curve has x of its own
      pxAlign: 0,
      scales: { x: scale("x"), y: scale("y") },
      axes: [axisOptions("x", panel.x), axisOptions("y", panel.y)],
      series: [null, ...panel.curves.map((curve) => this.series(curve))],
      legend: { live: true, markers: legendMarkers(panel) },
      cursor: {
        drag: { x: true, y: true, uni: 30, dist: 5, setScale: false },
        points: {
          size: (u, i) => (["band", "boxes"].includes(panel.curves[i - 1].style) ? 0 : 8), // no ring at an edge
          width: (u, i, size) => (size > 0 ? 1.5 : 0),
          stroke: (u, i) => panel.curves[i - 1].colour,
          fill: () => "#ffffff",
        },
        sync: {
          key: this.group,
          scales: ["x", null],
          filters: { pub: (type) => type === "mousemove", sub: (type) => type === "mousemove" },
        },
        move: (u, left, top) => {
          this.point(u, left, top);
          return [left, top];
        },
        dataIdx: (u, i) => this.samples[i] ?? null,
        bind: { dblclick: () => () => showAll(this) },
      },
      hooks: {
        drawAxes: [(u) => drawReferenceLines(u, panel)],
        ready: [() => show(this)],
        draw: [(u) => drawMarkers(u, panel), () => this.keepAspect()],
        setSelect: [() => showSelected(this)],
        setCursor: [(u) => this.showTopX(u)],
        setSeries: [() => this.tellHidden()],
      },
    };
  }

  series(curve) {
    const { panel } = this;
    const look = curveLook(curve, panel.y);
    const something = curve.y.some((value) => value != null);
    const only = something && panel.curves.length === 1;
    return {
      ...look,
      paths: something ? look.paths : () => null,
      label: curve.title || (only && (panel.y.name || "value")) || "",
      class: curve.title || only ? `style-${curve.style}` : "untitled",
      facets: [
        { scale: "x", auto: false },
        { scale: "y", auto: false },
      ],
      points: { show: false },
      value: (u, _, i, at) => (at == null ? "" : sampleText(panel, curve, at, this.topX)),
    };
  }

  /** Settles which samples the pointer means, and the x of the nearest of them. */
  point(u, left, top) {
    this.samples = [null];
    this.topX = null;
    if (left < 0 || top < 0) return;
    let least = Infinity;
    this.panel.curves.forEach((curve, i) => {
      const at = u.series[i + 1].show ? sampleAt(u, curve, left, top) : null;
      this.samples.push(at);
      if (at == null || curve.style === "boxes") return;
      const far = Math.abs(u.valToPos(curve.x[at], "x") - left);
      if (far < least) [least, this.topX] = [far, curve.x[at]];
    });
  }

  showTopX(u) {
    const { x } = this.panel;
    const left = u.cursor.left;
    const value = this.topX ?? (left >= 0 ? u.posToVal(left, "x") : null);
    const name = value == null ? null : x.names[Math.round(value) - 1];
    this.readout.textContent =
      value == null ? "\u00a0" : `${x.name} ${name ?? prettyQuantity(value * 10 ** x.exponent, x.unit)}`;
  }

  afterZoom() {
    this.allButton.disabled = !this.zoomed;
  }

  makeButtons() {
    const buttons = element("div", "buttons");
    const add = (text, label, act) => {
      const button = element("button", "", text);
      button.type = "button";
      button.title = label;
      button.setAttribute("aria-label", `${label}: ${this.panel.title || this.panel.y.name}`);
      button.addEventListener("click", act);
      buttons.append(button);
      return button;
    };
    add("+", "Zoom in", () => showScaled(this, 0.5));
    add("−", "Zoom out", () => showScaled(this, 2));
    this.allButton = add("all", "Show all", () => showAll(this));
    return buttons;
  }

  moveCursor(pixels) {
    const { u } = this;
    const from = u.cursor.left >= 0 ? u.cursor.left : 0.5 * u.over.clientWidth;
    const left = Math.max(0, Math.min(u.over.clientWidth, from + pixels));
    u.setCursor({ left, top: u.cursor.top >= 0 ? u.cursor.top : 0.5 * u.over.clientHeight });
  }

  makeAccessible() {
    const { over } = this.u;
    over.tabIndex = 0;
    over.setAttribute("role", "group");
    over.setAttribute(
      "aria-label",
      `${this.panel.title || this.panel.y.name}: arrow keys move the cursor, + and − zoom, Escape shows all`,
    );
    over.addEventListener("keydown", (event) => {
      const step = event.shiftKey ? 25 : 5;
      const acts = {
        ArrowLeft: () => this.moveCursor(-step),
        ArrowRight: () => this.moveCursor(step),
        "+": () => showScaled(this, 0.5),
        "-": () => showScaled(this, 2),
        Escape: () => showAll(this),
      };
      if (!acts[event.key] || event.ctrlKey || event.metaKey || event.altKey) return;
      acts[event.key]();
      event.preventDefault();
    });
    // A finger that moves sideways moves the cursor; upwards it scrolls the page.
    over.addEventListener("pointermove", (event) => {
      if (event.pointerType !== "touch") return;
      const box = over.getBoundingClientRect();
      this.u.setCursor({ left: event.clientX - box.left, top: event.clientY - box.top });
    });
    this.node.querySelectorAll(".u-series th").forEach((name) => {
      name.tabIndex = 0;
      name.setAttribute("role", "switch");
      name.addEventListener("keydown", (event) => {
        if (event.key !== "Enter" && event.key !== " ") return;
        name.click();
        event.preventDefault();
      });
    });
    this.tellHidden();
  }

  tellHidden() {
    this.node.querySelectorAll(".u-series").forEach((row) => {
      row.querySelector("th").setAttribute("aria-checked", String(!row.classList.contains("u-off")));
    });
  }
}
